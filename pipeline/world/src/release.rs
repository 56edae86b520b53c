//! The blow alone: how the object leaves the tip.
//!
//! After it the slide is planar and smooth, and can be integrated without contacts where thousands of worlds must be tried.

use values::{Command, Point, Rig};

use crate::{Worker, scene, simulator::Blow};

const GRAVITY: f64 = 9.81;

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

/// Length in m at which turning counts as sliding, the world's torsional friction at 1: friction resists
/// √(v² + (length·spin)²).
pub fn turning_ratio(rig: &Rig) -> f64 {
    scene::turning_arm(&rig.object)
}

impl Worker<'_> {
    /// The blow of a tip that is delivered with this command, its line `tip_offset` m to the left of the object's centre, at
    /// this restitution; parameter and effects of the world do not act. `None` where tip and object do not part, or miss.
    pub fn release(
        &mut self,
        command: Command,
        tip_offset: f64,
        restitution: f64,
    ) -> Option<Release> {
        let sim = self.simulator;
        let mut motion = self.impact(
            Point::default(),
            Blow {
                command,
                tip_offset,
                restitution,
            },
        )?;
        let weight = sim.coefficients().0 * GRAVITY;
        let mut touched = false;
        self.engine.set_timestep(sim.steps.contact);
        self.engine.push(Point::default());
        loop {
            if touched && motion.free_step(sim, &self.engine, weight).is_some() {
                return Some(Release {
                    time: motion.t,
                    position: self.engine.position().rotated(-command.angle),
                    velocity: self.engine.velocity().rotated(-command.angle),
                    spin: self.engine.spin(),
                });
            }
            if motion.is_over() {
                return None;
            }
            motion.drive(&mut self.engine, true);
            self.engine.step();
            motion.t += sim.steps.contact;
            touched |= self.engine.tip_touches();
        }
    }
}
