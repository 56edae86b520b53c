//! The rig file: what is known of a set-up before anything is measured.

mod camera;
mod check;
mod demo;
mod error;
mod file;
mod keys;
mod object;
mod robot;
mod table;
#[cfg(test)]
mod tests;
mod topics;

use serde::{Deserialize, Serialize};

pub use camera::{Camera, StampMark};
pub use error::RigError;
pub use object::{Colour, Marker, Object, Shape, Solid, Striker, Tip};
pub use robot::{Obstacle, Robot};
pub use table::{Fence, Table};
pub use topics::{CommandFrame, FieldTopic, Frames, ImageTopic, PoseTopic, StateTopic, Topics};

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
    /// The frames and clocks of the logs.
    #[serde(default, skip_serializing_if = "Frames::is_default")]
    pub frames: Frames,
}
