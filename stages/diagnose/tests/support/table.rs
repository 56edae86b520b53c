//! A table of its own for measuring diagnosis: a disc that slides under dry friction, struck by an arm and seen by a camera, with
//! noise and forms that the diagnosis does not have. It shares no physics with `world` or `rig`.

use std::f64::consts::TAU;

use diagnose::{Diagnose, Diagnosis, Input};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, StudentT};
use stage::{Progress, Stage};
use values::{Command, Conditions, Point, Rig, Shape, Split, Strike, Track};
use world::World;

/// What scatters, beside launches by 2 % and 0.5° and a camera's millimetre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Noise {
    /// Nothing else.
    Ideal,
    /// Friction of each strike, relative.
    Friction(f64),
    /// Camera errors, correlated from frame to frame.
    Correlated(f64),
    /// Stamps, in s.
    Jitter(f64),
    /// Launches and camera with Student's t of three degrees of freedom.
    HeavyTails,
    /// One frame in a hundred anywhere within 10 cm.
    Stray,
    /// Launches scatter four times as much at the greatest speed.
    GrowsWithSpeed,
    /// Friction of each strike by 2 %, camera errors correlated by a half.
    Mixed,
    /// Friction of each strike by 2 %, correlation 0.5, stamps by 2 ms, stray frames.
    All,
}

/// What is hidden, in forms that the library does not have, where it says so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hidden {
    /// Nothing.
    Nothing,
    /// Wear that saturates: friction rises by this share, within 40 strikes.
    SaturatingWear(f64),
    /// A rectangle of other friction.
    Rectangle(f64),
    /// The arm saturates smoothly (tanh) at this speed in m/s.
    SoftCap(f64),
    /// a = −c·v.
    Drag(f64),
    /// Gravity's share, along both axes.
    Tilt(f64, f64),
    /// Delivered angle is off by this share of the commanded.
    AngleGain(f64),
    /// Friction rises by this share per metre along x.
    Gradient(f64),
    /// Friction is greater by this share beyond x = 0.5 m.
    Step(f64),
    /// Grain: friction greater by this share along x, as |cos|.
    Grain(f64),
    /// Friction rises at low speed, as 1/(1 + v/0.2).
    Stribeck(f64),
    /// The image is scaled by 1/(1 + l·x).
    Lean(f64),
    /// A random walk of friction from strike to strike.
    Wander(f64),
    /// A random walk of launch speed from strike to strike.
    LaunchWander(f64),
    /// From the middle strike on objects leave turned by this angle, in rad.
    TurnedHalfway(f64),
    /// A force across the velocity, in m/s² per m/s.
    Magnus(f64),
    /// The delivered speed waves with the commanded one: share of it, crest to crest in m/s.
    SpeedWave(f64, f64),
    /// The delivered angle waves with the commanded one: in rad, crest to crest in rad.
    AngleWave(f64, f64),
    /// Delivered speed, by place: share of it per metre along y.
    Reach(f64),
    /// Friction is greater by this share from the middle strike on.
    StepInOrder(f64),
    /// Friction goes up and down by this share, every so many strikes.
    CycleInOrder(f64, f64),
    /// Two objects, as drawn: one has so much more friction.
    TwoObjects(f64),
    /// Delivered angle is off by this share of the commanded, from the middle strike on.
    GainHalfway(f64),
    /// Friction waves over the table by this share, crest to crest 12 cm.
    Ripple(f64),
    /// A force across the velocity, in m/s².
    Curl(f64),
    /// The camera's clock runs slower by this share at the last strike than at the first.
    SlowingClock(f64),
    /// A lens that shows what is 1 m from its centre farther by this share, from the middle strike on.
    LensHalfway(f64),
    /// The image is longer by this share towards 30° than across it, and turned by half of that.
    Stretched(f64),
    /// Delivered angle is off by this, in rad, towards where the arm struck before.
    Backlash(f64),
}

/// What is commanded, and where strikes start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Plan {
    /// Within the robot's limits.
    Random,
    /// One angle, one speed, both, or all at one start.
    OneAngle,
    OneSpeed,
    OneCommand,
    OneStart,
    /// Four speeds by five angles, again and again.
    Grid,
    /// Speeds from the least to the greatest.
    Sweep,
}

/// A set of strikes.
pub struct Table {
    pub plan: Plan,
    pub noise: Noise,
    pub hidden: Vec<Hidden>,
    pub strikes: usize,
    pub seed: u64,
}

