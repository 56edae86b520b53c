//! The plain values that flow through carom: the rig, its strikes and their tracks.
//!
//! SI units everywhere (m, s, kg, rad, m/s). Positions are in the frame `table`: origin and axes of the
//! robot's base projected onto the table, x away from the robot, y to its left, z up. Angles are measured
//! from +x, counter-clockwise. Nothing here knows of logs, tables, simulators or files other than `rig.toml`.

mod delivery;
mod exact;
mod geometry;
mod interval;
mod median;
mod named;
mod residual;
mod rig;
mod sentence;
mod slide;
mod split;
mod stop_errors;
mod strays;
mod strike;

pub use delivery::{ArmScatter, Deliveries, arm_scatter, calibrated};
pub use geometry::{Point, wrap_angle};
pub use interval::Interval;
pub use median::median;
pub use residual::{LaunchResidual, Residual};
pub use rig::{
    Camera, Colour, CommandFrame, Fence, FieldTopic, Frames, ImageTopic, Marker, Object, Obstacle,
    PoseTopic, Rig, RigError, Robot, Shape, Solid, StampMark, StateTopic, Striker, Table, Tip,
    Topics,
};
pub use sentence::Sentence;
pub use slide::free_slides;
pub use split::{Split, halvings, split_of};
pub use stop_errors::StopErrors;
pub use strays::Strays;
pub use strike::{Command, Conditions, Delivered, End, Reject, RejectReason, Strike, Track, Yaw};
