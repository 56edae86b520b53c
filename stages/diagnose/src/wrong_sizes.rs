//! Sizes that a rig file has wrong: what a box does whose sides, or whose tip's radius, are off by some per cent.
//!
//! A tip of radius r that is led through the middle of a box of half side h meets its face (1 + r/h)·tan(angle) half sides off the
//! middle. Where r/h is wrong, each angle of launch is off by a share, as if the arm struck at another share of the commanded angle.
//! A small share is taken for this and named as no effect of the arm; identification says which size the strikes want.

use values::{Command, Conditions, Point, Rig};
use world::effects::{Acts, Effect};

/// Share of its angle that a launch changes by for each unit of r/h, in MuJoCo's impacts.
const SHARE: f64 = 0.55;

/// Derivative of the share by which launch angles are off, by the logarithm of r/h; none for a round object, which is met through its middle
/// at any size.
pub(crate) fn sensitivity(rig: &Rig) -> Option<f64> {
    let [half, _] = rig.object.solid.half_sides()?;
    Some(SHARE * rig.striker.radius / half)
}

/// Launch angles that are off by a share, as another r/h makes them.
pub(crate) struct WrongSizes {
    pub(crate) share: f64,
}

impl Effect for WrongSizes {
    fn acts(&self) -> Acts {
        Acts::Launch
    }

    fn deliver(&self, command: Command, _: Point, _: &Conditions) -> Command {
        Command {
            angle: command.angle * (1.0 + self.share),
            ..command
        }
    }
}

/// Friction between tip and object that is not the identified one.
pub(crate) struct TipFriction {
    /// Logarithm of the factor.
    pub(crate) log: f64,
}

impl Effect for TipFriction {
    fn acts(&self) -> Acts {
        Acts::Launch
    }

    fn tip_friction(&self) -> f64 {
        self.log
    }
}

#[cfg(test)]
mod tests {
    use world::{Impact, Simulator, World};

    use values::{Shape, Solid};

    use super::*;

    /// Angle at which a box of this half side (m) leaves a tip of this radius (m), over the tip's own angle, in MuJoCo.
    fn launched(half: f64, radius: f64, angle: f64) -> f64 {
        let mut rig = Rig::demo(Shape::Box);
        rig.object.solid = Solid::Box {
            half_size: [half; 3],
        };
        rig.striker.radius = radius;
        let world = World::nominal();
        let command = Command { speed: 0.8, angle };
        let conditions = Conditions::default();
        let impact = Impact::of(&[], 0.4, command, &conditions);
        let simulator = Simulator::new(&rig, &world).expect("a world");
        let released = simulator.map(&[impact], |worker, impact| worker.release(*impact));
        let velocity = released[0].expect("it leaves the tip").velocity;
        1.0 + velocity.y.atan2(velocity.x) / angle
    }

    #[test]
    fn launches_are_off_by_a_share_of_their_angle_for_each_part_of_the_ratio() {
        for (half, radius) in [(0.03, 0.012), (0.04, 0.010), (0.025, 0.012)] {
            for angle in [0.1, 0.2, -0.3] {
                let by = launched(half, radius * 1.1, angle) / launched(half, radius, angle);
                let share = (by - 1.0) / 1.1f64.ln() / (radius / half);
                println!("half side {half} m, radius {radius} m, {angle} rad: {share:.3}");
                assert!((share / SHARE - 1.0).abs() < 0.12, "{share}");
            }
        }
    }
}
