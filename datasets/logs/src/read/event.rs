//! What comes out of a log: samples, damage, and what was in it.

use values::{FieldTopic, Point};

use crate::More;

/// A stamped pair of coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Nanoseconds on the log's clock: the message's stamp, or the log time where it has none.
    pub stamp: i64,
    /// First coordinate, in the message's unit.
    pub x: f64,
    /// Second coordinate, in the message's unit.
    pub y: f64,
}

impl Sample {
    /// The coordinates of a place or a velocity, at a stamp in nanoseconds.
    pub const fn at(stamp: i64, Point { x, y }: Point) -> Self {
        Self { stamp, x, y }
    }
}

/// What comes out of a log, in the order of the file.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// A message of the wanted topic with this index.
    Sample(usize, Sample),
    /// A sample of a topic of which further numbers are wanted, with these.
    Extended(usize, Sample, More),
    /// Messages are lost between those before and those after.
    Lost(&'a Damage),
}

/// A place where a file is not whole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Byte of the file.
    pub offset: u64,
    /// How much it takes.
    pub extent: Extent,
    /// What was found.
    pub why: String,
}

/// How much of a file a damage takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// One chunk or record.
    Part,
    /// Everything after: the file is cut off or cannot be followed further.
    Rest,
    /// Some bytes of the messages that no chunk's CRC covers; which ones is not known.
    Unlocated,
    /// Nothing but the index and statistics behind the messages.
    Index,
}

/// Messages of one topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TopicCount {
    /// Its name.
    pub name: String,
    /// Its schema's name, empty for none.
    pub schema: String,
    /// Messages seen.
    pub messages: u64,
}

/// What was in a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// SHA-256 of the whole file, in hex.
    pub sha256: String,
    /// Messages seen, over all topics.
    pub messages: u64,
    /// Every topic that the file has, by name.
    pub topics: Vec<TopicCount>,
    /// For each wanted topic, messages that could not be decoded and why the first could not.
    pub undecodable: Vec<(u64, String)>,
    /// For each wanted topic that has stamps, seconds of log time that pass in one of them, with the standard error; none where too few tell it.
    pub paces: Vec<Option<[f64; 2]>>,
    /// For each wanted topic, whether its schema lacks the stamp, so that log times were taken.
    pub unstamped: Vec<bool>,
    /// Where the file is not whole; empty for a whole one, and of very many places the first ones and the end.
    pub damage: Vec<Damage>,
}

impl Summary {
    /// Whether messages after some place are missing.
    pub fn truncated(&self) -> bool {
        self.damage
            .iter()
            .any(|damage| damage.extent == Extent::Rest)
    }
}

/// A topic that is to be read.
#[derive(Clone, Copy, Debug)]
pub struct TopicRequest<'a> {
    /// Its name and field paths.
    pub topic: &'a FieldTopic,
    /// Paths of further numbers, at most [`MOST_MORE`](crate::MOST_MORE); a message need not have them.
    pub more: &'a [String],
    /// Whether a log without it is an error.
    pub required: bool,
}

impl<'a> TopicRequest<'a> {
    /// A topic without which a log is an error.
    pub fn required(topic: &'a FieldTopic) -> Self {
        Self {
            topic,
            more: &[],
            required: true,
        }
    }
}

/// How large a file's parts may be, in bytes. One record is held at a time, and no chunk.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// A record as it stands in the file, chunks included.
    pub record: usize,
    /// A chunk when unpacked.
    pub chunk: usize,
    /// All schemas and channels together.
    pub schemas: usize,
    /// Damaged places that are listed.
    pub damage: usize,
}

impl Default for Limits {
    /// 64 MB for a record and for an unpacked chunk.
    fn default() -> Self {
        Self {
            record: 64 << 20,
            chunk: 64 << 20,
            schemas: 16 << 20,
            damage: 1000,
        }
    }
}
