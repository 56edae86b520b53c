//! The one reader of logs: every message as it stands, with its channel, and what is lost.
//!
//! What decodes messages ([`read()`](super::read())) and what copies them or looks for images ([`read_raw`]) are told alike what
//! is damaged: they [`Take`] the same messages.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Read, Seek};
use std::path::Path;
use std::sync::Arc;

use mcap::records::{Record, op};

use super::bag::{self, JoinedHash, Opened};
use super::body::Body;
use super::chunk::{self, ChunkFault};
use super::event::Limits;
use super::event::{Damage, Extent};
use super::records::{Ending, Records};
use crate::{LogError, SchemaText};

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

impl RawChannel {
    /// Its schema; none where it has none.
    pub fn schema(&self) -> Option<SchemaText<'_>> {
        let has_one = !(self.schema.is_empty() && self.schema_encoding.is_empty());
        has_one.then(|| SchemaText {
            name: &self.schema,
            encoding: &self.schema_encoding,
            data: &self.schema_data,
        })
    }
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

/// A channel of a file and how many messages it had.
#[derive(Clone, Debug)]
pub struct SeenChannel {
    /// The channel.
    pub channel: Arc<RawChannel>,
    /// Messages seen.
    pub messages: u64,
}

/// What was seen of a file.
#[derive(Clone, Debug, Default)]
pub struct RawSummary {
    /// Every channel of the file that has been defined, by its number.
    pub channels: Vec<SeenChannel>,
    /// SHA-256 of the whole file, in hex.
    pub sha256: String,
    /// Where the file is not whole.
    pub damage: Vec<Damage>,
}

impl RawSummary {
    /// Whether the file has this topic.
    pub fn has(&self, topic: &str) -> bool {
        self.channels.iter().any(|seen| seen.channel.topic == topic)
    }
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
    let mut each = Each {
        sink,
        largest: limits.record,
        unchecked: false,
    };
    take(path, limits, &mut each)
}

/// What is wrong with a message alone, or nothing.
pub(super) type Verdict = Result<(), String>;

/// Where a message stands in its file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Standing {
    /// Whether a CRC covers it.
    pub(super) is_checked: bool,
    /// Whether its channel names a schema that the file does not define.
    pub(super) lacks_schema: bool,
}

/// What takes the messages of a file.
pub(super) trait Take {
    /// What ends the reading.
    type Error: From<LogError>;

    fn message(
        &mut self,
        message: RawMessage<'_>,
        standing: Standing,
    ) -> Result<Verdict, Self::Error>;

    /// Is told that messages are lost here.
    fn lost(&mut self, _damage: &Damage) {}

    /// Whether any message that was used is covered by no CRC.
    fn any_unchecked(&self) -> bool;
}

struct Each<'a, E> {
    sink: &'a mut dyn FnMut(RawMessage<'_>) -> Result<(), E>,
    /// Bytes that a message unpacks to at the most.
    largest: usize,
    unchecked: bool,
}

impl<E: From<LogError>> Take for Each<'_, E> {
    type Error = E;

    fn message(&mut self, message: RawMessage<'_>, standing: Standing) -> Result<Verdict, E> {
        self.unchecked |= !standing.is_checked;
        match unpacked(&message, self.largest) {
            Ok(data) => (self.sink)(RawMessage {
                data: &data,
                ..message
            })
            .map(Ok),
            Err(why) => Ok(Err(format!(
                "a message of {}: {why}",
                message.channel.topic
            ))),
        }
    }

    fn any_unchecked(&self) -> bool {
        self.unchecked
    }
}

/// How zstd's frames begin.
const ZSTD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// A message's bytes, unpacked where rosbag2 packed it: no message of CDR begins so.
pub(super) fn unpacked<'a>(
    message: &RawMessage<'a>,
    largest: usize,
) -> Result<Cow<'a, [u8]>, String> {
    if message.channel.encoding != "cdr" || !message.data.starts_with(&ZSTD) {
        return Ok(Cow::Borrowed(message.data));
    }
    zstd::bulk::decompress(message.data, largest)
        .map(Cow::Owned)
        .map_err(|error| format!("it is packed by zstd, and cannot be unpacked: {error}"))
}

