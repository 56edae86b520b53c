//! A log that is made from another: its messages as they are, and others beside them.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{BufWriter, Seek, Write};
use std::path::Path;

use mcap::records::MessageHeader;
use mcap::{WriteOptions, Writer};

use super::lineage::{self, Lineage};
use super::messages::{
    POINT_STAMPED, POSE_STAMPED, RosType, image_schema, joined, jpeg_image, point_stamped,
    pose_stamped,
};
use super::{Stamped, WriteError, options};
use crate::read::RawMessage;

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
        let file = File::create(path).map_err(|source| WriteError::Create {
            path: path.display().to_string(),
            source,
        })?;
        Self::new(BufWriter::new(file))
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
                let schema = match from.schema() {
                    None => 0,
                    Some(text) => self.mcap.add_schema(text.name, text.encoding, text.data)?,
                };
                let encoding = &from.encoding;
                let channel =
                    self.mcap
                        .add_channel(schema, &from.topic, encoding, &BTreeMap::new())?;
                self.copied.insert(from.id, channel);
                channel
            }
        };
        self.put(channel, message.log_time, message.data)
    }

    /// States where a part of the log comes from.
    pub fn lineage(&mut self, lineage: &Lineage) -> Result<(), WriteError> {
        Ok(lineage::write(&mut self.mcap, lineage)?)
    }

    /// Adds a point of the table as `geometry_msgs/msg/PointStamped`, which the default paths of a centroid fit.
    pub fn point(&mut self, topic: &str, log_time: u64, point: &Stamped) -> Result<(), WriteError> {
        let schema = || of(POINT_STAMPED);
        let write = |buffer: &mut Vec<u8>| point_stamped(buffer, point);
        self.ros2(topic, schema, log_time, &write)
    }

    /// Makes the channel of points, so that a log without any has the topic.
    pub fn points(&mut self, topic: &str) -> Result<(), WriteError> {
        let (name, text) = of(POINT_STAMPED);
        self.channel(topic, (name, "ros2msg"), text.as_bytes(), "cdr")
            .map(drop)
    }

    /// Adds a JPEG that was taken at `stamp` (ns) as `sensor_msgs/msg/CompressedImage`.
    pub fn jpeg(
        &mut self,
        topic: &str,
        log_time: u64,
        stamp: u64,
        jpeg: &[u8],
    ) -> Result<(), WriteError> {
        let write = |buffer: &mut Vec<u8>| jpeg_image(buffer, stamp, jpeg);
        self.ros2(topic, image_schema, log_time, &write)
    }

    /// Adds an object's place on the table and its yaw (rad) as `geometry_msgs/msg/PoseStamped`.
    pub fn pose(
        &mut self,
        topic: &str,
        log_time: u64,
        at: &Stamped,
        yaw: f64,
    ) -> Result<(), WriteError> {
        let schema = || of(POSE_STAMPED);
        let write = |buffer: &mut Vec<u8>| pose_stamped(buffer, at, yaw);
        self.ros2(topic, schema, log_time, &write)
    }

    fn ros2(
        &mut self,
        topic: &str,
        schema: fn() -> (&'static str, String),
        log_time: u64,
        write: &dyn Fn(&mut Vec<u8>),
    ) -> Result<(), WriteError> {
        let (name, text) = schema();
        let channel = self.channel(topic, (name, "ros2msg"), text.as_bytes(), "cdr")?;
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
        schema: (&str, &str, &[u8]),
        encoding: &str,
        log_time: u64,
        data: &[u8],
    ) -> Result<(), WriteError> {
        let channel = self.channel(topic, (schema.0, schema.1), schema.2, encoding)?;
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
        (name, schema_encoding): (&str, &str),
        schema: &[u8],
        encoding: &str,
    ) -> Result<u16, WriteError> {
        if let Some(channel) = self.added.get(topic) {
            return Ok(*channel);
        }
        let schema = self.mcap.add_schema(name, schema_encoding, schema)?;
        let channel = self
            .mcap
            .add_channel(schema, topic, encoding, &BTreeMap::new())?;
        self.added.insert(topic.into(), channel);
        Ok(channel)
    }

    fn put(&mut self, channel_id: u16, log_time: u64, data: &[u8]) -> Result<(), WriteError> {
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
