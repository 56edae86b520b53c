//! Messages as they stand in a file, not decoded: images, and what is copied from one log to another.

use std::collections::HashMap;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use mcap::records::{Record, op};

use super::chunk::{self, ChunkFault};
use super::damage::{Damage, Extent};
use super::records::{self, Ending, Records};
use super::request::Limits;
use crate::LogError;

/// What a channel's messages are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RawChannel {
    /// Its number in the file.
    pub id: u16,
    /// Topic name.
    pub topic: String,
    /// `cdr`, `ros1`, `json`, `protobuf` …
    pub encoding: String,
    /// Message type; empty where the channel has no schema.
    pub schema: String,
    /// `ros2msg`, `protobuf` …
    pub schema_encoding: String,
    /// The schema's text or descriptor.
    pub schema_data: Arc<[u8]>,
}

/// One message.
#[derive(Clone, Copy, Debug)]
pub struct RawMessage<'a> {
    /// Its channel.
    pub channel: &'a Arc<RawChannel>,
    /// When the recorder received it, in ns.
    pub log_time: u64,
    /// Its bytes.
    pub data: &'a [u8],
}

/// What was seen of a file.
#[derive(Clone, Debug, Default)]
pub struct RawSummary {
    /// Every channel of the file that has been defined, by its number.
    pub channels: Vec<Arc<RawChannel>>,
    /// SHA-256 of the whole file, in hex.
    pub sha256: String,
    /// Where the file is not whole.
    pub damage: Vec<Damage>,
}

/// Gives every message of a file, in its order. Memory is bounded by `limits`, whatever the file says of its sizes. What the
/// sink answers with an error ends the reading.
///
/// # Errors
/// A file that cannot be read or is no MCAP; a record, chunk or set of schemas beyond the limits.
pub fn read_raw<E: From<LogError>>(
    path: &Path,
    limits: Limits,
    sink: &mut dyn FnMut(RawMessage<'_>) -> Result<(), E>,
) -> Result<RawSummary, E> {
    let log = path.display().to_string();
    let file = File::open(path).map_err(|source| LogError::Io {
        log: log.clone(),
        source,
    })?;
    let mut records = Records::new(&log, file, limits.record)?;
    let mut state = State {
        log: &log,
        limits,
        schemas: HashMap::new(),
        channels: HashMap::new(),
        held: 0,
        damage: Vec::new(),
        stopped: None,
        sink,
    };
    let ending = records.each(&mut |offset, opcode, body| state.record(offset, opcode, body));
    if let Some(stopped) = state.stopped {
        return Err(stopped);
    }
    state.end(ending?)?;
    if let Some(stopped) = state.stopped {
        return Err(stopped);
    }
    let State {
        channels, damage, ..
    } = state;
    let mut channels: Vec<_> = channels.into_values().collect();
    channels.sort_by_key(|channel| channel.id);
    Ok(RawSummary {
        channels,
        damage,
        sha256: records.sha256()?,
    })
}

struct Schema {
    name: String,
    encoding: String,
    data: Arc<[u8]>,
}

struct State<'a, E> {
    log: &'a str,
    limits: Limits,
    schemas: HashMap<u16, Schema>,
    channels: HashMap<u16, Arc<RawChannel>>,
    /// Bytes that schemas and channels take.
    held: usize,
    damage: Vec<Damage>,
    stopped: Option<E>,
    sink: &'a mut dyn FnMut(RawMessage<'_>) -> Result<(), E>,
}