/// Gives every message of a log to what takes them.
pub(super) fn take<T: Take>(
    path: &Path,
    limits: Limits,
    taker: &mut T,
) -> Result<RawSummary, T::Error> {
    let files = bag::files(path)?;
    let mut reading = Reading::new(limits, taker);
    let mut joined = JoinedHash::default();
    let mut last = String::new();
    for file in &files {
        if path.is_dir() {
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            reading.part = Some(name.into_owned());
            if !std::fs::metadata(file).is_ok_and(|file| file.len() > 0) {
                let why = "it is listed in metadata.yaml, and is not there or empty".into();
                reading.lose(0, Extent::Part, why);
                if file.exists() {
                    joined.add(file, &bag::hash_file(file)?);
                }
                continue;
            }
        }
        reading.log = file.display().to_string();
        last = reading.file(file)?;
        joined.add(file, &last);
        reading.finish_file();
    }
    let sha256 = match path.is_dir() {
        true => joined.finish(),
        false => last,
    };
    Ok(reading.summary(sha256))
}

/// Takes the messages of any source; `log` is its name in errors.
pub(super) fn take_from<T: Take, R: Read + Seek>(
    log: &str,
    source: R,
    limits: Limits,
    taker: &mut T,
) -> Result<RawSummary, T::Error> {
    let mut reading = Reading::new(limits, taker);
    reading.log = log.into();
    let sha256 = reading.mcap(source)?;
    reading.finish_file();
    Ok(reading.summary(sha256))
}

/// A schema's name, encoding and text.
type Schema = (String, String, Arc<[u8]>);

struct Channel {
    raw: Arc<RawChannel>,
    schema: u16,
    messages: u64,
}

struct Reading<'a, T> {
    log: String,
    /// The file of a folder.
    part: Option<String>,
    limits: Limits,
    schemas: BTreeMap<u16, Schema>,
    channels: BTreeMap<u16, Channel>,
    /// Channels of the files before.
    seen: Vec<SeenChannel>,
    /// Bytes that schemas and channels take.
    held: usize,
    damage: Vec<Damage>,
    taker: &'a mut T,
}

impl<'a, T: Take> Reading<'a, T> {
    fn new(limits: Limits, taker: &'a mut T) -> Self {
        Self {
            log: String::new(),
            part: None,
            limits,
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            seen: Vec::new(),
            held: 0,
            damage: Vec::new(),
            taker,
        }
    }

    /// Reads a file; its SHA-256.
    fn file(&mut self, path: &Path) -> Result<String, T::Error> {
        match bag::open(path)? {
            Opened::Mcap(file) => {
                let sha256 = self.mcap(file)?;
                Ok(crate::part::origin(path).unwrap_or(sha256))
            }
            Opened::Sqlite(file) => {
                self.sqlite(&file)?;
                Ok(bag::hash_file(path)?)
            }
            Opened::Unpacked(unpacked, is_sqlite) => {
                if is_sqlite {
                    self.sqlite(unpacked.path())?;
                } else {
                    let file = unpacked.reopen();
                    self.mcap(file.map_err(|source| LogError::io(path.display(), source))?)?;
                }
                Ok(bag::hash_file(path)?)
            }
        }
    }

    fn mcap<R: Read + Seek>(&mut self, source: R) -> Result<String, T::Error> {
        let log = self.log.clone();
        let mut records = Records::new(&log, source, self.limits.record)?;
        let ending = records.each(&mut |offset, opcode, body| self.record(offset, opcode, body))?;
        // What is whole of the chunk that a cut goes through.
        if let Ending::Cut { offset } = ending
            && let Some((op::CHUNK, body)) = records.cut(offset)?
        {
            self.chunk(offset, body, false)?;
        }
        self.end(ending);
        Ok(records.sha256()?)
    }

    #[cfg(not(feature = "sqlite"))]
    fn sqlite(&mut self, _path: &Path) -> Result<(), T::Error> {
        let why = "this program reads MCAP alone; convert it with `ros2 bag convert`".into();
        let log = self.log.clone();
        Err(LogError::Sqlite { log, why }.into())
    }