const STEP: f64 = 2e-3;
const CAMERA: f64 = 1e-3;
const FRAME: f64 = 1.0 / 60.0;
/// Share of strikes that judge.
const TEST: f64 = 0.25;

struct Set {
    random: ChaCha8Rng,
    noise: Noise,
    hidden: Vec<Hidden>,
    friction: f64,
    gain: f64,
    /// Commanded angle of the strike before, in rad.
    before: f64,
}

impl Set {
    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.random)
    }

    fn heavy(&mut self) -> f64 {
        if self.noise == Noise::HeavyTails {
            StudentT::new(3.0)
                .expect("three degrees")
                .sample(&mut self.random)
                / 3f64.sqrt()
        } else {
            self.normal()
        }
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.random.random::<f64>()
    }

    fn friction_at(&self, at: Point, velocity: Point) -> f64 {
        let speed = velocity.norm();
        let each = self.hidden.iter().map(|hidden| match hidden {
            Hidden::Rectangle(share) => {
                let is_in = (at.x - 0.5).abs() < 0.07 && (at.y - 0.05).abs() < 0.05;
                if is_in { *share } else { 0.0 }
            }
            Hidden::Gradient(share) => share * (at.x - 0.5),
            Hidden::Step(share) if at.x > 0.5 => *share,
            Hidden::Grain(share) => share * (velocity.x / speed.max(1e-6)).abs(),
            Hidden::Stribeck(share) => share / (1.0 + speed / 0.2),
            Hidden::Ripple(share) => share * (TAU * at.dot(Point::polar(1.0, 0.6)) / 0.12).sin(),
            _ => 0.0,
        });
        1.0 + each.sum::<f64>()
    }

    fn force(&self, velocity: Point) -> Point {
        let each = self.hidden.iter().map(|hidden| match hidden {
            Hidden::Drag(rate) => velocity * -rate,
            Hidden::Tilt(x, y) => Point::new(9.81 * x, 9.81 * y),
            Hidden::Magnus(rate) => Point::new(-velocity.y, velocity.x) * *rate,
            Hidden::Curl(push) => {
                Point::new(-velocity.y, velocity.x) * (push / velocity.norm().max(1e-9))
            }
            _ => Point::default(),
        });
        each.fold(Point::default(), |sum, f| sum + f)
    }

    fn seen(&self, at: Point, is_late: bool) -> Point {
        let away = at - Point::new(0.5, 0.0);
        self.hidden.iter().fold(at, |at, hidden| match hidden {
            Hidden::Lean(lean) => Point::new(0.5, 0.0) + away * (1.0 + lean * away.x).recip(),
            Hidden::LensHalfway(k) if is_late => at + away * (k * away.dot(away)),
            Hidden::Stretched(share) => {
                let long = Point::polar(1.0, 30f64.to_radians());
                (at + long * (share * long.dot(away))).rotated(0.5 * share)
            }
            _ => at,
        })
    }

    fn delivered(&self, command: Command) -> Command {
        self.hidden
            .iter()
            .fold(command, |command, hidden| match hidden {
                Hidden::SoftCap(cap) => Command {
                    speed: cap * (command.speed / cap).tanh(),
                    ..command
                },
                Hidden::SpeedWave(share, period) => Command {
                    speed: command.speed * (1.0 + share * (TAU * command.speed / period).sin()),
                    ..command
                },
                Hidden::AngleWave(size, period) => Command {
                    angle: command.angle + size * (TAU * command.angle / period).sin(),
                    ..command
                },
                Hidden::AngleGain(gain) => Command {
                    angle: command.angle * (1.0 + gain),
                    ..command
                },
                _ => command,
            })
    }
}

impl Table {
    /// What a diagnosis makes of it, from the identified world.
    pub fn diagnosed(&self) -> Diagnosis {
        let (rig, strikes) = self.strike();
        let world = World::nominal()
            .with("friction", 0.2)
            .with("restitution", 0.45);
        let settings = Diagnose {
            next_strikes: 0,
            ..Diagnose::default()
        };
        let input = Input::of(rig, world, strikes);
        let found = settings.run(&input, &Progress::hidden());
        found.expect("a diagnosis").diagnosis
    }
}

