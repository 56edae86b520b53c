//! One simulated strike.
//!
//! The strike starts with the tip touching the object (an impact that falls between two steps would make the stop a
//! sawtooth of the speed), takes fine steps while tip and object are close and long ones while the object slides
//! alone, and ends when it rests.

use values::{Command, Conditions, Point, Rig, Shape, Track};

use crate::{
    Profile, World, WorldError, contact_solref,
    effects::{self, Effect, Slide},
    engine::{Engine, Scene},
    scene, touch,
};

const GRAVITY: f64 = 9.81;
/// A contact cannot restore less than this by its damper; below, the tip is slowed instead, to the same release speed.
const LEAST_CONTACT_RESTITUTION: f64 = 0.2;
/// No slide lasts longer, in s.
const LONGEST_SLIDE: f64 = 20.0;
/// Below this speed, in m/s, MuJoCo's soft friction lets the object creep: the rest of the slide, a tenth of a millimetre,
/// is solved exactly from the deceleration seen above it.
const CREEP: f64 = 0.025;
/// Free space between tip and object, in m, beyond which steps are long.
const NEAR: f64 = 0.0005;

/// Lengths of the integration steps, in s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    /// While tip and object touch or are close.
    pub contact: f64,
    /// While the object slides alone.
    pub slide: f64,
}

impl Default for Steps {
    /// 0.05 ms and 2 ms: halving both moves no stop by 0.5 mm (tested).
    fn default() -> Self {
        Self {
            contact: 0.05e-3,
            slide: 2e-3,
        }
    }
}

/// A world compiled for one rig. Shared between threads; each strikes with a [`Worker`] of its own.
pub struct Simulator {
    rig: Rig,
    scene: Scene,
    effects: Vec<Box<dyn Effect>>,
    friction: f64,
    restitution: f64,
    contact_time: f64,
    arm: f64,
    steps: Steps,
}

/// What a simulated strike did, as the camera would see it.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulated {
    /// Where the object comes to rest, in m.
    pub stop: Point,
    /// Every step from touch (t = 0) to rest, in s and m.
    pub track: Track,
    /// Seconds from touch to rest.
    pub rest_time: f64,
}

impl Simulated {
    /// Where the camera sees the object `t` seconds after touch: linear between steps, at rest before and after, in m.
    pub fn at(&self, t: f64) -> Point {
        let track = &self.track;
        let after = track.t.partition_point(|&time| time <= t);
        if after == 0 {
            track.point(0)
        } else if after == track.len() {
            self.stop
        } else {
            let (t0, t1) = (track.t[after - 1], track.t[after]);
            let share = (t - t0) / (t1 - t0);
            track.point(after - 1) * (1.0 - share) + track.point(after) * share
        }
    }
}

impl Simulator {
    /// Compiles a world for a rig. Errors name what the world holds that cannot be.
    pub fn new(rig: &Rig, world: &World) -> Result<Self, WorldError> {
        Self::with_steps(rig, world, Steps::default())
    }

    /// The same with other step lengths.
    pub fn with_steps(rig: &Rig, world: &World, steps: Steps) -> Result<Self, WorldError> {
        world.check()?;
        let scene = Scene::compile(&scene::mjcf(rig, world)?, rig.object.mass * GRAVITY)?;
        Ok(Self {
            rig: rig.clone(),
            effects: world
                .effects
                .iter()
                .map(|added| effects::build(added, rig))
                .collect::<Result<_, _>>()?,
            friction: world.value("friction")?,
            restitution: world.value("restitution")?,
            contact_time: world.value("contact_time")?,
            arm: match rig.object.shape {
                Shape::Sphere => rig.object.radius.unwrap_or(0.0),
                Shape::Cylinder | Shape::Box => scene::turning_arm(&rig.object),
            },
            scene,
            steps,
        })
    }

