//! A log that is made from another: its messages as they are, and others beside them.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{BufWriter, Seek, Write};
use std::path::Path;

use mcap::records::{MessageHeader, Metadata, Record};
use mcap::{WriteOptions, Writer};

use super::messages::{
    POINT_STAMPED, POSE_STAMPED, RosType, Stamped, image_schema, joined, jpeg_image, point_stamped,
    pose_stamped,
};
use crate::LogError;
use crate::read::RawMessage;

/// How every log is written. One compression thread, whatever the machine: zstd's bytes depend on whether it has workers.
fn options() -> WriteOptions {
    WriteOptions::new()
        .profile("ros2")
        .library("carom")
        .compression(Some(mcap::Compression::Zstd))
        .compression_level(1)
        .compression_threads(0)
}

/// Why a log could not be written.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum WriteError {
    #[error("create log {path}: {source}; check that its folder exists and can be written to")]
    Create {
        path: String,
        source: std::io::Error,
    },
    #[error("write to the log: {0}; check the space left on its disk")]
    Mcap(#[from] mcap::McapError),
    #[error("flush the log: {0}; check the space left on its disk")]
    Flush(#[from] std::io::Error),
}

pub(super) fn create(path: &Path) -> Result<BufWriter<File>, WriteError> {
    let file = File::create(path).map_err(|source| WriteError::Create {
        path: path.display().to_string(),
        source,
    })?;
    Ok(BufWriter::new(file))
}

/// A schema's name, encoding and bytes.
type Schema<'a> = (&'a str, &'a str, &'a [u8]);

/// Writes messages of any topics into one log, in the order in which they are given.
///
/// Nothing here reads a clock; the same messages give the same bytes.
pub struct CopyWriter<W: Write + Seek> {
    mcap: Writer<W>,
    /// Channels by the number that they have in the log they come from.
    copied: HashMap<u16, u16>,
    /// Channels of what is added, by topic.
    added: HashMap<String, u16>,
    sequences: HashMap<u16, u32>,
    buffer: Vec<u8>,
}

impl CopyWriter<BufWriter<File>> {
    /// Creates the file, replacing one that is there.
    pub fn create(path: &Path) -> Result<Self, WriteError> {
        Self::new(create(path)?)
    }
}

impl<W: Write + Seek> CopyWriter<W> {
    /// Starts a log on anything that can be written to and sought in.
    pub fn new(sink: W) -> Result<Self, WriteError> {
        Self::with(options(), sink)
    }

    /// A writer of messages that are not ROS 2's.
    pub fn without_profile(sink: W) -> Result<Self, WriteError> {
        Self::with(options().profile(""), sink)
    }

    fn with(options: WriteOptions, sink: W) -> Result<Self, WriteError> {
        let mcap = options.create(sink)?;
        Ok(Self {
            mcap,
            copied: HashMap::new(),
            added: HashMap::new(),
            sequences: HashMap::new(),
            buffer: Vec::new(),
        })
    }

    /// Messages that follow come from another log, whose channels have numbers of their own.
    pub fn next_log(&mut self) {
        self.copied.clear();
    }

    /// Copies a message of another log, with its channel and schema.
    pub fn copy(&mut self, message: &RawMessage<'_>) -> Result<(), WriteError> {
        let from = message.channel;
        let channel = match self.copied.get(&from.id) {
            Some(channel) => *channel,
            None => {
                let schema = from
                    .schema()
                    .map(|text| (text.name, text.encoding, text.data));
                let channel = self.add_channel(&from.topic, schema, &from.encoding)?;
                self.copied.insert(from.id, channel);
                channel
            }
        };
        self.put(channel, message.log_time, message.data)
    }

    /// States where a part of the log comes from.
    pub fn lineage(&mut self, lineage: &Lineage) -> Result<(), WriteError> {
        let metadata = Metadata {
            name: NAME.into(),
            metadata: lineage.clone(),
        };
        Ok(self.mcap.write_metadata(&metadata)?)
    }

    /// Adds a point of the table as `geometry_msgs/msg/PointStamped`, which the default paths of a centroid fit.
    pub fn point(&mut self, topic: &str, log_time: u64, point: &Stamped) -> Result<(), WriteError> {
        self.ros2(topic, of(POINT_STAMPED), log_time, |buffer| {
            point_stamped(buffer, point)
        })
    }

    /// Makes the channel of points, so that a log without any has the topic.
    pub fn points(&mut self, topic: &str) -> Result<(), WriteError> {
        let (name, text) = of(POINT_STAMPED);
        let schema = (name, "ros2msg", text.as_bytes());
        self.channel(topic, schema, "cdr").map(drop)
    }