impl Table {
    /// The rig file, and the strikes in order of time.
    pub fn strike(&self) -> (Rig, Vec<Strike>) {
        let rig = Rig::demo(Shape::Cylinder);
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(77);
        let mut set = Set {
            random,
            noise: self.noise,
            hidden: self.hidden.clone(),
            friction: 0.0,
            gain: 0.0,
            before: 0.0,
        };
        set.friction = set.between(0.15, 0.3);
        set.gain = set.between(1.4, 1.6);
        let mut wander = 0.0;
        let strikes = (0..self.strikes)
            .map(|order| {
                let step = set.hidden.iter().find_map(|hidden| match hidden {
                    Hidden::Wander(step) => Some(*step),
                    _ => None,
                });
                wander += step.unwrap_or(0.0) * set.normal();
                let of_launch = set.hidden.iter().find_map(|hidden| match hidden {
                    Hidden::LaunchWander(step) => Some(*step),
                    _ => None,
                });
                if let Some(step) = of_launch {
                    set.gain *= (step * set.normal()).exp();
                }
                let other = set.hidden.iter().find_map(|hidden| match hidden {
                    Hidden::TwoObjects(share) => Some(*share),
                    _ => None,
                });
                let other = other.map_or(0.0, |share| if set.normal() > 0.0 { share } else { 0.0 });
                let worn = set.hidden.iter().map(|hidden| match hidden {
                    Hidden::SaturatingWear(share) => share * (1.0 - (-(order as f64) / 40.0).exp()),
                    Hidden::StepInOrder(share) if 2 * order >= self.strikes => *share,
                    Hidden::CycleInOrder(share, period) => {
                        share * (TAU * order as f64 / period).sin()
                    }
                    _ => 0.0,
                });
                let factor = (wander + other + worn.sum::<f64>()).exp();
                self.one(&rig, &mut set, order, factor)
            })
            .collect();
        (rig, strikes)
    }

    fn one(&self, rig: &Rig, set: &mut Set, order: usize, factor: f64) -> Strike {
        let robot = &rig.robot;
        let mut command = Command {
            speed: set.between(robot.speed.low, robot.speed.high),
            angle: set.between(robot.angle.low, robot.angle.high),
        };
        let mut origin = Point::new(set.between(0.27, 0.37), set.between(-0.08, 0.08));
        let middle = |low: f64, high: f64| 0.5 * (low + high);
        let speed = middle(robot.speed.low, robot.speed.high);
        let of = |share: f64, low: f64, high: f64| low + share * (high - low);
        match self.plan {
            Plan::Random => {}
            Plan::OneAngle => command.angle = 0.1,
            Plan::OneSpeed => command.speed = speed,
            Plan::OneCommand => command = Command { speed, angle: 0.1 },
            Plan::OneStart => {
                let aside = 5e-4 * set.normal();
                origin = Point::new(0.32 + aside, 5e-4 * set.normal());
            }
            Plan::Grid => {
                let (fast, turned) = ((order % 4) as f64 / 3.0, (order / 4 % 5) as f64 / 4.0);
                command.speed = of(fast, robot.speed.low, robot.speed.high);
                command.angle = of(turned, robot.angle.low, robot.angle.high);
            }
            Plan::Sweep => {
                let share = order as f64 / self.strikes as f64;
                command.speed = of(share, robot.speed.low, robot.speed.high);
            }
        }
        let mut delivered = set.delivered(command);
        for hidden in &set.hidden {
            match hidden {
                Hidden::Reach(share) => delivered.speed *= 1.0 + share * origin.y,
                Hidden::GainHalfway(share) if 2 * order >= self.strikes => {
                    delivered.angle += share * command.angle;
                }
                Hidden::TurnedHalfway(angle) if 2 * order >= self.strikes => {
                    delivered.angle += angle
                }
                Hidden::Backlash(angle) => {
                    delivered.angle -= angle * (command.angle - set.before).signum();
                }
                _ => {}
            }
        }
        set.before = command.angle;
        let grows = match set.noise {
            Noise::GrowsWithSpeed => {
                let share =
                    (command.speed - robot.speed.low) / (robot.speed.high - robot.speed.low);
                1.0 + 3.0 * share
            }
            _ => 1.0,
        };
        let own = match set.noise {
            Noise::Friction(sd) => sd,
            Noise::Mixed | Noise::All => 0.02,
            _ => 0.0,
        };
        let friction = set.friction * factor * (own * set.normal()).exp();
        let speed = set.gain * delivered.speed * (1.0 + 0.02 * grows * set.heavy());
        let angle = delivered.angle + 0.5f64.to_radians() * grows * set.heavy();
        let path = slide(set, origin, Point::polar(speed, angle), friction);
        self.seen(set, order, command, origin, &path)
    }

