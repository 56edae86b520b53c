//! One simulated strike.
//!
//! The strike starts with the tip touching the object (an impact that falls between two steps would make the stop a
//! sawtooth of the speed), takes fine steps while tip and object are close and long ones while the object slides
//! alone, and ends when it rests.

use std::sync::Arc;

use values::{Command, Conditions, Point, Rig, Shape, Track};

use crate::{
    Base, Blow, Delivery, GRAVITY, Profile, World, WorldError, contact_solref,
    effects::{self, Effect, Slide},
    engine::{Engine, Rubbing, Scene},
    grip::Grip,
    planar::{self, Planar},
    releases::Releases,
    scene,
    touch::{self, Nearest},
};

/// A contact cannot restore less than this by its damper; below, the tip is slowed instead, to the same release speed.
const LEAST_CONTACT_RESTITUTION: f64 = 0.2;
/// How long the tip holds its speed after touch, in contact times.
const HELD: f64 = 2.0;
/// No slide lasts longer, in s.
const LONGEST_SLIDE: f64 = 20.0;
/// No slide leads farther, in m: what runs away downhill gains speed, and would take ever more and shorter steps.
const FARTHEST: f64 = 100.0;
/// Below this speed, in m/s, MuJoCo's soft friction lets the object creep: the rest of the slide, a tenth of a millimetre,
/// is solved exactly from the deceleration seen above it.
const CREEP: f64 = 0.025;
/// Seconds between samples of a track, about: a straight line between two is off by a thousandth of a millimetre.
const SAMPLE: f64 = 2e-3;
/// Speed in m/s above which an effect shortens the steps of the slide, so that a place on the table is not stepped over.
const STROLL: f64 = 0.5;

/// Lengths of the integration steps, in s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    /// While tip and object touch or are close.
    pub contact: f64,
    /// While the object slides alone.
    pub slide: f64,
}

impl Default for Steps {
    /// 0.0125 ms and 8 ms: halving both moves no stop by 0.5 mm (tested).
    fn default() -> Self {
        Self {
            contact: 0.0125e-3,
            slide: 8e-3,
        }
    }
}

/// A world compiled for one rig. Shared between threads; each strikes with a [`Worker`] of its own.
pub struct Simulator {
    rig: Rig,
    scene: Scene,
    effects: Vec<Box<dyn Effect>>,
    /// What strikes told of the arm beside the effects.
    delivery: Option<Arc<dyn Delivery>>,
    friction: f64,
    restitution: f64,
    contact_time: f64,
    tip_friction: f64,
    base: Base,
    /// Square of the radius of gyration about the vertical in m².
    gyration: f64,
    pub(crate) releases: Releases,
    pub(crate) steps: Steps,
}

/// What a simulated strike did, as the camera would see it.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulated {
    /// Where the object comes to rest, in m.
    pub stop: Point,
    /// From touch (t = 0) to rest, every 2 ms or so, in s and m.
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
            delivery: None,
            friction: world.value("friction")?,
            restitution: world.value("restitution")?,
            contact_time: world.value("contact_time")?,
            tip_friction: world.value("tip_friction")?,
            base: Base::new(rig, world)?,
            gyration: planar::gyration(rig) * world.value("inertia_z")?,
            releases: Releases::default(),
            scene,
            steps,
        })
    }

    /// The same world, whose arm delivers what this correction says.
    pub fn with_delivery(self, delivery: Arc<dyn Delivery>) -> Self {
        Self {
            delivery: Some(delivery),
            ..self
        }
    }

    /// What the arm makes of a command, in m/s and rad: effects, then the correction.
    pub fn delivered(&self, command: Command, conditions: &Conditions) -> Command {
        let by_effects = effects::deliver(&self.effects, command, conditions);
        match &self.delivery {
            Some(delivery) => delivery.deliver(command, by_effects),
            None => by_effects,
        }
    }

    /// A worker: model and data of one thread.
    pub fn worker(&self) -> Worker<'_> {
        Worker {
            simulator: self,
            engine: self.scene.engine(self.rubbing()),
        }
    }

    /// The compiled model in MuJoCo's binary format (.mjb), for other programs that load the same release's. Its tip and
    /// object have no spring and damper yet, nor does friction follow the slip: a strike sets both ([`Worker::strike`]).
    pub fn to_mjb(&self) -> Vec<u8> {
        self.scene.to_mjb()
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
    pub(crate) fn aim(&self, command: Command, conditions: &Conditions) -> (f64, f64) {
        let blow = self.blow(command, conditions);
        (blow.command.angle - command.angle, blow.tip_offset)
    }

    /// What of the object rubs on the table.
    fn rubbing(&self) -> Rubbing {
        match self.rig.object.shape {
            Shape::Sphere => Rubbing::Ball(self.rig.object.radius.unwrap_or(0.0)),
            Shape::Cylinder | Shape::Box => Rubbing::Flat(self.base, self.gyration),
        }
    }

    /// Where a tip at this position and the object are nearest.
    fn nearest(&self, engine: &Engine, tip: Point) -> Nearest {
        let (object, striker) = (&self.rig.object, &self.rig.striker);
        touch::nearest(object, striker, engine.position(), engine.yaw(), tip)
    }

    /// What the arm makes of a command.
    pub(crate) fn blow(&self, command: Command, conditions: &Conditions) -> Blow {
        self.struck(self.delivered(command, conditions), conditions)
    }

    /// The blow of a tip with this speed and angle, as delivered.
    pub(crate) fn struck(&self, delivered: Command, conditions: &Conditions) -> Blow {
        Blow::of(&self.effects, self.restitution, delivered, conditions)
    }

    /// The world's planar form; none for a ball, which rolls.
    pub(crate) fn planar(&self) -> Option<Planar<'_>> {
        (self.rig.object.shape != Shape::Sphere).then(|| {
            Planar::of(
                [self.friction, self.restitution],
                self.base,
                self.gyration,
                &self.effects,
            )
        })
    }

    /// Where the camera sees an object that is at `point`.
    fn observe(&self, point: Point) -> Point {
        effects::observe(&self.effects, point)
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
    pub(crate) engine: Engine,
}