    /// Adds a JPEG that was taken at `stamp` (ns) as `sensor_msgs/msg/CompressedImage`.
    pub fn jpeg(
        &mut self,
        topic: &str,
        log_time: u64,
        stamp: u64,
        jpeg: &[u8],
    ) -> Result<(), WriteError> {
        self.ros2(topic, image_schema(), log_time, |buffer| {
            jpeg_image(buffer, stamp, jpeg)
        })
    }

    /// Adds an object's place on the table and its yaw (rad) as `geometry_msgs/msg/PoseStamped`.
    pub fn pose(
        &mut self,
        topic: &str,
        log_time: u64,
        at: &Stamped,
        yaw: f64,
    ) -> Result<(), WriteError> {
        self.ros2(topic, of(POSE_STAMPED), log_time, |buffer| {
            pose_stamped(buffer, at, yaw)
        })
    }

    fn ros2(
        &mut self,
        topic: &str,
        (name, text): (&'static str, String),
        log_time: u64,
        write: impl Fn(&mut Vec<u8>),
    ) -> Result<(), WriteError> {
        let channel = self.channel(topic, (name, "ros2msg", text.as_bytes()), "cdr")?;
        let mut buffer = std::mem::take(&mut self.buffer);
        buffer.clear();
        write(&mut buffer);
        let put = self.put(channel, log_time, &buffer);
        self.buffer = buffer;
        put
    }

    /// Adds a message of any type: its schema by name, encoding and bytes, and its encoding.
    pub fn add(
        &mut self,
        topic: &str,
        schema: Schema<'_>,
        encoding: &str,
        log_time: u64,
        data: &[u8],
    ) -> Result<(), WriteError> {
        let channel = self.channel(topic, schema, encoding)?;
        self.put(channel, log_time, data)
    }

    /// Ends the file and gives back what it was written to.
    pub fn finish(mut self) -> Result<W, WriteError> {
        self.mcap.finish()?;
        let mut sink = self.mcap.into_inner();
        sink.flush()?;
        Ok(sink)
    }

    fn channel(
        &mut self,
        topic: &str,
        schema: Schema<'_>,
        encoding: &str,
    ) -> Result<u16, WriteError> {
        if let Some(channel) = self.added.get(topic) {
            return Ok(*channel);
        }
        let channel = self.add_channel(topic, Some(schema), encoding)?;
        self.added.insert(topic.into(), channel);
        Ok(channel)
    }

    pub(super) fn add_channel(
        &mut self,
        topic: &str,
        schema: Option<Schema<'_>>,
        encoding: &str,
    ) -> Result<u16, WriteError> {
        let schema = match schema {
            None => 0,
            Some((name, encoding, data)) => self.mcap.add_schema(name, encoding, data)?,
        };
        let none = BTreeMap::new();
        Ok(self.mcap.add_channel(schema, topic, encoding, &none)?)
    }

    pub(super) fn put(
        &mut self,
        channel_id: u16,
        log_time: u64,
        data: &[u8],
    ) -> Result<(), WriteError> {
        let sequence = self.sequences.entry(channel_id).or_insert(0);
        let header = MessageHeader {
            channel_id,
            sequence: *sequence,
            log_time,
            publish_time: log_time,
        };
        *sequence += 1;
        Ok(self.mcap.write_to_known_channel(&header, data)?)
    }
}

/// A type's name and its definition.
fn of(ros: &'static RosType) -> (&'static str, String) {
    (ros.name, joined(ros.definition, ros.parts))
}

const NAME: &str = "carom";

/// What made a log: names and values as text, such as `version`, `manifest` (its hash), `model`, `target`, `plan` and `promised_miss` of a
/// planned strike. Which names there are is up to the program that writes.
pub type Lineage = BTreeMap<String, String>;

/// The lineages that a log states, in its order; none of one that no carom program wrote.
///
/// # Errors
/// A file that cannot be read, or is no MCAP.
pub fn lineages(log: &Path) -> Result<Vec<Lineage>, LogError> {
    let name = log.display().to_string();
    let bytes = std::fs::read(log).map_err(|source| LogError::io(&name, source))?;
    let records = mcap::read::LinearReader::new(&bytes);
    let mut found = Vec::new();
    for record in records.map_err(|_| LogError::NotMcap { log: name })? {
        match record {
            Ok(Record::Metadata(metadata)) if metadata.name == NAME => {
                found.push(metadata.metadata);
            }
            Ok(_) => {}
            // Cut off or damaged: what came before counts.
            Err(_) => break,
        }
    }
    Ok(found)
}
