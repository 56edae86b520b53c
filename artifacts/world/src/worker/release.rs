//! The impact alone, simulated or interpolated between simulated ones, and what the duration of MuJoCo's contact does to it.

use values::{Command, Conditions, Interval, Point, Shape};

use super::Worker;
use crate::impact::{ContactDuration, RESTITUTIONS, SPEEDS};
use crate::releases::{STEPS, Scaled, cubic};
use crate::tip_motion::TipMotion;
use crate::{GRAVITY, Impact, Release, touch};

impl Worker<'_> {
    /// How the object leaves the tip; parameters of the slide and effects of the world do not act. `None` where tip and
    /// object do not part, or miss.
    pub fn release(&mut self, impact: Impact) -> Option<Release> {
        let motion = self.place_at_touch(Point::default(), impact)?;
        self.released(motion, impact.command.angle)
    }

    /// How an object that was placed at touch in the origin leaves the tip, which moves at this angle (rad).
    pub(super) fn released(&mut self, mut motion: TipMotion, angle: f64) -> Option<Release> {
        let sim = self.simulator;
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

    /// The release that follows a command to an object at `from` (m), interpolated. `None` where tip and object do not part, or miss, at an entry beside.
    ///
    /// The table is that of conditions of no session, before all strikes. What differs in others, restitution at the most,
    /// scales the speeds: exact for an impact through the centre, and near enough for where a search begins.
    pub(crate) fn likely_release(
        &mut self,
        command: Command,
        from: Point,
        conditions: &Conditions,
    ) -> Option<Release> {
        let rig = self.simulator.rig();
        let impact = self.simulator.impact(command, from, conditions);
        let of_table = self
            .simulator
            .delivered_impact(impact.command, &Conditions::default())
            .restitution;
        let Command { speed, angle } = impact.command;
        if speed.is_nan() || speed <= 0.0 {
            return None;
        }
        let anywhere = Interval::new(f64::NEG_INFINITY, f64::INFINITY);
        let speeds = cubic(speed.ln(), anywhere, STEPS[0])?;
        let angles = match rig.object.shape() {
            // A round object is struck alike from everywhere.
            Shape::Cylinder | Shape::Sphere => vec![(0, 1.0)],
            Shape::Box => {
                // The table is that of a box that stands straight.
                let onto_face = angle - impact.yaw;
                let face = touch::face(&rig.object, &rig.striker, impact.tip_offset, onto_face)?;
                cubic(onto_face, face, STEPS[1])?.to_vec()
            }
        };
        let mut release = [0.0; 6];
        for (i, by_speed) in speeds {
            for (j, by_angle) in &angles {
                let entry = self.entry([i, *j])?;
                for (sum, value) in release.iter_mut().zip(entry) {
                    *sum += by_speed * by_angle * value;
                }
            }
        }
        let [_, _, _, velocity_x, velocity_y, spin] = &mut release;
        for scaled in [velocity_x, velocity_y, spin] {
            *scaled *= (1.0 + impact.restitution) / (1.0 + of_table);
        }
        Some(Release::of(release, impact.command))
    }

    fn entry(&mut self, place: [i64; 2]) -> Option<Scaled> {
        let simulator = self.simulator;
        simulator.releases.entry(place, || {
            let speed = (place[0] as f64 * STEPS[0]).exp();
            let angle = place[1] as f64 * STEPS[1];
            let delivered = Command { speed, angle };
            let impact = simulator.delivered_impact(delivered, &Conditions::default());
            self.release(impact).map(|release| release.scaled(speed))
        })
    }
}

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

#[cfg(test)]
mod tests {
    use values::Rig;

    use super::*;
    use crate::{Simulator, World};

    #[test]
    fn what_is_interpolated_is_what_mujoco_does() {
        for (shape, most) in [(Shape::Cylinder, 2e-5), (Shape::Box, 2e-4)] {
            let rig = Rig::demo(shape);
            let simulator = Simulator::new(&rig, &World::nominal()).expect("valid");
            let mut worker = simulator.worker();
            for i in 0..20 {
                let command = Command::new(0.3 + 0.05 * f64::from(i), 0.3 - 0.03 * f64::from(i));
                let likely = worker
                    .likely_release(command, Point::default(), &Conditions::default())
                    .expect("parts");
                let real = worker
                    .release(simulator.impact(command, Point::default(), &Conditions::default()))
                    .expect("parts");
                let real = Release::of(real.scaled(command.speed), command);
                let off = (likely.velocity - real.velocity).norm() / command.speed;
                assert!(off < most, "{shape:?}, {command:?}: {off}");
            }
        }
    }
}