impl Worker<'_> {
    /// MuJoCo's steps so far, over all strikes: fine ones, and those of slides.
    pub fn steps(&self) -> [u64; 2] {
        self.engine.steps()
    }

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
        let blow = sim.blow(command, conditions);
        if blow.command.speed <= 0.0 {
            return Err(diverged("the arm delivers no speed"));
        }
        let origin = effects::unobserve(&sim.effects, initial);
        let mut motion = self
            .impact(origin, blow)
            .ok_or_else(|| diverged("the tip passes beside the object"))?;
        let mut record = Record::new(sim, origin);
        let weight = sim.friction * GRAVITY;
        let mut touched = false;
        let mut acceleration = Point::default();
        let mut slowing = weight;
        loop {
            let (position, velocity) = (self.engine.position(), self.engine.velocity());
            let free = if touched {
                motion.free_step(sim, &self.engine, slowing)
            } else {
                None
            };
            let timestep = free.unwrap_or(sim.steps.contact);
            self.engine.set_timestep(timestep);
            // Forces at the middle of the step keep it second order.
            let slide = Slide {
                position: position + velocity * (0.5 * timestep),
                velocity: velocity + acceleration * (0.5 * timestep),
                dry: weight,
                conditions,
            };
            self.apply_effects(&slide);
            motion.drive(sim, &mut self.engine, free.is_none());
            if free.is_some() {
                self.engine.slide();
            } else {
                self.engine.step();
                touched |= self.engine.tip_touches();
            }
            let begun = motion.t;
            motion.t += timestep;

            let (end, now) = (self.engine.position(), self.engine.velocity());
            if !(end.is_finite() && now.is_finite()) {
                return Err(diverged("the state is no longer finite"));
            }
            if free.is_some() {
                acceleration = (now - velocity) * (1.0 / timestep);
                record.arc(begun, timestep, position, velocity, acceleration);
                if now.norm() > CREEP {
                    slowing = -acceleration.dot(now) / now.norm();
                } else if slowing > 0.0 {
                    let left = now.norm() / slowing;
                    if motion.t + left > LONGEST_SLIDE {
                        return Err(diverged("it has not come to rest within 20 s"));
                    }
                    let braking = now * (-1.0 / left.max(1e-12));
                    record.arc(motion.t, left, end, now, braking);
                    let stop = end + now * (0.5 * left);
                    return Ok(record.end(motion.t + left, stop));
                }
            } else {
                // The blow's own acceleration says nothing of the slide's.
                acceleration = now * (-weight / now.norm().max(1e-12));
                record.step(motion.t, end);
                // An object slower than the tip's own braking is pushed to where the tip stops, and rests against it.
                // One that runs away downhill gains speed and does not.
                if motion.is_over() && now.norm() <= CREEP.min(velocity.norm()) {
                    return Ok(record.end(motion.t, end));
                }
            }
            if end.distance(origin) > FARTHEST {
                return Err(diverged("it runs away"));
            }
            if motion.t > LONGEST_SLIDE {
                return Err(diverged("it has not come to rest within 20 s"));
            }
        }
    }

    /// Places object and tip at touch.
    pub(crate) fn impact(&mut self, origin: Point, blow: Blow) -> Option<TipMotion> {
        let sim = self.simulator;
        let (delivered, offset) = (blow.command, blow.tip_offset);
        let direction = Point::polar(1.0, delivered.angle);
        let standoff = touch::standoff(&sim.rig.object, &sim.rig.striker, direction, offset)?;
        let restitution = blow.restitution;
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
            held: HELD * sim.contact_time,
            has_parted: false,
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
        let slide = &Slide {
            dry: factor * slide.dry,
            ..*slide
        };
        let acceleration = sim.effects.iter().fold(Point::default(), |sum, effect| {
            sum + effect.acceleration(slide)
        });
        self.engine.push(acceleration);
    }
}