    #[cfg(feature = "sqlite")]
    fn sqlite(&mut self, path: &Path) -> Result<(), T::Error> {
        let log = self.log.clone();
        let database = super::sqlite::Database::open(&log, path, self.limits)?;
        let topics = database.topics()?;
        let definitions = database.definitions(&topics)?;
        let mut ids: BTreeMap<i64, u16> = BTreeMap::new();
        for (topic, id) in topics.into_iter().zip(1..u16::MAX) {
            ids.insert(topic.id, id);
            let schema = definitions.get(&topic.kind);
            let (encoding, text) = schema.cloned().unwrap_or_default();
            let schema = (topic.kind, encoding, Arc::from(text.into_bytes()));
            let channel = mcap::records::Channel {
                id,
                schema_id: id,
                topic: topic.name,
                message_encoding: topic.encoding,
                metadata: BTreeMap::new(),
            };
            for verdict in [self.schema(id, schema)?, self.channel(channel)?] {
                if let Err(why) = verdict {
                    self.lose(0, Extent::Part, why);
                }
            }
        }
        let ended = database.messages(&mut |topic, log_time, data| -> Result<(), T::Error> {
            // What belongs to no topic belongs to channel 0, which is none.
            let channel = ids.get(&topic).copied().unwrap_or(0);
            if let Err(why) = self.message(channel, log_time, data, false)? {
                self.lose(0, Extent::Part, why);
            }
            Ok(())
        })?;
        if let Err(why) = ended {
            self.lose(0, Extent::Rest, why);
        }
        Ok(())
    }

    /// Ends a file: another has schemas and channels of its own, and the same topics.
    fn finish_file(&mut self) {
        self.schemas.clear();
        self.held = 0;
        for channel in std::mem::take(&mut self.channels).into_values() {
            let known = self
                .seen
                .iter_mut()
                .find(|seen| seen.channel.id == channel.raw.id);
            match known {
                Some(seen) => seen.messages += channel.messages,
                None => self.seen.push(SeenChannel {
                    channel: channel.raw,
                    messages: channel.messages,
                }),
            }
        }
    }

    fn summary(self, sha256: String) -> RawSummary {
        let (channels, damage) = (self.seen, self.damage);
        RawSummary {
            channels,
            sha256,
            damage,
        }
    }

    /// A channel with a number that no other channel of the files before has.
    fn numbered(&self, raw: RawChannel) -> Arc<RawChannel> {
        let with_id = |id| RawChannel { id, ..raw.clone() };
        let same = self
            .seen
            .iter()
            .find(|seen| *seen.channel == with_id(seen.channel.id));
        if let Some(same) = same {
            return Arc::clone(&same.channel);
        }
        let is_free = |id: &u16| {
            let here = self.channels.values().map(|channel| channel.raw.id);
            let before = self.seen.iter().map(|seen| seen.channel.id);
            here.chain(before).all(|known| known != *id)
        };
        let free = std::iter::once(raw.id).chain(1..=u16::MAX).find(is_free);
        Arc::new(with_id(free.unwrap_or(raw.id)))
    }

    fn record(&mut self, offset: u64, opcode: u8, body: Body<'_>) -> Result<(), T::Error> {
        let body = match body {
            Body::Held(body) if opcode != op::CHUNK => body,
            chunk => return self.chunk(offset, chunk, true),
        };
        if let Err(why) = self.plain(opcode, body, false)? {
            self.lose(offset, Extent::Part, why);
        }
        Ok(())
    }

    fn chunk(&mut self, offset: u64, mut body: Body<'_>, whole: bool) -> Result<(), T::Error> {
        let limits = self.limits;
        let mut wrong = None;
        let outcome = chunk::each(&mut body, whole, &limits, &mut |opcode, body, checked| {
            if let Err(why) = self.plain(opcode, body, checked)? {
                wrong.get_or_insert(why);
            }
            Ok(())
        });
        match outcome {
            Ok(()) => {}
            Err(ChunkFault::Damaged(why)) => wrong = Some(why),
            Err(ChunkFault::Ended(error)) => return Err(error),
            Err(ChunkFault::Io(source)) => {
                return Err(LogError::io(&self.log, source).into());
            }
            Err(ChunkFault::Compression(compression)) => {
                let log = self.log.clone();
                return Err(LogError::Compression { log, compression }.into());
            }
            Err(ChunkFault::TooLarge { size, limit }) => {
                return Err(self.too_large("chunk", offset, size, limit).into());
            }
        }
        if let (Some(why), true) = (wrong, whole) {
            self.lose(offset, Extent::Part, why);
        }
        Ok(())
    }

