//! Writes strikes as a ROS 2 bag would hold them: MCAP, CDR, `ros2msg` schemas, zstd chunks with CRCs.
//!
//! The same writer serves the embedded rig and the executor, so that whatever strikes, the next run can ingest it.
//! Nothing here reads a clock: every stamp is passed in, and the same samples give the same bytes.

mod copy;
mod form;
mod messages;

use std::fs::File;
use std::io::{BufWriter, Seek, Write};
use std::path::Path;
use std::sync::Arc;

use values::Topics;

use crate::read::{RawChannel, RawMessage};
use copy::create;
use form::{Form, Kind, Numbers};

#[cfg(feature = "sqlite")]
pub(crate) use messages::known_definition;

pub use copy::{CopyWriter, Lineage, WriteError, lineages};
pub use messages::{Samples, Stamped, StateSample};

/// A message that was received as it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Received {
    /// Its channel; channels are distinguished by their numbers.
    pub channel: Arc<RawChannel>,
    /// When it was received, in ns on the log's clock.
    pub log_time: u64,
    /// Its bytes.
    pub data: Vec<u8>,
}

/// Writes the samples of one strike after another into one log.
///
/// Topics and messages are those of the rig file: ROS 2's type that has the fields which the paths name (`geometry_msgs/msg/PointStamped`,
/// `PoseStamped`, `TwistStamped`, `Twist`, `nav_msgs/msg/Odometry` …), in CDR; JSON where no such type has them.
pub struct RecordingWriter<W: Write + Seek> {
    log: CopyWriter<W>,
    forms: [Form; 4],
    channels: [Option<u16>; 4],
    buffer: Vec<u8>,
}

impl RecordingWriter<BufWriter<File>> {
    /// Creates the file, replacing one that is there.
    pub fn create(path: &Path, topics: &Topics) -> Result<Self, WriteError> {
        Self::new(create(path)?, topics)
    }

    /// Creates a log without a topic of centroids: the object's place is in poses.
    pub fn create_without_centroids(path: &Path, topics: &Topics) -> Result<Self, WriteError> {
        Self::beside_received(create(path)?, topics)
    }
}

impl<W: Write + Seek> RecordingWriter<W> {
    /// Starts a log on anything that can be written to and sought in.
    pub fn new(sink: W, topics: &Topics) -> Result<Self, WriteError> {
        let mut writer = Self::start(sink, topics)?;
        // Both required topics exist even in a log without a strike; the optional one only where it is used.
        writer.channel(Kind::Centroid)?;
        writer.channel(Kind::Command)?;
        Ok(writer)
    }

    /// A writer of a log in which the object's place is in messages that are received: no topic of centroids is made for it.
    pub fn beside_received(sink: W, topics: &Topics) -> Result<Self, WriteError> {
        let mut writer = Self::start(sink, topics)?;
        writer.channel(Kind::Command)?;
        Ok(writer)
    }

    fn start(sink: W, topics: &Topics) -> Result<Self, WriteError> {
        Ok(Self {
            log: CopyWriter::new(sink)?,
            forms: Kind::ALL.map(|kind| Form::of(kind, topics)),
            channels: [None; 4],
            buffer: Vec::with_capacity(1024),
        })
    }

    /// Appends one strike's samples, merged in order of their stamps; `log_time` is the stamp.
    pub fn write(&mut self, samples: &Samples) -> Result<(), WriteError> {
        self.write_with(samples, &[])
    }

    /// Writes samples with poses in place of centroids: `yaws` (rad) is how the object is turned at each of them. Without yaws, centroids.
    pub fn write_turned(&mut self, samples: &Samples, yaws: &[f64]) -> Result<(), WriteError> {
        self.merge(samples, yaws, &[])
    }

    /// Writes samples, and messages that were received meanwhile (in order of time), each with its own channel and schema.
    pub fn write_with(
        &mut self,
        samples: &Samples,
        received: &[Received],
    ) -> Result<(), WriteError> {
        self.merge(samples, &[], received)
    }

