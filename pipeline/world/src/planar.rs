//! The slide without contacts: planar motion under friction, integrated in long steps.
//!
//! The same world as MuJoCo's, a hundred times faster: from where the tip lets go the object is one planar body that rubs on
//! an even base ([`Base`]), which MuJoCo's steps approach as well. The effects act
//! through the same functions in both. What is found here is fitted and judged in MuJoCo afterwards.

use values::{Command, Conditions, Point, Rig, Shape, Strike};

use crate::{
    Base, Blow, Release, World, WorldError,
    effects::{self, Effect, Slide},
    launch::Launch,
};

const GRAVITY: f64 = 9.81;
/// Length of a step in s; the slide is smooth, and four evaluations a step follow it to a hundredth of a millimetre.
const STEP: f64 = 0.0125;
/// No slide lasts longer, in s.
const LONGEST: f64 = 20.0;

/// A world in planar form.
pub struct Planar<'a> {
    /// Friction between object and table.
    pub friction: f64,
    /// Speed of parting over speed of approach.
    pub restitution: f64,
    /// What rubs on the table.
    pub base: Base,
    /// Square of the radius of gyration, in m².
    pub gyration: f64,
    /// What acts beside friction.
    pub effects: &'a [Box<dyn Effect>],
    /// A small push beside the effects, to see what would follow from it.
    pub push: Option<&'a Push<'a>>,
}

/// Acceleration in m/s² by seconds since touch, position (m) and velocity (m/s).
pub type Push<'a> = dyn Fn(f64, Point, Point) -> Point + Sync + 'a;

/// What one strike is simulated from, and when it is looked at.
#[derive(Clone, Copy, Debug)]
pub struct Shot<'a> {
    /// Where the camera sees the object at rest, in m.
    pub initial: Point,
    /// What the arm is told.
    pub command: Command,
    /// Session and order.
    pub conditions: &'a Conditions,
    /// Seconds at which the object is looked at, rising, by the track's clock.
    pub times: &'a [f64],
}

impl<'a> From<&'a Strike> for Shot<'a> {
    /// A logged strike, at its own frames.
    fn from(strike: &'a Strike) -> Self {
        Self {
            initial: strike.initial,
            command: strike.command,
            conditions: &strike.conditions,
            times: &strike.track.t,
        }
    }
}

/// How one strike differs from what was commanded and measured.
#[derive(Clone, Copy, Debug, Default)]
pub struct Kick {
    /// Logarithm of the factor on speed.
    pub speed: f64,
    /// Angle in rad.
    pub angle: f64,
    /// Seconds from touch to the track's zero.
    pub delay: f64,
    /// Error of the resting place, in m.
    pub rest: Point,
}

/// A strike's frames as simulated.
#[derive(Clone, Debug, Default)]
pub struct Frames {
    /// Seen centroids, in m.
    pub at: Vec<Point>,
    /// Their rates of change, in m/s.
    pub rate: Vec<Point>,
    /// Where it is seen at rest, in m.
    pub stop: Point,
}

/// Square of the radius of gyration about the vertical, in m².
pub fn gyration(rig: &Rig) -> f64 {
    match rig.object.shape {
        Shape::Box => {
            let [x, y, _] = rig.object.half_size.unwrap_or_default();
            (x * x + y * y) / 3.0
        }
        Shape::Cylinder | Shape::Sphere => 0.5 * rig.object.radius.unwrap_or(0.0).powi(2),
    }
}

#[derive(Clone, Copy)]
struct Body {
    position: Point,
    velocity: Point,
    spin: f64,
}

#[derive(Clone, Copy)]
struct Rate {
    velocity: Point,
    acceleration: Point,
    turning: f64,
}

impl Body {
    fn along(self, rate: &Rate, t: f64) -> Self {
        Self {
            position: self.position + rate.velocity * t,
            velocity: self.velocity + rate.acceleration * t,
            spin: self.spin + rate.turning * t,
        }
    }
}

impl<'a> Planar<'a> {
    /// The planar form of a world with these effects in place of its own; of a cylinder or a box, for a ball rolls.
    pub fn new(
        rig: &Rig,
        world: &World,
        effects: &'a [Box<dyn Effect>],
    ) -> Result<Self, WorldError> {
        Ok(Self {
            friction: world.value("friction")?,
            restitution: world.value("restitution")?,
            base: Base::new(rig, world)?,
            gyration: gyration(rig) * world.value("inertia_z")?,
            effects,
            push: None,
        })
    }
}