    fn seen(
        &self,
        set: &mut Set,
        order: usize,
        command: Command,
        origin: Point,
        path: &[Point],
    ) -> Strike {
        let correlation: f64 = match set.noise {
            Noise::Correlated(rho) => rho,
            Noise::Mixed | Noise::All => 0.5,
            _ => 0.0,
        };
        let jitter = match set.noise {
            Noise::Jitter(sd) => sd,
            Noise::All => 2e-3,
            _ => 0.0,
        };
        let is_stray = matches!(set.noise, Noise::Stray | Noise::All);
        let phase = FRAME * set.random.random::<f64>();
        let last = *path.last().expect("a path");
        let mut error = [CAMERA * set.normal(), CAMERA * set.normal()];
        let fresh = (1.0 - correlation * correlation).sqrt();
        let mut frame = |set: &mut Set, at: Point, may_stray: bool| {
            for e in &mut error {
                *e = correlation * *e + CAMERA * fresh * set.heavy();
            }
            let mut seen = set.seen(at, 2 * order >= self.strikes) + Point::new(error[0], error[1]);
            if may_stray && is_stray && set.random.random::<f64>() < 0.01 {
                seen = seen + Point::new(0.1 * set.normal(), 0.1 * set.normal());
            }
            seen
        };
        let mean = |points: &[Point]| {
            let sum = points.iter().fold(Point::default(), |sum, p| sum + *p);
            sum * (points.len() as f64).recip()
        };
        let before: Vec<Point> = (0..10).map(|_| frame(set, origin, false)).collect();
        let mut track = Track::default();
        let mut k = 0;
        loop {
            let t = phase + FRAME * f64::from(k);
            let place = t / STEP;
            if place as usize + 1 >= path.len() {
                break;
            }
            let (i, share) = (place as usize, place.fract());
            let at = path[i] + (path[i + 1] - path[i]) * share;
            let seen = frame(set, at, k > 2);
            let late = if k > 0 { jitter * set.normal() } else { 0.0 };
            track.t.push(FRAME * f64::from(k) + late);
            track.x.push(seen.x);
            track.y.push(seen.y);
            k += 1;
        }
        for hidden in &set.hidden {
            if let Hidden::SlowingClock(share) = hidden {
                let pace = 1.0 - share * order as f64 / self.strikes as f64;
                track.t.iter_mut().for_each(|t| *t *= pace);
            }
        }
        for i in 1..track.t.len() {
            track.t[i] = track.t[i].max(track.t[i - 1] + 1e-4);
        }
        let after: Vec<Point> = (0..10).map(|_| frame(set, last, false)).collect();
        let split = if set.random.random::<f64>() < TEST {
            Split::Test
        } else {
            Split::Train
        };
        Strike {
            id: format!("{:016x}", set.random.random::<u64>()),
            log: "session_001.mcap".into(),
            index: order as u32,
            t_start: order as f64,
            initial: mean(&before),
            stop: mean(&after),
            command,
            track,
            split,
            conditions: Conditions {
                session: "session_001.mcap".into(),
                order: order as f64,
                yaw: None,
                moving: None,
                is_unstruck: false,
                is_pushed_on: false,
            },
            delivered: None,
        }
    }
}

/// Places every [`STEP`], from launch to rest.
fn slide(set: &Set, origin: Point, launch: Point, friction: f64) -> Vec<Point> {
    let (mut at, mut v) = (origin, launch);
    let mut path = vec![at];
    while path.len() < 20_000 {
        let acceleration = |at: Point, v: Point| {
            let dry = 9.81 * friction * set.friction_at(at, v);
            v * (-dry / v.norm().max(1e-9)) + set.force(v)
        };
        let first = acceleration(at, v);
        let middle = acceleration(at + v * (0.5 * STEP), v + first * (0.5 * STEP));
        let next = v + middle * STEP;
        at = at + (v + next) * (0.5 * STEP);
        path.push(at);
        if next.dot(v) <= 0.0 || next.norm() < 1e-2 {
            break;
        }
        v = next;
    }
    path
}
