//! In which frames and on which clock the logs were written: what `carom check` found and a person confirmed.

use serde::{Deserialize, Serialize};

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
