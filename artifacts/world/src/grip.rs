//! Friction between tip and object within an impact.
//!
//! MuJoCo's friction cone is convex: where a contact slips, what friction falls short of its reference pushes the contact
//! apart, μ times as much. At the reference that a friction inherits from the impact's damper a tip that should stick creeps,
//! and at a harder one a box struck aslant leaves too slow by several per cent. So the reference follows the slip: just beyond what
//! the cone holds while the contact slips, and all of the slip where that is less. Newton's restitution and Coulomb's friction
//! come out, as a rigid impact has them (tested).

use values::Point;

use crate::touch::Nearest;

/// How far, relative to what friction reaches, the reference lies beyond the cone.
const BEYOND_CONE: f64 = 1.02;
/// Share of the slip that one step takes away where friction can.
const TAKEN: f64 = 0.9;

/// The state of the contact in one step of an impact.
pub(crate) struct Grip {
    /// Square of the object's radius of gyration in m².
    pub(crate) gyration: f64,
    /// Coefficient of friction between tip and object.
    pub(crate) friction: f64,
    /// The contact's spring and damper per unit mass, in 1/s² and 1/s.
    pub(crate) solref: [f64; 2],
}

impl Grip {
    /// Rate in 1/s at which MuJoCo shall pull the slip towards zero in a step of `timestep` s; `velocity` (m/s) is that of the
    /// object's centre less the tip's, `spin` the object's in rad/s.
    pub(crate) fn rate(&self, touch: &Nearest, velocity: Point, spin: f64, timestep: f64) -> f64 {
        let Nearest { gap, arm, normal } = *touch;
        let tangent = Point::new(-normal.y, normal.x);
        let at_touch = velocity + Point::new(-arm.y, arm.x) * spin;
        let (parting, slip) = (at_touch.dot(normal), at_touch.dot(tangent));
        let all = TAKEN / timestep;
        // Velocity that a unit impulse over the mass gives the touched point, along the normal and against the slip.
        let lever = (cross(arm, normal), cross(arm, tangent) * slip.signum());
        let knn = 1.0 + lever.0 * lever.0 / self.gyration;
        let knt = lever.0 * lever.1 / self.gyration;
        let ktt = 1.0 + lever.1 * lever.1 / self.gyration;
        let [stiffness, damping] = self.solref;
        let pushed = (stiffness * -gap - damping * parting).max(0.0);
        let reached = pushed * (self.friction * ktt - knt) / (knn - self.friction * knt);
        (BEYOND_CONE * reached.max(0.0) / slip.abs().max(1e-9)).min(all)
    }
}

fn cross(a: Point, b: Point) -> f64 {
    a.x * b.y - a.y * b.x
}

#[cfg(test)]
mod tests {
    use values::{Command, Conditions, Rig, Shape};

    use super::*;
    use crate::{Release, Simulator, World};

    /// Velocity of the centre, per unit of the tip's speed, that a rigid impact with Newton's restitution and Coulomb's friction leaves,
    /// and the spin (rad/m).
    fn rigid(rig: &Rig, angle: f64, restitution: f64, friction: f64) -> (Point, f64) {
        let [x, y] = rig.object.solid.half_sides().expect("a box");
        let gyration = (x * x + y * y) / 3.0;
        let lever = ((x + rig.striker.radius) * angle.tan(), -x);
        let (knn, knt, ktt) = (
            1.0 + lever.0 * lever.0 / gyration,
            lever.0 * lever.1 / gyration,
            1.0 + lever.1 * lever.1 / gyration,
        );
        let (normal, along) = ((1.0 + restitution) * angle.cos(), angle.sin());
        let determinant = knn * ktt - knt * knt;
        let mut pushed = (normal * ktt - along * knt) / determinant;
        let mut dragged = (along * knn - normal * knt) / determinant;
        if dragged.abs() > friction * pushed {
            let slope = friction.copysign(dragged);
            pushed = normal / (knn + slope * knt);
            dragged = slope * pushed;
        }
        let spin = (lever.0 * pushed + lever.1 * dragged) / gyration;
        (Point::new(pushed, dragged), spin)
    }

    #[test]
    fn a_box_leaves_the_tip_as_from_a_rigid_blow() {
        let rig = Rig::demo(Shape::Box);
        for (friction, speed, bearing) in [(0.7, 2e-3, 3e-4), (0.2, 1e-2, 3e-3)] {
            // A table that brakes little while the impact lasts.
            let world = World::nominal(&rig)
                .with("tip_friction", friction)
                .with("friction", 0.02);
            let simulator = Simulator::new(&rig, &world).expect("valid");
            let mut worker = simulator.worker();
            for degrees in [-25, -8, 0, 5, 18, 25] {
                let angle = f64::from(degrees).to_radians();
                let command = Command { speed: 0.6, angle };
                let release = worker
                    .release(simulator.impact(command, Point::default(), &Conditions::default()))
                    .expect("parts");
                let release = Release::of(release.scaled(command.speed), command);
                let (velocity, spin) = rigid(&rig, angle, 0.5, friction);
                let off = release.velocity.norm() / (0.6 * velocity.norm()) - 1.0;
                assert!(off.abs() < speed, "μ {friction}, {degrees}°: speed {off}");
                let turned = release.velocity.bearing() - velocity.bearing();
                assert!(turned.abs() < bearing, "μ {friction}, {degrees}°: {turned}");
                let most = 0.025 * spin.abs() + 1e-6;
                assert!(
                    (release.spin / 0.6 - spin).abs() < most,
                    "{degrees}°: {spin}"
                );
            }
        }
    }
}