/// The tip from touch on.
pub(crate) struct TipMotion {
    profile: Profile,
    /// Seconds since touch.
    pub(crate) t: f64,
    /// Seconds since touch until it brakes.
    held: f64,
    /// Whether tip and object have been apart.
    has_parted: bool,
}

impl TipMotion {
    /// The arm's brake does not bite within a contact of a millisecond or two: the tip holds its speed for as long.
    fn tip(&self) -> (Point, Point) {
        let profile = &self.profile;
        let (strike, velocity) = profile.at(profile.t_strike);
        if self.t < self.held {
            return (strike + velocity * self.t, velocity);
        }
        let (position, slower) = profile.at(profile.t_strike + self.t - self.held);
        (position + velocity * self.held, slower)
    }

    /// Whether the tip has come to rest.
    pub(crate) fn is_over(&self) -> bool {
        self.profile.t_strike + self.t - self.held >= self.profile.t_stop
    }

    /// Length in s of a step in which the object slides alone; none where the tip touches it, or may.
    ///
    /// A box that has left the tip is not struck again by a corner that swings back: whether it is hangs on a degree.
    pub(crate) fn free_step(
        &mut self,
        sim: &Simulator,
        engine: &Engine,
        slowing: f64,
    ) -> Option<f64> {
        let (tip, tip_velocity) = self.tip();
        let (position, velocity) = (engine.position(), engine.velocity());
        let apart = position - tip;
        let opening = (velocity - tip_velocity).dot(apart) / apart.norm().max(1e-12);
        let gap = sim.nearest(engine, tip).gap;
        if gap <= 0.0 && !(self.has_parted && opening > 0.0) {
            return None;
        }
        let speed = velocity.norm();
        let mut longest = sim.steps.slide;
        // A ball passes from sliding to rolling within a few milliseconds.
        if sim.rig.object.shape == Shape::Sphere {
            longest *= 0.25;
        }
        if !sim.effects.is_empty() {
            longest *= (STROLL / speed.max(1e-12)).min(1.0);
        }
        if slowing > 0.0 {
            // The last step ends where the rest of the slide is solved exactly.
            longest = longest.min(((speed - 0.8 * CREEP) / slowing).max(sim.steps.contact));
        }
        // The gap narrows by friction, at most twice as fast as the world's own.
        let narrowing = 2.0 * sim.friction * GRAVITY;
        let free = std::iter::successors(Some(longest), |step| Some(0.5 * step))
            .take(4)
            .find(|step| gap.max(0.0) + opening * step - 0.5 * narrowing * step * step > 0.0);
        self.has_parted |= free.is_some();
        free
    }

    /// Moves the tip; once it is no longer near, it is taken out of the object's way.
    pub(crate) fn drive(&self, sim: &Simulator, engine: &mut Engine, near: bool) {
        if near {
            let (position, velocity) = self.tip();
            engine.drive_striker(position, velocity);
            let touch = sim.nearest(engine, position);
            let grip = Grip {
                gyration: sim.gyration,
                friction: sim.tip_friction,
                solref: engine.strike_solref(),
            };
            let velocity = engine.velocity() - velocity;
            engine.set_grip(grip.rate(&touch, velocity, engine.spin(), sim.steps.contact));
        } else {
            engine.drive_striker(Point::new(-10.0, 0.0), Point::default());
        }
    }
}

/// The track of a strike, as the camera would see it.
struct Record<'a> {
    simulator: &'a Simulator,
    track: Track,
}

impl<'a> Record<'a> {
    fn new(simulator: &'a Simulator, origin: Point) -> Self {
        let mut record = Self {
            simulator,
            track: Track::default(),
        };
        record.push(0.0, origin);
        record
    }

    fn push(&mut self, t: f64, point: Point) {
        let seen = self.simulator.observe(point);
        self.track.t.push(t);
        self.track.x.push(seen.x);
        self.track.y.push(seen.y);
    }

    /// A short step, which becomes a sample where the last one is old enough.
    fn step(&mut self, t: f64, point: Point) {
        let last = self.track.t.last().copied().unwrap_or(0.0);
        if t - last >= 0.999 * SAMPLE {
            self.push(t, point);
        }
    }

    /// A long step of constant acceleration.
    fn arc(&mut self, t: f64, duration: f64, from: Point, velocity: Point, acceleration: Point) {
        let samples = (duration / SAMPLE).ceil().max(1.0);
        for sample in 1..=samples as u32 {
            let later = duration * f64::from(sample) / samples;
            let point = from + velocity * later + acceleration * (0.5 * later * later);
            self.push(t + later, point);
        }
    }

    fn end(mut self, t: f64, stop: Point) -> Simulated {
        if self.track.t.last().is_some_and(|&last| last < t) {
            self.push(t, stop);
        }
        Simulated {
            stop: self.simulator.observe(stop),
            rest_time: t,
            track: self.track,
        }
    }
}