    /// A worker: model and data of one thread.
    pub fn worker(&self) -> Worker<'_> {
        Worker {
            simulator: self,
            engine: self.scene.engine(self.arm),
        }
    }

    /// The rig that it was compiled for.
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// Sliding friction and restitution, for a first guess.
    pub(crate) fn coefficients(&self) -> (f64, f64) {
        (self.friction, self.restitution)
    }

    /// By how much (rad) the arm turns this command, and the lateral offset (m) of its tip.
    pub(crate) fn aim(&self, command: Command) -> (f64, f64) {
        let delivered = self
            .effects
            .iter()
            .fold(command, |command, effect| effect.deliver(command));
        let offset = self.effects.iter().map(|effect| effect.tip_offset()).sum();
        (delivered.angle - command.angle, offset)
    }

    /// Where the camera sees an object that is at `point`.
    fn observe(&self, point: Point) -> Point {
        self.effects
            .iter()
            .fold(point, |seen, effect| effect.observe(seen))
    }

    /// Where an object is that the camera sees at `seen`: a fixed point, for the measurement changes little.
    fn unobserve(&self, seen: Point) -> Point {
        let mut point = seen;
        for _ in 0..8 {
            point = point + (seen - self.observe(point));
        }
        point
    }

    /// The tip's motion for a command, as the arm would be told: towards the object seen at `initial`.
    pub fn profile(&self, initial: Point, command: Command) -> Option<Profile> {
        let direction = Point::polar(1.0, command.angle);
        let standoff = touch::standoff(&self.rig.object, &self.rig.striker, direction, 0.0)?;
        Some(Profile::plan(
            initial,
            command,
            self.rig.robot.acceleration,
            standoff,
        ))
    }
}

/// One thread's model and data.
pub struct Worker<'a> {
    pub(crate) simulator: &'a Simulator,
    engine: Engine,
}

impl Worker<'_> {
    /// Strikes the object that the camera sees at rest at `initial` (m) and follows it to its rest.
    ///
    /// Errors: a strike that misses the object, or does not come to a finite rest within 20 s.
    pub fn strike(
        &mut self,
        initial: Point,
        command: Command,
        conditions: &Conditions,
    ) -> Result<Simulated, WorldError> {
        let diverged = |why| WorldError::Diverged {
            speed: command.speed,
            angle: command.angle,
            why,
        };
        if !(command.speed > 0.0
            && command.speed.is_finite()
            && command.angle.is_finite()
            && initial.is_finite())
        {
            return Err(diverged(
                "speed must be above zero, and speed, angle and position finite",
            ));
        }
        let sim = self.simulator;
        let delivered = sim
            .effects
            .iter()
            .fold(command, |command, effect| effect.deliver(command));
        if delivered.speed <= 0.0 {
            return Err(diverged("the arm delivers no speed"));
        }
        let origin = sim.unobserve(initial);
        let mut motion = self
            .impact(origin, delivered)
            .ok_or_else(|| diverged("the tip passes beside the object"))?;
        let mut track = Track::default();
        let mut push = |t: f64, point: Point| {
            let seen = sim.observe(point);
            track.t.push(t);
            track.x.push(seen.x);
            track.y.push(seen.y);
        };
        push(0.0, origin);

        let weight = sim.friction * GRAVITY;
        let mut touched = false;
        let mut recorded = 0.0;
        let mut deceleration = Point::default();
        let mut slowing = weight;
        loop {
            let (position, velocity) = (self.engine.position(), self.engine.velocity());
            let near = motion.near(sim, position, velocity, touched);
            let timestep = if near {
                sim.steps.contact
            } else {
                sim.steps.slide
            };
            self.engine.set_timestep(timestep);
            // Forces at the middle of the step keep it second order.
            let slide = Slide {
                position: position + velocity * (0.5 * timestep),
                velocity: velocity + deceleration * (0.5 * timestep),
                dry: weight,
                conditions,
            };
            self.apply_effects(&slide);
            motion.drive(&mut self.engine, near);
            if near {
                self.engine.step();
            } else {
                self.engine.slide();
            }
            motion.t += timestep;
            touched |= near && self.engine.tip_touches();

            let (position, now) = (self.engine.position(), self.engine.velocity());
            if !(position.is_finite() && now.is_finite()) {
                return Err(diverged("the state is no longer finite"));
            }
            deceleration = (now - velocity) * (1.0 / timestep);
            if motion.t - recorded >= sim.steps.slide * 0.999 || !near {
                push(motion.t, position);
                recorded = motion.t;
            }
            if !near && now.norm() > CREEP {
                slowing = -deceleration.dot(now) / now.norm();
            } else if !near && slowing > 0.0 {
                let left = now.norm() / slowing;
                let stop = position + now * (0.5 * left);
                if left > 0.0 {
                    push(motion.t + left, stop);
                }
                return Ok(Simulated {
                    stop: sim.observe(stop),
                    rest_time: motion.t + left,
                    track,
                });
            }
            // An object slower than the tip's own braking is pushed to where the tip stops, and rests against it.
            // One that runs away downhill gains speed and does not.
            if near && motion.is_over() && now.norm() <= CREEP.min(velocity.norm()) {
                push(motion.t, position);
                return Ok(Simulated {
                    stop: sim.observe(position),
                    rest_time: motion.t,
                    track,
                });
            }
            if motion.t > LONGEST_SLIDE {
                return Err(diverged("it has not come to rest within 20 s"));
            }
        }
    }

    /// Places object and tip at touch.
    fn impact(&mut self, origin: Point, delivered: Command) -> Option<TipMotion> {
        let sim = self.simulator;
        let direction = Point::polar(1.0, delivered.angle);
        let offset: f64 = sim.effects.iter().map(|effect| effect.tip_offset()).sum();
        let standoff = touch::standoff(&sim.rig.object, &sim.rig.striker, direction, offset)?;
        let factor: f64 = sim
            .effects
            .iter()
            .map(|e| e.restitution_factor(delivered.speed))
            .product();
        let restitution = (1.0 + sim.restitution) * factor - factor;
        let contact = restitution.clamp(LEAST_CONTACT_RESTITUTION, 0.99);
        let speed = delivered.speed * (1.0 + restitution) / (1.0 + contact);
        let side = Point::new(-direction.y, direction.x) * offset;
        let profile = Profile::plan(
            origin + side,
            Command {
                speed,
                angle: delivered.angle,
            },
            sim.rig.robot.acceleration,
            standoff,
        );
        self.engine.reset();
        self.engine.place_object(origin);
        self.engine
            .set_strike_solref(contact_solref(sim.contact_time, contact, sim.steps.contact));
        self.engine.scale_friction(1.0);
        // Half a step deep, so that the contact acts from the first step on, whatever the rounding.
        Some(TipMotion {
            profile,
            t: 0.5 * sim.steps.contact,
        })
    }

    fn apply_effects(&mut self, slide: &Slide<'_>) {
        let sim = self.simulator;
        if sim.effects.is_empty() {
            return;
        }
        let factor: f64 = sim
            .effects
            .iter()
            .map(|effect| effect.friction_factor(slide))
            .product();
        self.engine.scale_friction(factor);
        let acceleration = sim.effects.iter().fold(Point::default(), |sum, effect| {
            sum + effect.acceleration(slide)
        });
        self.engine.push(acceleration * sim.rig.object.mass);
    }
}

