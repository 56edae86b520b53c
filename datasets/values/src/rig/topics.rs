//! Where the logs keep what is read: topics, the paths of their messages' fields, frames and clock.

use serde::{Deserialize, Deserializer, Serialize};

/// Topic names and field paths. A topic that a rig file leaves out, or a path of one, has its default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Topics {
    /// Object centroids.
    #[serde(default = "FieldTopic::centroid", deserialize_with = "centroid")]
    pub centroid: FieldTopic,
    /// Commanded end-effector velocity.
    #[serde(default = "FieldTopic::command", deserialize_with = "command")]
    pub command: FieldTopic,
    /// Measured end-effector velocity and position, where they are logged.
    #[serde(default)]
    pub state: StateTopic,
    /// The object's pose, where the tracker knows its yaw.
    #[serde(default, skip_serializing_if = "PoseTopic::is_default")]
    pub pose: PoseTopic,
    /// Images, which are looked at where a log has no centroids.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub image: Option<ImageTopic>,
}

impl Default for Topics {
    fn default() -> Self {
        Self {
            centroid: FieldTopic::centroid(),
            command: FieldTopic::command(),
            state: StateTopic::default(),
            pose: PoseTopic::default(),
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
}

/// The topic of the end effector's measured state; by default `nav_msgs/msg/Odometry` in frame `table`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Stated", into = "Stated")]
pub struct StateTopic {
    /// Name, stamp and velocity, in m/s.
    pub topic: FieldTopic,
    /// Path of the position along x, in m; a message without it gives the velocity alone.
    pub position_x: String,
    /// Path of the position along y, in m.
    pub position_y: String,
}

impl Default for StateTopic {
    fn default() -> Self {
        let velocity = ["twist.twist.linear.x", "twist.twist.linear.y"];
        Self {
            topic: FieldTopic::new("/striker/state", velocity[0], velocity[1]),
            position_x: "pose.pose.position.x".into(),
            position_y: "pose.pose.position.y".into(),
        }
    }
}

/// The topic of the object's pose; by default `geometry_msgs/msg/PoseStamped` in frame `table`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Stated", into = "Stated")]
pub struct PoseTopic {
    /// Name, stamp and position, in m.
    pub topic: FieldTopic,
    /// Path of the quaternion, whose fields are `x`, `y`, `z` and `w`.
    pub orientation: String,
}

impl Default for PoseTopic {
    fn default() -> Self {
        Self {
            topic: FieldTopic::new("/object/pose", "pose.position.x", "pose.position.y"),
            orientation: "pose.orientation".into(),
        }
    }
}

impl PoseTopic {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// The topic of images; their message types are known, so that no paths of fields are needed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageTopic {
    /// Topic name.
    pub name: String,
    /// Path of the stamp: `header.stamp` or `timestamp`, as the message type has it.
    #[serde(default = "ImageTopic::header_stamp")]
    pub stamp: String,
}

impl ImageTopic {
    /// Paths that a stamp may have: ROS's and Foxglove's.
    pub(super) const STAMPS: [&str; 2] = ["header.stamp", "timestamp"];

    /// A topic whose messages have a header.
    pub fn new(name: &str) -> Self {
        Self {
            name: name.into(),
            stamp: Self::header_stamp(),
        }
    }

    fn header_stamp() -> String {
        Self::STAMPS[0].into()
    }
}

/// A topic as it stands in a file: what is left out has its default. Which keys a topic has [`super::keys`] says.
#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Stated {
    name: Option<String>,
    stamp: Option<String>,
    x: Option<String>,
    y: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    position_x: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    position_y: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    orientation: Option<String>,
}

impl Stated {
    fn of(topic: FieldTopic) -> Self {
        Self {
            name: Some(topic.name),
            stamp: Some(topic.stamp),
            x: Some(topic.x),
            y: Some(topic.y),
            ..Self::default()
        }
    }

    fn or(self, default: FieldTopic) -> FieldTopic {
        FieldTopic {
            name: self.name.unwrap_or(default.name),
            stamp: self.stamp.unwrap_or(default.stamp),
            x: self.x.unwrap_or(default.x),
            y: self.y.unwrap_or(default.y),
        }
    }
}

fn centroid<'de, D: Deserializer<'de>>(deserializer: D) -> Result<FieldTopic, D::Error> {
    Stated::deserialize(deserializer).map(|stated| stated.or(FieldTopic::centroid()))
}

fn command<'de, D: Deserializer<'de>>(deserializer: D) -> Result<FieldTopic, D::Error> {
    Stated::deserialize(deserializer).map(|stated| stated.or(FieldTopic::command()))
}

impl From<Stated> for StateTopic {
    fn from(mut stated: Stated) -> Self {
        let default = Self::default();
        Self {
            position_x: stated.position_x.take().unwrap_or(default.position_x),
            position_y: stated.position_y.take().unwrap_or(default.position_y),
            topic: stated.or(default.topic),
        }
    }
}

/// Positions stand in a file only where they are not the default.
impl From<StateTopic> for Stated {
    fn from(state: StateTopic) -> Self {
        let default = StateTopic::default();
        Self {
            position_x: (state.position_x != default.position_x).then_some(state.position_x),
            position_y: (state.position_y != default.position_y).then_some(state.position_y),
            ..Self::of(state.topic)
        }
    }
}

impl From<Stated> for PoseTopic {
    fn from(mut stated: Stated) -> Self {
        let default = Self::default();
        Self {
            orientation: stated.orientation.take().unwrap_or(default.orientation),
            topic: stated.or(default.topic),
        }
    }
}

impl From<PoseTopic> for Stated {
    fn from(pose: PoseTopic) -> Self {
        Self {
            orientation: Some(pose.orientation),
            ..Self::of(pose.topic)
        }
    }
}

/// `[frames]`. Logs are read into the frame `table` and onto the arm's clock by it; the defaults change nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Frames {
    /// The frame that commands and states are logged in.
    pub command: CommandFrame,
    /// Whether the camera's y axis points the other way: centroids' y, and yaws, are negated.
    pub mirrored: bool,
    /// Seconds by which the camera's stamps lie behind the arm's; below zero, before them.
    pub camera_delay: f64,
}

impl Frames {
    /// Whether nothing is stated.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// The frame that commands are logged in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CommandFrame {
    /// The table's.
    #[default]
    Table,
    /// The arm's base: turned by `robot.base_yaw` about `robot.base`.
    Base,
    /// The tool's, which turns with the arm: a command tells no direction on the table. The measured state takes its place.
    Tool,
}
