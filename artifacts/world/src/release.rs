//! The blow alone: how the object leaves the tip.
//!
//! After it the slide is planar and smooth, and can be integrated without contacts where thousands of worlds must be tried.

use values::{Command, Conditions, Point};

use crate::{GRAVITY, Worker, effects::Effect};

/// What the tip does to the object, as the arm delivers it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blow {
    /// Speed in m/s and angle in rad.
    pub command: Command,
    /// Lateral offset of the tip's line, in m to the left of the object's centre.
    pub tip_offset: f64,
    /// Speed of parting over speed of approach.
    pub restitution: f64,
}

impl Blow {
    /// The blow of a tip that the arm leads with this speed and angle, under these effects, in a world of this restitution.
    pub fn of(
        effects: &[Box<dyn Effect>],
        restitution: f64,
        delivered: Command,
        conditions: &Conditions,
    ) -> Self {
        Self {
            command: delivered,
            tip_offset: effects.iter().map(|effect| effect.tip_offset()).sum(),
            restitution: effects
                .iter()
                .map(|effect| effect.restitution_factor(delivered.speed, conditions))
                .fold(restitution, |e, factor| e * factor),
        }
    }
}

/// The object as it leaves the tip, in the frame of the blow: x along the tip's velocity, y to its left, the object at rest
/// in the origin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Release {
    /// Seconds since touch.
    pub time: f64,
    /// Position of the object in m.
    pub position: Point,
    /// Its velocity in m/s.
    pub velocity: Point,
    /// Its rate of turning in rad/s.
    pub spin: f64,
}

/// What varies of a release from blow to blow: time, position and velocity in the frame of the blow, spin; positions per m,
/// velocities and spin per m/s of the tip's speed.
pub(crate) type Scaled = [f64; 6];

impl Release {
    /// By the tip's speed in m/s.
    pub(crate) fn scaled(&self, speed: f64) -> Scaled {
        [
            self.time,
            self.position.x,
            self.position.y,
            self.velocity.x / speed,
            self.velocity.y / speed,
            self.spin / speed,
        ]
    }

    /// After a blow with this command, on the table.
    pub(crate) fn of(scaled: Scaled, command: Command) -> Self {
        let [time, x, y, vx, vy, spin] = scaled;
        let Command { speed, angle } = command;
        Self {
            time,
            position: Point::new(x, y).rotated(angle),
            velocity: Point::new(vx, vy).rotated(angle) * speed,
            spin: spin * speed,
        }
    }
}

impl Worker<'_> {
    /// How the object leaves the tip; parameters of the slide and effects of the world do not act. `None` where tip and
    /// object do not part, or miss.
    pub fn release(&mut self, blow: Blow) -> Option<Release> {
        let sim = self.simulator;
        let angle = blow.command.angle;
        let mut motion = self.impact(Point::default(), blow)?;
        let weight = sim.coefficients().0 * GRAVITY;
        let mut touched = false;
        self.engine.set_timestep(sim.steps.contact);
        self.engine.push(Point::default());
        loop {
            if touched && motion.free_step(sim, &self.engine, weight).is_some() {
                return Some(Release {
                    time: motion.t,
                    position: self.engine.position().rotated(-angle),
                    velocity: self.engine.velocity().rotated(-angle),
                    spin: self.engine.spin(),
                });
            }
            if motion.is_over() {
                return None;
            }
            motion.drive(sim, &mut self.engine, true);
            self.engine.step();
            motion.t += sim.steps.contact;
            touched |= self.engine.tip_touches();
        }
    }
}
