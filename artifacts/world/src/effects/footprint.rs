//! The object's base as a circle, so that friction changes smoothly where the base passes an edge on the table.

use std::f64::consts::PI;

use values::{Point, Rig, Solid};

use super::{EffectParameter, Slide, Values};
use crate::GRAVITY;

/// Radius in m of the spot by which a ball is taken to touch: a point would make the friction jump within a step.
const BALL_SPOT: f64 = 0.005;

/// Share of the base's radius over which its covered share is smooth, wherever the edge is.
const SMOOTH: f64 = 0.4;

/// Speed in m/s below which an object is as good as at rest, and its load where it always was.
const LEAST_SPEED: f64 = 0.01;

/// Detail of an edge: the logarithm of how much wider friction changes than over the base. Stains fade out, and a base that is hollow or rests on a few
/// points feels a sharp edge at once.
pub(super) const SOFTNESS: EffectParameter =
    EffectParameter::new("softness", "", [-2.0, 2.0], 0.7).as_detail();

/// Detail of an edge: how far ahead of the object's centre it is felt, 1 where all of μ·h is. So far ahead the table carries an object that it brakes, whose
/// centre of mass is h above it; one that presses evenly, as embedded rigs have it, is carried at its centre.
pub(super) const LEAD: EffectParameter = EffectParameter::new("lead", "", [-2.0, 3.0], 0.5)
    .neutral_at(0.5)
    .as_detail();

/// Where and how widely an object feels an edge on the table.
#[derive(Clone, Copy, Debug)]
pub(super) struct Footprint {
    /// Radius in m of the circle over which friction changes.
    pub(super) radius: f64,
    /// Height in m of the centre of mass, as far as it counts: [`LEAD`].
    height: f64,
}

impl Footprint {
    /// The base of the rig's object, with the details that a world gives; one that gives none was fitted with an even load and the base as the edge's
    /// width.
    pub(super) fn of(values: &Values, rig: &Rig) -> Self {
        let solid = &rig.object.solid;
        let detail = |parameter: &EffectParameter| values.given(parameter.name).unwrap_or(0.0);
        Self {
            radius: radius(rig) * detail(&SOFTNESS).exp(),
            height: detail(&LEAD) * solid.half_height(),
        }
    }

    /// Where a sliding object feels the table, in m.
    pub(super) fn felt_at(&self, slide: &Slide<'_>) -> Point {
        let speed = slide.velocity.norm().max(LEAST_SPEED);
        slide.position + slide.velocity * (self.height * slide.dry / GRAVITY / speed)
    }

    /// Distance in m within which the share of the base beyond an edge is smooth, `apart` (m) from the object's centre.
    pub(super) fn smooth_within(&self, apart: f64) -> f64 {
        let outside = apart - self.radius - self.height.abs();
        outside.max(SMOOTH * self.radius)
    }
}

/// Radius in m of the circle of the base's area.
fn radius(rig: &Rig) -> f64 {
    match rig.object.solid {
        Solid::Cylinder { radius, .. } => radius,
        Solid::Box {
            half_size: [x, y, _],
        } => (4.0 * x * y / PI).sqrt(),
        Solid::Sphere { .. } => BALL_SPOT,
    }
}
