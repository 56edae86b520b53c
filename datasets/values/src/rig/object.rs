//! What is struck, and the tip that strikes it.

use std::f64::consts::{FRAC_PI_2, PI};

use serde::{Deserialize, Serialize};

use super::RigError;
use crate::{Interval, Point, exact};

/// The object that is struck.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Stated", into = "Stated")]
pub struct Object {
    /// Its shape and sizes.
    pub solid: Solid,
    /// Mass in kg.
    pub mass: f64,
    /// Its colour in images.
    pub colour: Option<Colour>,
    /// The marker on its upper face.
    pub marker: Option<Marker>,
}

impl Object {
    /// Its shape.
    pub fn shape(&self) -> Shape {
        self.solid.shape()
    }
}

/// A shape with its sizes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Solid {
    /// An upright cylinder.
    Cylinder {
        /// Radius in m.
        radius: f64,
        /// Half of the height in m.
        half_height: f64,
    },
    /// A box whose faces are parallel to the table's axes when it rests at yaw 0.
    Box {
        /// Half sizes along x, y, z in m.
        half_size: [f64; 3],
    },
    /// A ball.
    Sphere {
        /// Radius in m.
        radius: f64,
    },
}

impl Solid {
    /// Its shape.
    pub fn shape(&self) -> Shape {
        match self {
            Self::Cylinder { .. } => Shape::Cylinder,
            Self::Box { .. } => Shape::Box,
            Self::Sphere { .. } => Shape::Sphere,
        }
    }

    /// Distance, in m, from the centre to the farthest part of the outline, seen from above.
    pub fn reach(&self) -> f64 {
        match *self {
            Self::Cylinder { radius, .. } | Self::Sphere { radius } => radius,
            Self::Box { half_size: half } => half[0].hypot(half[1]),
        }
    }

    /// Distance, in m, from the centre to the nearest part of the outline, seen from above.
    pub fn narrowest(&self) -> f64 {
        match *self {
            Self::Cylinder { radius, .. } | Self::Sphere { radius } => radius,
            Self::Box { half_size: half } => half[0].min(half[1]),
        }
    }

    /// Distance, in m, from the centre to the outline in a direction, seen from above, of an object that stands at yaw 0.
    pub fn outline(&self, direction: Point) -> f64 {
        match *self {
            Self::Cylinder { radius, .. } | Self::Sphere { radius } => radius,
            Self::Box {
                half_size: [x, y, _],
            } => {
                let most = f64::max(direction.x.abs() / x, direction.y.abs() / y);
                direction.norm() / most.max(f64::MIN_POSITIVE)
            }
        }
    }

    /// Height of its centre above the table on which it rests, in m.
    pub fn half_height(&self) -> f64 {
        match *self {
            Self::Cylinder { half_height, .. } => half_height,
            Self::Box { half_size: half } => half[2],
            Self::Sphere { radius } => radius,
        }
    }

    /// Radius of its outline seen from above, in m, where that is round.
    pub fn radius(&self) -> Option<f64> {
        match *self {
            Self::Cylinder { radius, .. } | Self::Sphere { radius } => Some(radius),
            Self::Box { .. } => None,
        }
    }

    /// Half sides along x and y, in m, of an outline with corners.
    pub fn half_sides(&self) -> Option<[f64; 2]> {
        match *self {
            Self::Box { half_size: half } => Some([half[0], half[1]]),
            Self::Cylinder { .. } | Self::Sphere { .. } => None,
        }
    }

    /// The least turn, in rad, after which it looks the same from above; none for what is round.
    pub fn period(&self) -> Option<f64> {
        let [x, y] = self.half_sides()?;
        Some(if x == y { FRAC_PI_2 } else { PI })
    }

    /// This solid with all sizes times `factor`.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        match &mut self {
            Self::Cylinder { radius, .. } | Self::Sphere { radius } => *radius *= factor,
            Self::Box { half_size } => *half_size = half_size.map(|size| size * factor),
        }
        if let Self::Cylinder { half_height, .. } = &mut self {
            *half_height *= factor;
        }
        self
    }
}

