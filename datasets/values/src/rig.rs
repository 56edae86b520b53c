//! The rig file: what is known of a set-up before anything is measured.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::Point;

/// What is known of the set-up; `rig.toml`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rig {
    /// What is struck.
    pub object: Object,
    /// What strikes it.
    pub striker: Striker,
    /// Where it slides.
    pub table: Table,
    /// What sees it.
    pub camera: Camera,
    /// What the arm may do.
    pub robot: Robot,
    /// Where the logs keep what is read.
    #[serde(default)]
    pub topics: Topics,
}

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
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub half_size: Option<[f64; 3]>,
    /// Mass in kg.
    pub mass: f64,
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

/// A closed interval, in files an array `[low, high]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f64; 2]", into = "[f64; 2]")]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// Whether the value lies inside, ends included; NaN never does.
    pub fn contains(self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    /// The value, moved to the nearer end where it lies outside.
    pub fn clamp(self, value: f64) -> f64 {
        value.clamp(self.low, self.high)
    }
}

impl From<[f64; 2]> for Interval {
    fn from([low, high]: [f64; 2]) -> Self {
        Self { low, high }
    }
}

impl From<Interval> for [f64; 2] {
    fn from(interval: Interval) -> Self {
        [interval.low, interval.high]
    }
}

/// The table's bounds in frame `table`, in m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Bounds along x.
    pub x: Interval,
    /// Bounds along y.
    pub y: Interval,
}

impl Table {
    /// Whether a point lies on the table; NaN never does.
    pub fn contains(&self, point: Point) -> bool {
        self.x.contains(point.x) && self.y.contains(point.y)
    }
}

/// The camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Frames per second, in Hz.
    pub rate: f64,
    /// Standard deviation of a centroid's coordinate, in m.
    pub noise: f64,
    /// The point of the table it looks down on.
    pub centre: Point,
}

/// Limits of the arm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Robot {
    /// Striking speeds that it may be told, in m/s.
    pub speed: Interval,
    /// Striking angles that it may be told, in rad.
    pub angle: Interval,
    /// Acceleration of the trapezoidal profile, in m/s².
    pub acceleration: f64,
}

/// Topic names and field paths.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Topics {
    /// Object centroids.
    #[serde(default = "FieldTopic::centroid")]
    pub centroid: FieldTopic,
    /// Commanded end-effector velocity.
    #[serde(default = "FieldTopic::command")]
    pub command: FieldTopic,
    /// Measured end-effector velocity, where it is logged.
    #[serde(default = "FieldTopic::state")]
    pub state: FieldTopic,
}

impl Default for Topics {
    fn default() -> Self {
        Self {
            centroid: FieldTopic::centroid(),
            command: FieldTopic::command(),
            state: FieldTopic::state(),
        }
    }
}

/// One topic and the dotted paths of what is read from its messages.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FieldTopic {
    /// Topic name.
    pub name: String,
    /// Path of the stamp.
    pub stamp: String,
    /// Path of the first coordinate.
    pub x: String,
    /// Path of the second coordinate.
    pub y: String,
}

impl FieldTopic {
    fn new(name: &str, x: &str, y: &str) -> Self {
        Self {
            name: name.into(),
            stamp: "header.stamp".into(),
            x: x.into(),
            y: y.into(),
        }
    }

    fn centroid() -> Self {
        Self::new("/object/centroid", "point.x", "point.y")
    }

    fn command() -> Self {
        Self::new("/striker/command", "twist.linear.x", "twist.linear.y")
    }

    fn state() -> Self {
        Self::new("/striker/state", "twist.twist.linear.x", "twist.twist.linear.y")
    }
}

/// Why a rig file was not accepted.
#[derive(Debug, thiserror::Error)]
pub enum RigError {
    /// The file could not be read.
    #[error("read {path}: {source}")]
    Read {
        /// The file.
        path: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// It is not TOML, or a key is missing, unknown or of another type.
    #[error("{0}")]
    Parse(String),
    /// A value makes no sense.
    #[error("accept {key} = {value}: {why}")]
    Value {
        /// Dotted key.
        key: String,
        /// What stands there.
        value: String,
        /// What it must be.
        why: String,
    },
}

impl Rig {
    /// Reads and checks a rig file. Errors name the file's line or the key, and how to mend it.
    pub fn load(path: &Path) -> Result<Self, RigError> {
        let text = std::fs::read_to_string(path).map_err(|source| RigError::Read {
            path: path.display().to_string(),
            source,
        })?;
        Self::parse(&text)
    }

    /// Parses and checks the text of a rig file.
    pub fn parse(text: &str) -> Result<Self, RigError> {
        toml::from_str(text).map_err(|error| RigError::Parse(error.to_string()))
    }

    /// The text of a rig file that reads back as this value.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("a rig is plain data")
    }

    /// A rig of the demo's kind: a 100 g cylinder before a small arm.
    pub fn demo(shape: Shape) -> Self {
        let object = match shape {
            Shape::Cylinder => Object { shape, radius: Some(0.030), half_height: Some(0.020), half_size: None, mass: 0.100 },
            Shape::Box => Object { shape, radius: None, half_height: None, half_size: Some([0.030, 0.030, 0.020]), mass: 0.150 },
            Shape::Sphere => Object { shape, radius: Some(0.025), half_height: None, half_size: None, mass: 0.100 },
        };
        Self {
            object,
            striker: Striker { tip: Tip::Sphere, radius: 0.012 },
            table: Table { x: [0.10, 1.00].into(), y: [-0.60, 0.60].into() },
            camera: Camera { rate: 60.0, noise: 0.0007, centre: Point::new(0.45, 0.0) },
            robot: Robot { speed: [0.4, 1.0].into(), angle: [-0.80, 0.80].into(), acceleration: 5.0 },
            topics: Topics::default(),
        }
    }
}
