//! Strike logs as MCAP files: reading samples out of any, writing ours.
//!
//! [`read()`] gives the stamped coordinates of chosen topics, whatever the messages are encoded in: ROS 2 CDR by the
//! file's own `ros2msg` schema, ROS 1, JSON, or protobuf by the file's own descriptor set. A topic's name and the dotted
//! paths of its fields are settings ([`values::FieldTopic`]); each schema is compiled once to a plan that walks a
//! message's bytes past all that is not asked for.
//!
//! A log is a file or the folder of a split recording; rosbag2's SQLite is read as MCAP is (feature `sqlite`).
//!
//! A file may be cut off, damaged or hostile: what is whole is given, what is lost is reported ([`Damage`]), and nothing that
//! a file says of its own sizes is believed before it is checked.

mod decode;
mod error;
pub mod part;
mod path;
pub mod read;
pub mod write;

pub use decode::{DecodeError, Decoder, Fields, MOST_MORE, More, SchemaText};
pub use error::LogError;
pub use read::{
    Damage, Event, Limits, RawChannel, Sample, SeenChannel, Summary, TopicCount, TopicRequest,
    bag_files, hash, is_log, read, read_from,
};