    /// A record that is no chunk; `checked` where a CRC covers it.
    fn plain(&mut self, opcode: u8, body: &[u8], checked: bool) -> Result<Verdict, T::Error> {
        match opcode {
            op::SCHEMA | op::CHANNEL | op::MESSAGE => {}
            0x01..=op::DATA_END | 0x80.. => return Ok(Ok(())),
            _ => {
                return Ok(Err(format!(
                    "there is a record of the unknown kind {opcode:#04x}"
                )));
            }
        }
        Ok(match mcap::parse_record(opcode, body) {
            Ok(Record::Schema { header, data }) => {
                self.schema(header.id, (header.name, header.encoding, data.into()))?
            }
            Ok(Record::Channel(channel)) => self.channel(channel)?,
            Ok(Record::Message { header, data }) => {
                self.message(header.channel_id, header.log_time, &data, checked)?
            }
            Ok(_) => Ok(()),
            Err(error) => Err(format!("a record makes no sense: {error}")),
        })
    }

    fn message(
        &mut self,
        id: u16,
        log_time: u64,
        data: &[u8],
        is_checked: bool,
    ) -> Result<Verdict, T::Error> {
        let Some(channel) = self.channels.get_mut(&id) else {
            return Ok(Err(format!(
                "a message belongs to channel {id}, which is not defined"
            )));
        };
        channel.messages += 1;
        let message = RawMessage {
            channel: &channel.raw,
            log_time,
            data,
        };
        let standing = Standing {
            is_checked,
            lacks_schema: channel.schema != 0 && !self.schemas.contains_key(&channel.schema),
        };
        self.taker.message(message, standing)
    }

    fn schema(&mut self, id: u16, schema: Schema) -> Result<Verdict, LogError> {
        if let Some(known) = self.schemas.get(&id) {
            let why = || format!("schema {id} is defined twice, and not alike");
            return Ok((*known == schema).then_some(()).ok_or_else(why));
        }
        self.hold(schema.0.len() + schema.1.len() + schema.2.len())?;
        // A channel that was defined before its schema.
        for channel in self.channels.values_mut() {
            if channel.schema == id {
                channel.raw = Arc::new(with_schema((*channel.raw).clone(), &schema));
            }
        }
        self.schemas.insert(id, schema);
        Ok(Ok(()))
    }

    fn channel(&mut self, channel: mcap::records::Channel) -> Result<Verdict, LogError> {
        let id = channel.id;
        if let Some(known) = self.channels.get(&id) {
            let same = (&known.raw.topic, &known.raw.encoding, known.schema)
                == (&channel.topic, &channel.message_encoding, channel.schema_id);
            let why = || format!("channel {id} is defined twice, and not alike");
            return Ok(same.then_some(()).ok_or_else(why));
        }
        self.hold(channel.topic.len() + channel.message_encoding.len())?;
        let mut raw = RawChannel {
            id,
            topic: channel.topic,
            encoding: channel.message_encoding,
            schema: String::new(),
            schema_encoding: String::new(),
            schema_data: Arc::from([]),
        };
        if let Some(schema) = self.schemas.get(&channel.schema_id) {
            raw = with_schema(raw, schema);
        }
        let channel = Channel {
            raw: self.numbered(raw),
            schema: channel.schema_id,
            messages: 0,
        };
        self.channels.insert(id, channel);
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
            log: self.log.clone(),
            what,
            offset,
            size,
            limit,
        }
    }

    fn lose(&mut self, offset: u64, extent: Extent, why: String) {
        let why = match &self.part {
            Some(part) => format!("in {part}: {why}"),
            None => why,
        };
        let damage = Damage {
            offset,
            extent,
            why,
        };
        if extent != Extent::Index {
            self.taker.lost(&damage);
        }
        // A file made of damage must not fill the memory with it.
        if extent != Extent::Part || self.damage.len() < self.limits.damage {
            self.damage.push(damage);
        }
    }

    /// What the end of the file says of the whole.
    fn end(&mut self, ending: Ending) {
        match ending {
            Ending::Whole => {}
            Ending::Index { offset, why } => self.lose(offset, Extent::Index, why),
            Ending::DataCrc { offset } => {
                let extent = match self.taker.any_unchecked() {
                    true => Extent::Unlocated,
                    false => Extent::Index,
                };
                let why = "the CRC of the data section does not match".into();
                self.lose(offset, extent, why);
            }
            Ending::Broken { offset, why } => self.lose(offset, Extent::Rest, why),
            Ending::Cut { offset } => {
                let why = "the file ends here, within its data".into();
                self.lose(offset, Extent::Rest, why);
            }
        }
    }
}

fn with_schema(mut raw: RawChannel, (name, encoding, data): &Schema) -> RawChannel {
    raw.schema.clone_from(name);
    raw.schema_encoding.clone_from(encoding);
    raw.schema_data = Arc::clone(data);
    raw
}
