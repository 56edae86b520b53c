//! What is struck, and the tip that strikes it.

use serde::{Deserialize, Serialize};

use super::exact;
use crate::Interval;

/// The object that is struck; which sizes are given depends on the shape.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Object {
    /// Its shape.
    pub shape: Shape,
    /// Radius in m, for `cylinder` and `sphere`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
    /// Half of the height in m, for `cylinder`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub half_height: Option<f64>,
    /// Half sizes along x, y, z in m, for `box`.
    #[serde(
        default,
        deserialize_with = "exact::optional",
        skip_serializing_if = "Option::is_none"
    )]
    pub half_size: Option<[f64; 3]>,
    /// Mass in kg.
    pub mass: f64,
    /// Its colour in images.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub colour: Option<Colour>,
}

impl Object {
    /// From its centre to the part of its edge that is farthest, in m; 0 where no size is given.
    pub fn widest(&self) -> f64 {
        let corner = self.half_size.map(|[x, y, _]| x.hypot(y));
        self.radius.or(corner).unwrap_or(0.0)
    }

    /// And to the nearest.
    pub fn narrowest(&self) -> f64 {
        let side = self.half_size.map(|[x, y, _]| x.min(y));
        self.radius.or(side).unwrap_or(0.0)
    }
}

/// Shapes that carom models.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// An upright cylinder.
    Cylinder,
    /// A box whose faces are parallel to the table's axes when it rests.
    Box,
    /// A ball.
    Sphere,
}

impl Shape {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cylinder => "cylinder",
            Self::Box => "box",
            Self::Sphere => "sphere",
        }
    }
}

/// The striking tip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Striker {
    /// Its shape.
    pub tip: Tip,
    /// Its radius in m.
    pub radius: f64,
}

/// Tip shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Tip {
    /// A ball.
    Sphere,
    /// An upright rod.
    Cylinder,
}

/// The object's colour as ranges of hue, saturation and value (HSV of the image's 8-bit R'G'B').
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Colour {
    /// Hue in degrees; `low` > `high` wraps around 360.
    pub hue: Interval,
    /// Saturation, 0 to 1.
    pub saturation: Interval,
    /// Value, 0 to 1.
    pub value: Interval,
}

impl Colour {
    /// The demo's object: red.
    pub fn demo() -> Self {
        Self {
            hue: [340.0, 20.0].into(),
            saturation: [0.45, 1.0].into(),
            value: [0.15, 1.0].into(),
        }
    }
}
