//! From a log, a file or a folder of rosbag2, to samples: every message of the wanted topics, in the order in which the recorder received them.
//!
//! The file is streamed: at most one record, one unpacked chunk and the schemas are in memory. A chunk with a CRC is
//! checked before any of its messages is given; in a file that is cut off, what is whole of the last chunk is given too.

mod bag;
mod body;
mod chunk;
mod event;
mod pace;
mod raw;
mod records;
#[cfg(feature = "sqlite")]
mod sqlite;
mod topics;

use std::io::{Read, Seek};
use std::path::Path;

use self::topics::Topics;
use crate::LogError;

pub use self::bag::{bag_files, hash, is_log};
pub use self::event::{Damage, Event, Extent, Limits, Sample, Summary, TopicCount, TopicRequest};
pub use self::raw::{RawChannel, RawMessage, RawSummary, SeenChannel, read_raw};

/// Reads the wanted topics of a log: a file (MCAP, or rosbag2's SQLite, either packed by zstd as a whole), or the folder of a
/// rosbag2 recording, whose files are read as one.
pub fn read(
    path: &Path,
    wanted: &[TopicRequest<'_>],
    limits: Limits,
    sink: &mut dyn FnMut(Event<'_>),
) -> Result<Summary, LogError> {
    let mut topics = Topics::new(wanted, sink);
    let seen = raw::take(path, limits, &mut topics)?;
    topics.summary(&path.display().to_string(), seen)
}

/// Reads the wanted topics of a log from any source; `log` is its name in errors.
pub fn read_from<R: Read + Seek>(
    log: &str,
    source: R,
    wanted: &[TopicRequest<'_>],
    limits: Limits,
    sink: &mut dyn FnMut(Event<'_>),
) -> Result<Summary, LogError> {
    let mut topics = Topics::new(wanted, sink);
    let seen = raw::take_from(log, source, limits, &mut topics)?;
    topics.summary(log, seen)
}
