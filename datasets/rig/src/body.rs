//! The object as the table feels it: mass moments and the elements of its base.

use values::{Object, Point, Solid};

use crate::RigSimError;

/// Rings of a round base, and elements of each.
const RINGS: usize = 3;
const ELEMENTS_A_RING: usize = 8;
/// Elements along each side of a rectangular base.
const ELEMENTS_A_SIDE: usize = 4;

/// An element of the base; all carry the same share of the weight.
pub(crate) type Element = Point;

/// Outline seen from above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Outline {
    /// A disc of this radius in m.
    Disc(f64),
    /// A rectangle of these half sizes in m, parallel to the table's axes before a strike.
    Rectangle(f64, f64),
}

/// The object's properties that the physics needs.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    /// Seen from above.
    pub outline: Outline,
    /// Moment of inertia about the vertical axis, over the mass, in m².
    pub gyration: f64,
    /// Elements of the base relative to the centre, in m; one for a ball.
    pub elements: Vec<Element>,
    /// Mean square distance of the elements from the centre, in m².
    pub spread: f64,
    pub ball: bool,
}

impl Body {
    /// From the rig file; errors if a size is not positive.
    pub(crate) fn new(object: &Object) -> Result<Self, RigSimError> {
        let positive = |size: f64, key: &str| {
            if size.is_finite() && size > 0.0 {
                return Ok(size);
            }
            Err(RigSimError::Object(format!(
                "[object] {key} must be a positive length in m"
            )))
        };
        let (outline, gyration, elements, ball) = match object.solid {
            Solid::Cylinder { radius, .. } => {
                let radius = positive(radius, "radius")?;
                (
                    Outline::Disc(radius),
                    radius * radius / 2.0,
                    disc(radius),
                    false,
                )
            }
            Solid::Sphere { radius } => {
                let radius = positive(radius, "radius")?;
                (
                    Outline::Disc(radius),
                    0.4 * radius * radius,
                    vec![Point::default()],
                    true,
                )
            }
            Solid::Box {
                half_size: [x, y, _],
            } => {
                let (x, y) = (positive(x, "half_size[0]")?, positive(y, "half_size[1]")?);
                (
                    Outline::Rectangle(x, y),
                    (x * x + y * y) / 3.0,
                    rectangle(x, y),
                    false,
                )
            }
        };
        let spread = elements.iter().map(|e| e.dot(*e)).sum::<f64>() / elements.len() as f64;
        Ok(Self {
            outline,
            gyration,
            elements,
            spread,
            ball,
        })
    }

    /// The farthest that any part of it lies from its centre, in m.
    pub(crate) fn reach(&self) -> f64 {
        match self.outline {
            Outline::Disc(radius) => radius,
            Outline::Rectangle(x, y) => x.hypot(y),
        }
    }
}

/// Rings of equal area, each turned against its neighbour so that no direction is favoured.
fn disc(radius: f64) -> Vec<Element> {
    let mut elements = Vec::with_capacity(RINGS * ELEMENTS_A_RING);
    for ring in 0..RINGS {
        // The mean distance within the ring, so that the friction torque of a spinning disc, 2/3 μ m g R, is exact.
        let edge = |k: usize| radius * (k as f64 / RINGS as f64).sqrt();
        let (inner, outer) = (edge(ring), edge(ring + 1));
        let distance =
            2.0 / 3.0 * (outer.powi(3) - inner.powi(3)) / (outer * outer - inner * inner);
        for k in 0..ELEMENTS_A_RING {
            let turn = (k as f64 + 0.5 * (ring % 2) as f64) / ELEMENTS_A_RING as f64;
            elements.push(Point::polar(distance, std::f64::consts::TAU * turn));
        }
    }
    elements
}

/// Midpoints of equal cells.
fn rectangle(half_x: f64, half_y: f64) -> Vec<Element> {
    let along = |k: usize| (2 * k + 1) as f64 / ELEMENTS_A_SIDE as f64 - 1.0;
    (0..ELEMENTS_A_SIDE * ELEMENTS_A_SIDE)
        .map(|k| {
            Point::new(
                half_x * along(k % ELEMENTS_A_SIDE),
                half_y * along(k / ELEMENTS_A_SIDE),
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_discs_elements_reproduce_its_friction_radius() {
        let mean = disc(0.03).iter().map(|e| e.norm()).sum::<f64>() / disc(0.03).len() as f64;
        assert!((mean / 0.02 - 1.0).abs() < 1e-12, "mean radius {mean}");
    }

    #[test]
    fn a_size_that_is_no_length_is_named() {
        let object = Object {
            solid: Solid::Box {
                half_size: [0.0, 0.03, 0.02],
            },
            mass: 0.1,
            colour: None,
            marker: None,
        };
        let error = Body::new(&object).expect_err("a box without sizes");
        assert!(error.to_string().contains("half_size[0]"));
    }
}