impl Planar<'_> {
    fn observe(&self, point: Point) -> Point {
        effects::observe(self.effects, point)
    }

    fn rate(&self, t: f64, body: &Body, conditions: &Conditions) -> Rate {
        let mut slide = Slide {
            position: body.position,
            velocity: body.velocity,
            dry: self.friction * GRAVITY,
            conditions,
        };
        slide.dry *= self
            .effects
            .iter()
            .map(|effect| effect.friction_factor(&slide))
            .product::<f64>();
        let mut acceleration = self.effects.iter().fold(Point::default(), |sum, effect| {
            sum + effect.acceleration(&slide)
        });
        if let Some(push) = self.push {
            acceleration = acceleration + push(t, body.position, body.velocity);
        }
        let arm = self.base.arm;
        let [pull, turning] = self.base.pull(body.velocity.norm(), arm * body.spin);
        Rate {
            velocity: body.velocity,
            acceleration: acceleration - body.velocity * (slide.dry * pull),
            turning: -slide.dry * turning * body.spin * arm * arm / self.gyration,
        }
    }

    fn step(&self, t: f64, body: &Body, first: &Rate, conditions: &Conditions) -> Body {
        let second = self.rate(t + 0.5 * STEP, &body.along(first, 0.5 * STEP), conditions);
        let third = self.rate(t + 0.5 * STEP, &body.along(&second, 0.5 * STEP), conditions);
        let fourth = self.rate(t + STEP, &body.along(&third, STEP), conditions);
        let sixth = STEP / 6.0;
        let sum = |a: Point, b: Point, c: Point, d: Point| a + (b + c) * 2.0 + d;
        Body {
            position: body.position
                + sum(
                    first.velocity,
                    second.velocity,
                    third.velocity,
                    fourth.velocity,
                ) * sixth,
            velocity: body.velocity
                + sum(
                    first.acceleration,
                    second.acceleration,
                    third.acceleration,
                    fourth.acceleration,
                ) * sixth,
            spin: body.spin
                + (first.turning + 2.0 * (second.turning + third.turning) + fourth.turning) * sixth,
        }
    }

    /// One strike, seen at its own frames; `None` where it does not rest within 20 s. `launch` is that of a command near
    /// the strike's ([`crate::launch::launches`]).
    pub fn strike(&self, shot: &Shot<'_>, launch: &Launch, kick: &Kick) -> Option<Frames> {
        let delivered = effects::deliver(self.effects, shot.command);
        let blow = Blow::of(self.effects, self.restitution, delivered);
        self.slide(shot, launch.release(&blow), kick)
    }

    /// The slide alone, from where the tip lets go of the object.
    pub fn slide(&self, shot: &Shot<'_>, release: Release, kick: &Kick) -> Option<Frames> {
        // A kick turns and speeds what leaves the tip, and never turns it back, however large it is.
        let mut release = release;
        release.position = release.position.rotated(kick.angle);
        release.velocity = release.velocity.rotated(kick.angle) * kick.speed.exp();
        release.spin *= kick.speed.exp();
        let origin = effects::unobserve(self.effects, shot.initial + kick.rest);
        let mut body = Body {
            position: origin + release.position,
            velocity: release.velocity,
            spin: release.spin,
        };
        let mut seen = Frames::default();
        let mut t = release.time;
        let times = shot.times;
        let mut frame = 0;
        // Frames before the release lie on the way there.
        while frame < times.len() && times[frame] + kick.delay < t {
            let share = (times[frame] + kick.delay).max(0.0) / t;
            let at = origin + release.position * (share * share);
            seen.push(self.observe(at), release.position * (2.0 * share / t));
            frame += 1;
        }
        let conditions = shot.conditions;
        loop {
            let rate = self.rate(t, &body, conditions);
            let speed = body.velocity.norm();
            let slowing = -rate.acceleration.dot(body.velocity) / speed.max(1e-12);
            if slowing > 0.0 && speed <= slowing * STEP {
                // The last step ends at rest.
                let left = speed / slowing;
                let stop = body.position + body.velocity * (0.5 * left);
                while frame < times.len() {
                    let into = (times[frame] + kick.delay - t).min(left);
                    let at = body.position
                        + body.velocity * (into - 0.5 * into * into / left.max(1e-12));
                    let still = 1.0 - into / left.max(1e-12);
                    seen.push(self.observe(at), body.velocity * still);
                    frame += 1;
                }
                seen.stop = self.observe(stop);
                return Some(seen);
            }
            if t > LONGEST || !speed.is_finite() {
                return None;
            }
            let next = self.step(t, &body, &rate, conditions);
            while frame < times.len() && times[frame] + kick.delay < t + STEP {
                let s = (times[frame] + kick.delay - t) / STEP;
                let (at, velocity) = hermite(&body, &next, s);
                seen.push(self.observe(at), velocity);
                frame += 1;
            }
            body = next;
            t += STEP;
        }
    }
}

impl Frames {
    fn push(&mut self, at: Point, rate: Point) {
        self.at.push(at);
        self.rate.push(rate);
    }
}

/// Position and velocity a share `s` of a step from `a` to `b`.
fn hermite(a: &Body, b: &Body, s: f64) -> (Point, Point) {
    let (s2, s3) = (s * s, s * s * s);
    let at = a.position * (2.0 * s3 - 3.0 * s2 + 1.0)
        + b.position * (3.0 * s2 - 2.0 * s3)
        + (a.velocity * (s3 - 2.0 * s2 + s) + b.velocity * (s3 - s2)) * STEP;
    (at, a.velocity * (1.0 - s) + b.velocity * s)
}

