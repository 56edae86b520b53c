//! Measures what the duration of MuJoCo's contact does to the launch.

use values::{Command, Point};

use super::Worker;
use crate::{
    GRAVITY, Impact,
    contact_duration::{ContactDuration, RESTITUTIONS, SPEEDS},
};

impl Worker<'_> {
    /// By impacts through the centre, without effects. Nothing is taken back where tip and object do not part.
    pub(super) fn measure_contact_duration(&mut self) -> ContactDuration {
        let measured = RESTITUTIONS.map(|restitution| {
            let [slow, fast] = SPEEDS.map(|speed| self.excess(speed, restitution));
            Some([slow?, fast?])
        });
        match measured {
            [Some(low), Some(high)] => ContactDuration::of([low, high]),
            _ => ContactDuration::default(),
        }
    }

    /// Launch speed at the place of rest that leads to the same slide, over that of an impact without duration, less one.
    fn excess(&mut self, speed: f64, restitution: f64) -> Option<f64> {
        let impact = Impact {
            command: Command { speed, angle: 0.0 },
            tip_offset: 0.0,
            restitution,
            yaw: 0.0,
            tip_friction: 0.0,
        };
        let motion = self.place(Point::default(), impact, ContactDuration::default())?;
        let release = self.released(motion, 0.0)?;
        let (friction, _) = self.simulator.coefficients();
        let braked = 2.0 * friction * GRAVITY * release.position.x;
        let launch = (release.velocity.x.powi(2) + braked).sqrt();
        Some(launch / (speed * (1.0 + restitution)) - 1.0)
    }
}
