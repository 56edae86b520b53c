//! The rig file: what is known of a set-up before anything is measured.

mod check;
mod keys;
mod vision;

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::Point;

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
    /// Images, which are looked at where a log has no centroids.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub image: Option<ImageTopic>,
}

impl Default for Topics {
    fn default() -> Self {
        Self {
            centroid: FieldTopic::centroid(),
            command: FieldTopic::command(),
            state: FieldTopic::state(),
            image: None,
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
        Self::new(
            "/striker/state",
            "twist.twist.linear.x",
            "twist.twist.linear.y",
        )
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
    #[error("parse the rig file: {0}")]
    Parse(String),
    /// A key that the format does not have.
    #[error(
        "accept the key `{key}` on line {line}: there is none of that name; did you mean `{nearest}`?"
    )]
    UnknownKey {
        /// Dotted key.
        key: String,
        /// Line of the file, from 1.
        line: usize,
        /// The known key most like it, dotted.
        nearest: String,
    },
    /// A key that must be there is not.
    #[error("find the key `{key}`: add a line such as `{mend}`")]
    MissingKey {
        /// Dotted key.
        key: String,
        /// A line that would mend it.
        mend: String,
    },
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
            robot: Robot {
                speed: [0.4, 1.0].into(),
                angle: [-0.80, 0.80].into(),
                acceleration: 5.0,
            },
            topics: Topics::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The template with one piece of text replaced, and what is then said of it.
    fn refusal(from: &str, to: &str) -> String {
        assert!(Rig::template().contains(from), "{from}");
        match Rig::parse(&Rig::template().replacen(from, to, 1)) {
            Err(error) => error.to_string(),
            Ok(_) => panic!("accepted {to}"),
        }
    }

    #[test]
    fn the_template_is_the_demo_rig_and_survives_a_round_trip() {
        let rig = Rig::parse(Rig::template()).expect("the template parses");
        assert_eq!(rig, Rig::demo(Shape::Cylinder));
        for shape in [Shape::Cylinder, Shape::Box, Shape::Sphere] {
            let rig = Rig::demo(shape);
            assert_eq!(Rig::parse(&rig.to_toml()).expect("parses"), rig);
        }
    }

    #[test]
    fn topics_may_be_left_out() {
        let text = Rig::template()
            .split("[topics.centroid]")
            .next()
            .expect("text")
            .to_string();
        assert_eq!(Rig::parse(&text).expect("parses").topics, Topics::default());
    }

    #[test]
    fn an_unknown_key_is_named_with_its_line_and_the_nearest_known_one() {
        let text = refusal("radius = 0.030 ", "raduis = 0.030 ");
        assert!(
            text.contains("`object.raduis` on line 7") && text.contains("`object.radius`"),
            "{text}"
        );
        let text = refusal("[camera]", "[kamera]");
        assert!(
            text.contains("`kamera`") && text.contains("`camera`"),
            "{text}"
        );
        let text = refusal("mass = 0.100", "mass = 0.1\nacceleration = 5.0");
        assert!(
            text.contains("`object.acceleration`") && text.contains("`robot.acceleration`"),
            "{text}"
        );
        let text = refusal("stamp = \"header.stamp\"", "time = \"header.stamp\"");
        assert!(text.contains("`topics.centroid.time`"), "{text}");
    }

    #[test]
    fn a_missing_key_comes_with_the_line_to_add() {
        assert!(
            refusal("mass = 0.100", "").contains("`object.mass`: add a line such as `mass = 0.100")
        );
        assert!(refusal("half_height = 0.020", "").contains("`object.half_height`"));
        assert!(refusal("[striker]", "[topics]\n[table.z]").contains("`table.z`"));
        assert!(
            Rig::parse("")
                .expect_err("empty")
                .to_string()
                .contains("`object`")
        );
        let cube = refusal("shape = \"cylinder\"", "shape = \"box\"");
        assert!(
            cube.contains("object.radius = 0.03: is no size of a box"),
            "{cube}"
        );
    }

    #[test]
    fn a_box_needs_its_half_size() {
        let mut rig = Rig::demo(Shape::Box);
        rig.object.half_size = None;
        assert!(
            Rig::parse(&rig.to_toml())
                .expect_err("refused")
                .to_string()
                .contains("`object.half_size`")
        );
    }

    #[test]
    fn values_that_make_no_sense_are_refused() {
        for (from, to, said) in [
            ("radius = 0.030 ", "radius = 30.0 ", "millimetres?"),
            ("radius = 0.030 ", "radius = -0.03 ", "above 0"),
            ("radius = 0.030 ", "radius = nan ", "finite"),
            ("mass = 0.100", "mass = 100", "grams?"),
            ("mass = 0.100", "mass = inf", "finite"),
            ("rate = 60.0", "rate = 0", "above 0"),
            ("noise = 0.0007", "noise = 0.7", "pixels?"),
            ("x = [0.10, 1.00]", "x = [1.00, 0.10]", "reversed"),
            ("x = [0.10, 1.00]", "x = [100, 1000]", "millimetres?"),
            ("y = [-0.60, 0.60]", "y = [0.6, 0.6]", "empty"),
            ("speed = [0.4, 1.0]", "speed = [0.0, 1.0]", "above 0"),
            ("speed = [0.4, 1.0]", "speed = [400, 1000]", "robot.speed"),
            ("angle = [-0.80, 0.80]", "angle = [-45, 45]", "degrees?"),
            (
                "acceleration = 5.0",
                "acceleration = 5000.0",
                "millimetres?",
            ),
            (
                "name = \"/object/centroid\"",
                "name = \"\"",
                "topics.centroid.name",
            ),
            ("shape = \"cylinder\"", "shape = \"cone\"", "cylinder"),
            ("radius = 0.030 ", "radius = \"big\" ", "line 7"),
        ] {
            let text = refusal(from, to);
            assert!(text.contains(said), "{to}: {text}");
        }
    }
}
