//! The object's base as a circle, so that friction changes smoothly where the base passes an edge on the table.

use std::f64::consts::PI;

use values::{Rig, Solid};

/// Radius in m of the spot by which a ball is taken to touch: a point would make the friction jump within a step.
const BALL_SPOT: f64 = 0.005;

/// Share of the base's radius over which its covered share is smooth, wherever the edge is.
pub(super) const SMOOTH: f64 = 0.4;

/// Radius in m of the circle of the base's area.
pub(super) fn radius(rig: &Rig) -> f64 {
    match rig.object.solid {
        Solid::Cylinder { radius, .. } => radius,
        Solid::Box {
            half_size: [x, y, _],
        } => (4.0 * x * y / PI).sqrt(),
        Solid::Sphere { .. } => BALL_SPOT,
    }
}