impl<E: From<LogError>> State<'_, E> {
    fn record(&mut self, offset: u64, opcode: u8, body: &[u8]) -> Result<(), LogError> {
        if opcode == op::CHUNK {
            return self.chunk(offset, body, true);
        }
        if let Err(why) = self.plain(opcode, body)? {
            self.lose(offset, Extent::Part, why);
        }
        Ok(())
    }

    fn chunk(&mut self, offset: u64, body: &[u8], whole: bool) -> Result<(), LogError> {
        let limits = self.limits;
        let mut wrong = None;
        let outcome = chunk::each(body, whole, &limits, &mut |opcode, body, _| {
            if let Err(why) = self.plain(opcode, body)? {
                wrong.get_or_insert(why);
            }
            Ok(())
        });
        match outcome {
            Ok(()) => {}
            Err(ChunkFault::Damaged(why)) => wrong = Some(why),
            Err(ChunkFault::Log(error)) => return Err(error),
            Err(ChunkFault::Compression(compression)) => {
                let log = self.log.into();
                return Err(LogError::Compression { log, compression });
            }
            Err(ChunkFault::TooLarge { size, limit }) => {
                return Err(self.too_large("chunk", offset, size, limit));
            }
        }
        if let (Some(why), true) = (wrong, whole) {
            self.lose(offset, Extent::Part, why);
        }
        Ok(())
    }

    /// A record that is no chunk; inside, what is wrong with it alone.
    fn plain(&mut self, opcode: u8, body: &[u8]) -> Result<Result<(), String>, LogError> {
        if self.stopped.is_some() || !matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
            return Ok(Ok(()));
        }
        match mcap::parse_record(opcode, body) {
            Ok(Record::Schema { header, data }) => {
                self.hold(header.name.len() + header.encoding.len() + data.len())?;
                let schema = Schema {
                    name: header.name,
                    encoding: header.encoding,
                    data: data.into(),
                };
                self.schemas.entry(header.id).or_insert(schema);
            }
            Ok(Record::Channel(channel)) => {
                self.hold(channel.topic.len() + channel.message_encoding.len())?;
                let schema = self.schemas.get(&channel.schema_id);
                let raw = RawChannel {
                    id: channel.id,
                    topic: channel.topic,
                    encoding: channel.message_encoding,
                    schema: schema.map_or_else(String::new, |schema| schema.name.clone()),
                    schema_encoding: schema
                        .map_or_else(String::new, |schema| schema.encoding.clone()),
                    schema_data: schema.map_or_else(|| Arc::from([]), |schema| schema.data.clone()),
                };
                self.channels
                    .entry(channel.id)
                    .or_insert_with(|| Arc::new(raw));
            }
            Ok(Record::Message { header, data }) => {
                let Some(channel) = self.channels.get(&header.channel_id) else {
                    let id = header.channel_id;
                    return Ok(Err(format!(
                        "a message belongs to channel {id}, which is not defined"
                    )));
                };
                let message = RawMessage {
                    channel,
                    log_time: header.log_time,
                    data: &data,
                };
                self.stopped = (self.sink)(message).err();
            }
            Ok(_) => {}
            Err(error) => return Ok(Err(format!("a record makes no sense: {error}"))),
        }
        Ok(Ok(()))
    }

    fn hold(&mut self, bytes: usize) -> Result<(), LogError> {
        self.held += bytes;
        if self.held <= self.limits.schemas {
            return Ok(());
        }
        let (size, limit) = (self.held as u64, self.limits.schemas as u64);
        Err(self.too_large("set of schemas and channels", 0, size, limit))
    }

    fn too_large(&self, what: &'static str, offset: u64, size: u64, limit: u64) -> LogError {
        LogError::TooLarge {
            log: self.log.into(),
            what,
            offset,
            size,
            limit,
        }
    }

    fn lose(&mut self, offset: u64, extent: Extent, why: String) {
        if extent != Extent::Part || self.damage.len() < self.limits.damage {
            self.damage.push(Damage {
                offset,
                extent,
                why,
            });
        }
    }

    fn end(&mut self, ending: Ending) -> Result<(), LogError> {
        match ending {
            Ending::Whole => {}
            Ending::Index { offset, why } => self.lose(offset, Extent::Index, why),
            Ending::DataCrc { offset } => {
                let why = "the CRC of the data section does not match".into();
                self.lose(offset, Extent::Unlocated, why);
            }
            Ending::Broken { offset, why } => self.lose(offset, Extent::Rest, why),
            Ending::Cut { offset, tail } => {
                if tail.first() == Some(&op::CHUNK)
                    && let Some(body) = tail.get(records::PREFIX..)
                {
                    self.chunk(offset, body, false)?;
                }
                let why = "the file ends here, within its data".into();
                self.lose(offset, Extent::Rest, why);
            }
        }
        Ok(())
    }
}