    fn merge(
        &mut self,
        samples: &Samples,
        yaws: &[f64],
        received: &[Received],
    ) -> Result<(), WriteError> {
        let mut received = received.iter().peekable();
        let mut order: Vec<(u64, Kind, usize)> = Vec::new();
        order.extend(
            (0..samples.commands.len()).map(|i| (samples.commands[i].stamp, Kind::Command, i)),
        );
        order.extend((0..samples.states.len()).map(|i| (samples.states[i].stamp, Kind::State, i)));
        let place = |i| yaws.get(i).map_or(Kind::Centroid, |_| Kind::Pose);
        order.extend(
            (0..samples.centroids.len()).map(|i| (samples.centroids[i].stamp, place(i), i)),
        );
        order.sort_by_key(|&(stamp, _, _)| stamp);
        for (stamp, kind, i) in order {
            while let Some(message) = received.next_if(|message| message.log_time <= stamp) {
                self.put(message)?;
            }
            self.buffer.clear();
            let numbers = match kind {
                Kind::Centroid => Numbers::from(&samples.centroids[i]),
                Kind::Command => Numbers::from(&samples.commands[i]),
                Kind::State => Numbers::from(&samples.states[i]),
                Kind::Pose => Numbers::turned(&samples.centroids[i], yaws[i]),
            };
            self.forms[kind as usize].write(&mut self.buffer, &numbers);
            let channel = self.channel(kind)?;
            self.log.put(channel, stamp, &self.buffer)?;
        }
        received.try_for_each(|message| self.put(message))
    }

    fn put(&mut self, message: &Received) -> Result<(), WriteError> {
        self.log.copy(&RawMessage {
            channel: &message.channel,
            log_time: message.log_time,
            data: &message.data,
        })
    }

    /// States where the log comes from.
    pub fn lineage(&mut self, lineage: &Lineage) -> Result<(), WriteError> {
        self.log.lineage(lineage)
    }

    /// Writes the summary and hands the sink back; without it the log is truncated.
    pub fn finish(self) -> Result<W, WriteError> {
        self.log.finish()
    }

    fn channel(&mut self, kind: Kind) -> Result<u16, WriteError> {
        if let Some(id) = self.channels[kind as usize] {
            return Ok(id);
        }
        let form = &self.forms[kind as usize];
        let (name, encoding, text, messages) = form.schema();
        let id = self.log.add_channel(
            &form.topic,
            Some((name, encoding, text.as_bytes())),
            messages,
        )?;
        self.channels[kind as usize] = Some(id);
        Ok(id)
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

    use std::io::Cursor;

    use super::*;

    fn samples() -> Samples {
        let at = |stamp, x, y| Stamped { stamp, x, y };
        Samples {
            centroids: vec![
                at(1_700_000_000_500_000_000, 0.3, -0.1),
                at(1_700_000_001_000_000_001, 0.4, 0.2),
            ],
            commands: vec![at(1_700_000_000_250_000_000, 0.7, 0.1)],
            states: vec![StateSample {
                stamp: 1_700_000_000_750_000_000,
                position: [0.25, -0.125],
                velocity: [0.5, -0.5],
            }],
        }
    }

    fn bytes(samples: &Samples) -> Vec<u8> {
        let mut writer = RecordingWriter::new(Cursor::new(Vec::new()), &Topics::default()).unwrap();
        writer.write(samples).unwrap();
        writer.finish().unwrap().into_inner()
    }

    fn messages(log: &[u8]) -> Vec<mcap::Message<'_>> {
        let messages = mcap::MessageStream::new(log).unwrap();
        messages.map(Result::unwrap).collect()
    }

    fn double(data: &[u8], offset: usize) -> f64 {
        f64::from_le_bytes(data[offset..offset + 8].try_into().unwrap())
    }