/// The tip from touch on.
struct TipMotion {
    profile: Profile,
    /// Seconds since touch.
    t: f64,
}

impl TipMotion {
    fn tip(&self) -> (Point, Point) {
        self.profile.at(self.profile.t_strike + self.t)
    }

    /// Whether the tip has come to rest.
    fn is_over(&self) -> bool {
        self.profile.t_strike + self.t >= self.profile.t_stop
    }

    /// Whether tip and object touch, or may within the next long step.
    fn near(&self, sim: &Simulator, position: Point, velocity: Point, touched: bool) -> bool {
        let (tip, tip_velocity) = self.tip();
        let apart = position - tip;
        let distance = apart.norm();
        if !touched {
            return true;
        }
        let closing = (tip_velocity - velocity).dot(apart) / distance;
        let clearance = touch::clearance(&sim.rig.object, &sim.rig.striker, distance);
        // A box is closer than its circumscribed circle says only until it has left by its own corner.
        if sim.rig.object.shape == values::Shape::Box && self.t < 3.0 * sim.contact_time {
            return true;
        }
        let box_slack = match sim.rig.object.shape {
            values::Shape::Box => closing <= 0.0,
            _ => false,
        };
        !box_slack && clearance < NEAR + (closing * sim.steps.slide).max(0.0)
    }

    /// Moves the tip; once it is no longer near, it is taken out of the object's way.
    fn drive(&self, engine: &mut Engine, near: bool) {
        if near {
            let (position, velocity) = self.tip();
            engine.drive_striker(position, velocity);
        } else {
            engine.drive_striker(Point::new(-10.0, 0.0), Point::default());
        }
    }
}
