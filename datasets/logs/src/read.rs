//! From a file to samples: every message of the wanted topics, in the order in which the recorder received them.
//!
//! The file is streamed: at most one record, one unpacked chunk and the schemas are in memory. A chunk with a CRC is
//! checked before any of its messages is given; in a file that is cut off, what is whole of the last chunk is given too.

mod chunk;
mod damage;
mod event;
mod raw;
mod records;
mod request;
mod summary;
mod topics;

use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;

use mcap::records::op;

use self::chunk::ChunkFault;
use self::records::{Ending, Records};
use self::topics::Topics;
use crate::LogError;

pub use self::damage::{Damage, Extent};
pub use self::event::{Event, Sample};
pub use self::raw::{RawChannel, RawMessage, RawSummary, read_raw};
pub use self::request::{Limits, TopicRequest};
pub use self::summary::{Summary, TopicCount};

/// Reads the wanted topics of a log file.
pub fn read(
    path: &Path,
    wanted: &[TopicRequest<'_>],
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
    wanted: &[TopicRequest<'_>],
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