    #[test]
    fn a_log_reads_back_in_order_with_its_schemas() {
        let log = bytes(&samples());
        let messages = messages(&log);
        let topics: Vec<_> = messages.iter().map(|m| m.channel.topic.as_str()).collect();
        assert_eq!(
            topics,
            [
                "/striker/command",
                "/object/centroid",
                "/striker/state",
                "/object/centroid"
            ]
        );
        let schema = messages[0].channel.schema.as_ref().unwrap();
        assert_eq!(schema.name, "geometry_msgs/msg/TwistStamped");
        assert_eq!(schema.encoding, "ros2msg");
        let text = std::str::from_utf8(&schema.data).unwrap();
        assert!(text.contains("MSG: geometry_msgs/Vector3"));
        assert!(messages.iter().all(|m| m.channel.message_encoding == "cdr"));
    }

    #[test]
    fn received_messages_stand_among_the_samples_as_they_came() {
        let channel = Arc::new(RawChannel {
            id: 7,
            topic: "/object/centroid".into(),
            encoding: "json".into(),
            schema: "Place".into(),
            schema_encoding: "jsonschema".into(),
            schema_data: Arc::from(&b"{}"[..]),
        });
        let received = [1, u64::MAX].map(|log_time| Received {
            channel: channel.clone(),
            log_time,
            data: b"{\"x\": 1}".to_vec(),
        });
        let samples = Samples {
            centroids: Vec::new(),
            ..samples()
        };
        let sink = Cursor::new(Vec::new());
        let mut writer = RecordingWriter::beside_received(sink, &Topics::default()).unwrap();
        writer.write_with(&samples, &received).unwrap();
        let log = writer.finish().unwrap().into_inner();
        let messages = messages(&log);
        let topics: Vec<_> = messages
            .iter()
            .map(|m| {
                (
                    m.channel.topic.as_str(),
                    m.channel.message_encoding.as_str(),
                    m.sequence,
                )
            })
            .collect();
        assert_eq!(
            topics,
            [
                ("/object/centroid", "json", 0),
                ("/striker/command", "cdr", 0),
                ("/striker/state", "cdr", 0),
                ("/object/centroid", "json", 1),
            ]
        );
        assert_eq!(*messages[0].data, b"{\"x\": 1}"[..]);
    }

    #[test]
    fn fields_stand_where_cdr_puts_them() {
        let log = bytes(&samples());
        let messages = messages(&log);
        // Encapsulation 4, stamp 8, length 4, "table\0" 6, padded to 8 from the encapsulation's end: 4 + 24.
        let point = &messages[3].data;
        assert_eq!(&point[..4], [0, 1, 0, 0]);
        assert_eq!(
            i32::from_le_bytes(point[4..8].try_into().unwrap()),
            1_700_000_001
        );
        assert_eq!(u32::from_le_bytes(point[8..12].try_into().unwrap()), 1);
        assert_eq!(&point[16..22], b"table\0");
        assert_eq!(
            [double(point, 28), double(point, 36), double(point, 44)],
            [0.4, 0.2, 0.0]
        );
        assert_eq!(point.len(), 52);
        assert_eq!(messages[0].data.len(), 4 + 24 + 48);
        let state = &messages[2].data;
        // Counted from the end: the covariance of the twist, then its two vectors.
        let last_twist = state.len() - 36 * 8 - 48;
        assert_eq!(
            [double(state, last_twist), double(state, last_twist + 8)],
            [0.5, -0.5]
        );
    }

    #[test]
    fn the_same_samples_give_the_same_bytes() {
        assert_eq!(bytes(&samples()), bytes(&samples()));
    }

    #[test]
    fn the_file_carries_a_summary_that_counts_the_messages() {
        let log = bytes(&samples());
        let summary = mcap::Summary::read(&log).unwrap().unwrap();
        assert_eq!(summary.stats.unwrap().message_count, 4);
        assert_eq!(summary.chunk_indexes.len(), 1);
    }
}