#[cfg(test)]
mod tests {
    use values::Track;

    use super::*;
    use crate::{AddedEffect, Estimate, Simulator, launch::launches};

    /// Strikes over the rig's speeds and angles, with frames to compare at.
    fn strikes(rig: &Rig) -> Vec<Strike> {
        let times: Vec<f64> = (1..60).map(|i| f64::from(i) / rig.camera.rate).collect();
        (0..6)
            .map(|i| {
                let share = f64::from(i) / 5.0;
                let range = rig.robot.angle;
                let command = Command {
                    speed: 0.45 + 0.5 * share,
                    angle: range.low + (range.high - range.low) * ((2.0 * share) % 1.0),
                };
                Strike {
                    id: String::new(),
                    log: String::new(),
                    index: 0,
                    t_start: 0.0,
                    initial: Point::new(0.3, 0.05),
                    stop: Point::default(),
                    command,
                    track: Track {
                        x: vec![0.0; times.len()],
                        y: vec![0.0; times.len()],
                        t: times.clone(),
                    },
                    split: values::Split::Train,
                    conditions: Conditions {
                        session: "monday.mcap".into(),
                        order: 10.0 * f64::from(i),
                    },
                }
            })
            .collect()
    }

    /// Greatest distance in m between the planar slide and MuJoCo's, over all frames and stops.
    fn apart(shape: Shape, added: Option<(&str, &[(&str, f64)])>) -> f64 {
        let rig = Rig::demo(shape);
        let world = World::nominal(&rig)
            .with("friction", 0.22)
            .with("restitution", 0.5);
        let mut with = world.clone();
        with.effects.extend(added.map(|(name, parameters)| {
            AddedEffect {
                name: name.into(),
                parameters: parameters
                    .iter()
                    .map(|(name, value)| (name.to_string(), Estimate::fixed(*value)))
                    .collect(),
            }
        }));
        let effects: Vec<_> = with
            .effects
            .iter()
            .map(|added| effects::build(added, &rig).expect("an effect of the library"))
            .collect();
        let planar = Planar::new(&rig, &world, &effects).expect("known parameters");
        let strikes = strikes(&rig);
        let commands: Vec<Command> = strikes.iter().map(|strike| strike.command).collect();
        let launches = launches(&rig, &world, &commands).expect("a valid world");
        let simulator = Simulator::new(&rig, &with).expect("a valid world");
        let mut worker = simulator.worker();
        let mut worst: f64 = 0.0;
        for (strike, launch) in strikes.iter().zip(launches) {
            let frames = planar
                .strike(&strike.into(), &launch.expect("parts"), &Kick::default())
                .expect("rests");
            let simulated = worker
                .strike(strike.initial, strike.command, &strike.conditions)
                .expect("rests");
            worst = worst.max(frames.stop.distance(simulated.stop));
            for (t, at) in strike.track.t.iter().zip(&frames.at) {
                worst = worst.max(at.distance(simulated.at(*t)));
            }
        }
        worst
    }

    #[test]
    fn it_follows_mujoco_whatever_the_effect() {
        let cases: &[(&str, &[(&str, f64)])] = &[
            ("viscous_drag", &[("rate", 0.3)]),
            ("quadratic_drag", &[("coefficient", 0.2)]),
            ("speed_weakening_friction", &[("rise", 0.3), ("speed", 0.3)]),
            (
                "anisotropic_friction",
                &[("contrast", 0.1), ("direction", 0.5)],
            ),
            (
                "friction_patch",
                &[("center_x", 0.5), ("change", 0.3), ("radius", 0.08)],
            ),
            ("friction_drift", &[("rate", 0.2)]),
            ("friction_by_session", &[("monday.mcap", 0.1)]),
            ("table_tilt", &[("tilt_x", -0.004), ("tilt_y", 0.006)]),
            ("table_bowl", &[("curvature", 0.04), ("center_x", 0.4)]),
            ("striker_speed_error", &[("offset", -0.04), ("cap", 0.9)]),
            ("striker_angle_bias", &[("bias", 0.03)]),
            ("speed_dependent_restitution", &[("slope", 0.2)]),
            ("off_centre_contact", &[("offset", 0.002)]),
            ("camera_rotation", &[("angle", 0.02)]),
            ("camera_distortion", &[("k1", 0.08)]),
        ];
        let plain = apart(Shape::Cylinder, None);
        assert!(plain < 1e-4, "without effects: {plain} m");
        for (name, parameters) in cases {
            let apart = apart(Shape::Cylinder, Some((name, parameters)));
            assert!(apart < 4e-4, "{name}: {apart} m");
        }
        let turning = apart(Shape::Box, None);
        assert!(turning < 2e-4, "a box that turns: {turning} m");
    }
}
