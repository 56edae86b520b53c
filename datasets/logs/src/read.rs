//! From a file to samples: every message of the wanted topics, in the order in which the recorder received them.
//!
//! The file is streamed: at most one record, one unpacked chunk and the schemas are in memory. A chunk with a CRC is
//! checked before any of its messages is given; in a file that is cut off, what is whole of the last chunk is given too.

mod chunk;
mod raw;
mod records;
mod topics;

use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;

use mcap::records::op;
use values::FieldTopic;

use self::chunk::ChunkFault;
use self::records::{Ending, Records};
use self::topics::Topics;
use crate::{LogError, More};

pub use self::raw::{RawChannel, RawMessage, RawSummary, read_raw};

/// How much a file can make the reader hold, in bytes.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// A record as it stands in the file, chunks included.
    pub record: usize,
    /// A chunk when unpacked.
    pub chunk: usize,
    /// A compressed chunk as it stands and unpacked, together.
    pub open_chunk: usize,
    /// All schemas and channels together.
    pub schemas: usize,
    /// Damaged places that are told.
    pub damage: usize,
}

impl Default for Limits {
    /// 64 MB for a record and for an unpacked chunk, so that two files read at once stay well under 256 MB.
    fn default() -> Self {
        Self {
            record: 64 << 20,
            chunk: 64 << 20,
            open_chunk: 96 << 20,
            schemas: 16 << 20,
            damage: 1000,
        }
    }
}

/// A topic that is to be read.
#[derive(Clone, Copy, Debug)]
pub struct Wanted<'a> {
    /// Its name and field paths.
    pub topic: &'a FieldTopic,
    /// Paths of further numbers, at most [`MOST_MORE`](crate::MOST_MORE); a message need not have them.
    pub more: &'a [String],
    /// Whether a log without it is an error.
    pub required: bool,
}

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

/// What comes out of a log, in the order of the file.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// A message of the wanted topic with this index.
    Sample(usize, Sample),
    /// The same of a topic of which further numbers are wanted.
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
    /// Some bytes of the messages that no chunk's CRC covers; which ones cannot be told.
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
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Summary {
    /// SHA-256 of the whole file, in hex.
    pub sha256: String,
    /// Messages seen, over all topics.
    pub messages: u64,
    /// Every topic that the file has, by name.
    pub topics: Vec<TopicCount>,
    /// For each wanted topic, messages that could not be decoded and why the first could not.
    pub undecodable: Vec<(u64, String)>,
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

/// Reads the wanted topics of a log file.
pub fn read(
    path: &Path,
    wanted: &[Wanted<'_>],
    limits: Limits,
    sink: &mut dyn FnMut(Event<'_>),
) -> Result<Summary, LogError> {
    let log = path.display().to_string();
    let file = File::open(path).map_err(|source| LogError::Io {
        log: log.clone(),
        source,
    })?;
    read_from(&log, file, wanted, limits, sink)
}

/// Reads the wanted topics of a log from any source; `log` is its name in errors.
pub fn read_from<R: Read + Seek>(
    log: &str,
    source: R,
    wanted: &[Wanted<'_>],
    limits: Limits,
    sink: &mut dyn FnMut(Event<'_>),
) -> Result<Summary, LogError> {
    let mut records = Records::new(log, source, limits.record)?;
    let mut reading = Reading {
        log,
        limits,
        topics: Topics::new(log, wanted, limits.schemas),
        damage: Vec::new(),
        sink,
    };
    let ending = records.each(&mut |offset, opcode, body| reading.record(offset, opcode, body))?;
    reading.end(ending)?;
    let Reading { topics, damage, .. } = reading;
    topics.summary(records.sha256()?, damage)
}

struct Reading<'a> {
    log: &'a str,
    limits: Limits,
    topics: Topics<'a>,
    damage: Vec<Damage>,
    sink: &'a mut dyn FnMut(Event<'_>),
}

impl Reading<'_> {
    /// One record of the file.
    fn record(&mut self, offset: u64, opcode: u8, body: &[u8]) -> Result<(), LogError> {
        if opcode == op::CHUNK {
            return self.chunk(offset, body, true);
        }
        let outcome = self.topics.record(opcode, body, false, self.sink)?;
        if let Err(why) = outcome {
            self.lose(offset, Extent::Part, why);
        }
        Ok(())
    }

    fn chunk(&mut self, offset: u64, body: &[u8], whole: bool) -> Result<(), LogError> {
        let (topics, sink) = (&mut self.topics, &mut *self.sink);
        let mut wrong = None;
        let outcome = chunk::each(body, whole, &self.limits, &mut |opcode, body, checked| {
            if let Err(why) = topics.record(opcode, body, checked, sink)? {
                wrong.get_or_insert(why);
            }
            Ok(())
        });
        match outcome {
            Ok(()) => {}
            Err(ChunkFault::Damaged(why)) => wrong = Some(why),
            Err(ChunkFault::Compression(compression)) => {
                return Err(LogError::Compression {
                    log: self.log.into(),
                    compression,
                });
            }
            Err(ChunkFault::TooLarge { size, limit }) => {
                let log = self.log.into();
                return Err(LogError::TooLarge {
                    log,
                    what: "chunk",
                    offset,
                    size,
                    limit,
                });
            }
            Err(ChunkFault::Log(error)) => return Err(error),
        }
        if let (Some(why), true) = (wrong, whole) {
            self.lose(offset, Extent::Part, why);
        }
        Ok(())
    }

    fn lose(&mut self, offset: u64, extent: Extent, why: String) {
        let damage = Damage {
            offset,
            extent,
            why,
        };
        if extent != Extent::Index {
            (self.sink)(Event::Lost(&damage));
        }
        // A file made of damage must not fill the memory with it.
        if extent != Extent::Part || self.damage.len() < self.limits.damage {
            self.damage.push(damage);
        }
    }

    /// What the end of the file says of the whole.
    fn end(&mut self, ending: Ending) -> Result<(), LogError> {
        match ending {
            Ending::Whole => {}
            Ending::Index { offset, why } => self.lose(offset, Extent::Index, why),
            Ending::DataCrc { offset } => {
                let extent = if self.topics.any_unchecked() {
                    Extent::Unlocated
                } else {
                    Extent::Index
                };
                self.lose(
                    offset,
                    extent,
                    "the CRC of the data section does not match".into(),
                );
            }
            Ending::Broken { offset, why } => self.lose(offset, Extent::Rest, why),
            Ending::Cut { offset, tail } => {
                // What is whole of the chunk that the cut goes through.
                if tail.first() == Some(&op::CHUNK)
                    && let Some(body) = tail.get(records::PREFIX..)
                {
                    self.chunk(offset, body, false)?;
                }
                self.lose(
                    offset,
                    Extent::Rest,
                    "the file ends here, within its data".into(),
                );
            }
        }
        Ok(())
    }
}
