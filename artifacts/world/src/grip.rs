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
