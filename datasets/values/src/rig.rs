//! The rig file: what is known of a set-up before anything is measured.

mod arm;
mod check;
mod error;
mod keys;
mod topics;
mod vision;

use std::path::Path;

pub use arm::Obstacle;
use serde::{Deserialize, Serialize};

use crate::Point;

pub use error::RigError;
pub use topics::{FieldTopic, PoseTopic, StateTopic, Topics};
pub use vision::{Colour, ImageTopic, StampMark};

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
    /// Its colour in images.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub colour: Option<Colour>,
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
    /// Focal lengths and principal point `[fx, fy, cx, cy]` in px; pixel centres are whole numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub matrix: Option<[f64; 4]>,
    /// Distortion `[k1, k2, p1, p2, k3]`: `plumb_bob` of ROS and OpenCV.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distortion: Option<[f64; 5]>,
    /// Place of its optical centre in the frame `table`, in m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// Orientation of its optical frame (z forward, x right, y down) in the frame `table`, as `[qx, qy, qz, qw]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<[f64; 4]>,
    /// Exposure of an image, in s.
    #[serde(default, skip_serializing_if = "vision::is_zero")]
    pub exposure: f64,
    /// From the exposure of an image's first row to that of its last, in s; 0 for a global shutter.
    #[serde(default, skip_serializing_if = "vision::is_zero")]
    pub readout: f64,
    /// What an image's stamp marks.
    #[serde(default, skip_serializing_if = "vision::is_middle")]
    pub stamp: StampMark,
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
    /// Where the axis of its base stands, in m; the origin unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base: Option<Point>,
    /// Radius in m about the base's axis that the tip keeps clear of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keep_out: Option<f64>,
    /// Distances in m from the base's axis that the tip's centre may have.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reach: Option<Interval>,
    /// Jerk of the ramps, in m/s³; none for an arm that changes its acceleration at once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub jerk: Option<f64>,
    /// Height of the tip's centre above the table when it strikes, in m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strike_height: Option<f64>,
    /// Height of the tip's centre above the table on its way, clear of the object, in m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub travel_height: Option<f64>,
    /// Roll, pitch and yaw of the tool while it strikes, in rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool_orientation: Option<[f64; 3]>,
    /// The tip's centre in the flange's frame: x, y, z in m, roll, pitch, yaw in rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool_offset: Option<[f64; 6]>,
    /// Mass of the tool, in kg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub payload: Option<f64>,
    /// What it must not touch.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<Obstacle>,
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

    /// Parses and checks the text of a rig file: a value of this type that came from here holds positive,
    /// finite sizes that its shape needs, intervals that are not empty, and units that are plausible.
    pub fn parse(text: &str) -> Result<Self, RigError> {
        keys::check(text)?;
        let rig: Self = toml::from_str(text).map_err(|error| RigError::Parse(error.to_string()))?;
        check::check(&rig)?;
        Ok(rig)
    }

    /// A commented rig file to start from; it reads as [`Rig::demo`] with a cylinder.
    pub fn template() -> &'static str {
        include_str!("rig/template.toml")
    }

    /// The text of a rig file that reads back as this value.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("a rig is plain data")
    }

    /// A rig of the demo's kind: a 100 g cylinder before a small arm.
    pub fn demo(shape: Shape) -> Self {
        let object = match shape {
            Shape::Cylinder => Object {
                shape,
                radius: Some(0.030),
                half_height: Some(0.020),
                half_size: None,
                mass: 0.100,
                colour: None,
            },
            Shape::Box => Object {
                shape,
                radius: None,
                half_height: None,
                half_size: Some([0.030, 0.030, 0.020]),
                mass: 0.150,
                colour: None,
            },
            Shape::Sphere => Object {
                shape,
                radius: Some(0.025),
                half_height: None,
                half_size: None,
                mass: 0.100,
                colour: None,
            },
        };
        Self {
            object,
            striker: Striker {
                tip: Tip::Sphere,
                radius: 0.012,
            },
            table: Table {
                x: [0.10, 1.00].into(),
                y: [-0.60, 0.60].into(),
            },
            camera: Camera {
                rate: 60.0,
                noise: 0.0007,
                centre: Point::new(0.45, 0.0),
                matrix: None,
                distortion: None,
                position: None,
                orientation: None,
                exposure: 0.0,
                readout: 0.0,
                stamp: StampMark::Middle,
            },
            robot: Robot::limits([0.4, 1.0].into(), [-0.80, 0.80].into(), 5.0),
            topics: Topics::default(),
        }
    }
}

#[cfg(test)]
mod tests;