/// The object as files state it: a shape, and the sizes that it has.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Stated {
    shape: Shape,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    radius: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    half_height: Option<f64>,
    #[serde(default, with = "exact", skip_serializing_if = "Option::is_none")]
    half_size: Option<[f64; 3]>,
    mass: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    colour: Option<Colour>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    marker: Option<Marker>,
}

impl TryFrom<Stated> for Object {
    type Error = RigError;

    fn try_from(stated: Stated) -> Result<Self, RigError> {
        let is = |shapes: &[Shape]| shapes.contains(&stated.shape);
        for (key, size, belongs) in [
            (
                "radius",
                stated.radius,
                is(&[Shape::Cylinder, Shape::Sphere]),
            ),
            ("half_height", stated.half_height, is(&[Shape::Cylinder])),
            (
                "half_size",
                stated.half_size.map(|[size, ..]| size),
                is(&[Shape::Box]),
            ),
        ] {
            if let Some(size) = size.filter(|_| !belongs) {
                return Err(RigError::Value {
                    key: format!("object.{key}"),
                    value: size.to_string(),
                    why: format!("is no size of a {}; take the key out", stated.shape.name()),
                });
            }
        }
        let missing = |key: &str, mend: &str| RigError::MissingKey {
            key: format!("object.{key}"),
            mend: mend.into(),
        };
        let radius = || {
            stated
                .radius
                .ok_or_else(|| missing("radius", "radius = 0.030   # m"))
        };
        let solid = match stated.shape {
            Shape::Cylinder => Solid::Cylinder {
                radius: radius()?,
                half_height: stated
                    .half_height
                    .ok_or_else(|| missing("half_height", "half_height = 0.020   # m"))?,
            },
            Shape::Box => Solid::Box {
                half_size: stated.half_size.ok_or_else(|| {
                    missing(
                        "half_size",
                        "half_size = [0.030, 0.030, 0.020]   # m, along x, y, z",
                    )
                })?,
            },
            Shape::Sphere => Solid::Sphere { radius: radius()? },
        };
        Ok(Self {
            solid,
            mass: stated.mass,
            colour: stated.colour,
            marker: stated.marker,
        })
    }
}

impl From<Object> for Stated {
    fn from(object: Object) -> Self {
        let (radius, half_height, half_size) = match object.solid {
            Solid::Cylinder {
                radius,
                half_height,
            } => (Some(radius), Some(half_height), None),
            Solid::Box { half_size } => (None, None, Some(half_size)),
            Solid::Sphere { radius } => (Some(radius), None, None),
        };
        Self {
            shape: object.shape(),
            radius,
            half_height,
            half_size,
            mass: object.mass,
            colour: object.colour,
            marker: object.marker,
        }
    }
}

crate::named! {
    /// Shapes that carom models.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum Shape {
        /// An upright cylinder.
        Cylinder = "cylinder",
        /// A box whose faces are parallel to the table's axes when it rests.
        Box = "box",
        /// A ball.
        Sphere = "sphere",
    }
}

impl Shape {
    /// Whether it is round seen from above: struck alike from everywhere, however it is turned.
    pub fn is_round(self) -> bool {
        match self {
            Self::Cylinder | Self::Sphere => true,
            Self::Box => false,
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

/// An ArUco marker or an AprilTag that lies on the object's upper face.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Marker {
    /// OpenCV's name of its dictionary, such as `DICT_APRILTAG_36h11`.
    pub dictionary: String,
    /// Its number in it.
    pub id: usize,
    /// Side of its black square, in m.
    pub size: f64,
    /// Its centre from the object's, in m, along the object's axes.
    #[serde(default)]
    pub offset: Point,
    /// From the object's x axis to the marker's, which runs to the right as it is printed, in rad.
    #[serde(default)]
    pub yaw: f64,
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
