//! Bags as ROS 2's own recorder lays them out: what rosbag2's MCAP storage puts into a file beside the messages, and the
//! schema texts that it takes from the installed packages, comments and all.
//! Source: ros2/rosbag2, `rosbag2_storage_mcap` (its presets and metadata) and `rosbag2_cpp` (`get_full_text`).

mod definitions;

use std::collections::BTreeMap;
use std::io::Cursor;

use logs::{LogError, Sample, Summary, TopicRequest};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, WriteOptions};
use values::FieldTopic;

use crate::common::{read_topics, topic_of as topic};
use definitions::{ODOMETRY, POINT_STAMPED, TRACKED, TWIST_STAMPED, full_text};

const STAMP: i64 = 1_700_000_000_123_456_789;

/// rosbag2's storage presets, as they stand in its README.
fn presets() -> [(&'static str, WriteOptions); 4] {
    let plain = || {
        WriteOptions::new()
            .profile("ros2")
            .library("libmcap 1.4.0")
            .compression(None)
            .calculate_data_section_crc(false)
    };
    let zstd = || plain().compression(Some(Compression::Zstd));
    [
        ("none", plain().calculate_chunk_crcs(true)),
        (
            "fastwrite",
            plain()
                .use_chunks(false)
                .emit_summary_records(false)
                .calculate_summary_section_crc(false),
        ),
        (
            "zstd_fast",
            zstd().compression_level(1).calculate_chunk_crcs(false),
        ),
        (
            "zstd_small",
            zstd()
                .compression_level(19)
                .chunk_size(Some(4 << 20))
                .calculate_chunk_crcs(true),
        ),
    ]
}

struct Cdr(Vec<u8>);

impl Cdr {
    fn new() -> Self {
        Self(vec![0, 1, 0, 0])
    }

    fn put<const N: usize>(mut self, bytes: [u8; N]) -> Self {
        self.0.resize(4 + (self.0.len() - 4).next_multiple_of(N), 0);
        self.0.extend(bytes);
        self
    }

    fn text(self, text: &str) -> Self {
        let mut cdr = self.put(u32::try_from(text.len() + 1).unwrap().to_le_bytes());
        cdr.0.extend(text.bytes().chain([0]));
        cdr
    }

    fn header(self) -> Self {
        let (seconds, nanoseconds) = (STAMP / 1_000_000_000, STAMP % 1_000_000_000);
        self.put(i32::try_from(seconds).unwrap().to_le_bytes())
            .put(u32::try_from(nanoseconds).unwrap().to_le_bytes())
            .text("table")
    }

    fn floats(self, values: impl IntoIterator<Item = f64>) -> Self {
        values
            .into_iter()
            .fold(self, |cdr, value| cdr.put(value.to_le_bytes()))
    }
}

fn tracked() -> Cdr {
    let pixel = |cdr: Cdr, row: u16, column: u8| cdr.put(row.to_le_bytes()).put([column]);
    let cdr = Cdr::new()
        .put(3_u32.to_le_bytes())
        .put([1])
        .put([2])
        .put([3]);
    let cdr = cdr
        .text("cup")
        .put(2_u32.to_le_bytes())
        .text("")
        .text("mug")
        .text("a")
        .text("bc")
        .put([1]);
    let cdr = pixel(pixel(cdr.put(1_u32.to_le_bytes()), 7, 8), 9, 10);
    let cdr = pixel(cdr, 11, 12)
        .header()
        .put(0.25_f32.to_le_bytes())
        .put((-0.5_f64).to_le_bytes());
    // Behind what is wanted: not read, and no matter how a middleware writes it.
    cdr.put([0xFF; 4])
}

/// A message type: its name, its definition's encoding and the definition.
type Type<'a> = (&'a str, &'a str, String);

fn bag(options: WriteOptions, channels: &[(&str, Type<'_>, &[u8])]) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut writer = options.create(&mut file).unwrap();
    let rosbag2 = |messages: usize| {
        let text = format!("version: 8\nstorage_identifier: mcap\nmessage_count: {messages}\n");
        Metadata {
            name: "rosbag2".into(),
            metadata: [("serialized_metadata".into(), text)].into(),
        }
    };
    writer.write_metadata(&rosbag2(0)).unwrap();
    let qos = "- history: 1\n  depth: 10\n  reliability: 1\n  durability: 2\n  deadline:\n    sec: 9223372036\n    nsec: 854775807\n";
    let metadata: BTreeMap<String, String> = [
        ("offered_qos_profiles".into(), qos.into()),
        (
            "topic_type_hash".into(),
            format!("RIHS01_{}", "7".repeat(64)),
        ),
    ]
    .into();
    let channels: Vec<_> = channels
        .iter()
        .map(|(topic, (name, encoding, text), message)| {
            let schema = writer.add_schema(name, encoding, text.as_bytes()).unwrap();
            (
                writer.add_channel(schema, topic, "cdr", &metadata).unwrap(),
                message,
            )
        })
        .collect();
    for (sequence, (channel_id, message)) in (0..).zip(channels) {
        // A topic that nobody published on still has its channel.
        if !message.is_empty() {
            let log_time = u64::try_from(STAMP).unwrap() + 1000;
            let header = MessageHeader {
                channel_id,
                sequence,
                log_time,
                publish_time: log_time,
            };
            writer.write_to_known_channel(&header, message).unwrap();
        }
    }
    writer.write_metadata(&rosbag2(4)).unwrap();
    writer.finish().unwrap();
    drop(writer);
    file.into_inner()
}

fn read(file: &[u8], topics: &[FieldTopic]) -> Result<(Vec<(usize, Sample)>, Summary), LogError> {
    let wanted: Vec<_> = topics.iter().map(TopicRequest::required).collect();
    read_topics(file, &wanted)
}

#[test]
fn a_recording_in_every_storage_preset_is_read() {
    let covariance = || std::iter::repeat_n(0.125, 36);
    let pose = Cdr::new().header().text("tip");
    let pose = pose.floats([0.3, -0.1, 0.0, 0.0, 0.0, 0.0, 1.0]);
    let twist = pose
        .floats(covariance())
        .floats([0.7, 0.2, 0.0, 0.0, 0.0, 0.0]);
    let odometry = twist.floats(covariance()).0;
    let point = Cdr::new().header().floats([0.45, -0.02, 0.0]).0;
    let twist = Cdr::new().header().floats([0.8, 0.1, 0.0, 0.0, 0.0, 0.0]).0;
    let tracked = tracked().0;
    let ros2 = |name, own| (name, "ros2msg", full_text(own));
    let channels = [
        (
            "/parameter_events",
            ros2(
                "rcl_interfaces/msg/ParameterEvent",
                "builtin_interfaces/Time stamp\nstring node\n",
            ),
            &[][..],
        ),
        (
            "/object/centroid",
            ros2("geometry_msgs/msg/PointStamped", POINT_STAMPED),
            &point,
        ),
        (
            "/heartbeat",
            ros2("test_msgs/msg/Empty", ""),
            &[0, 1, 0, 0, 0],
        ),
        (
            "/striker/command",
            ros2("geometry_msgs/msg/TwistStamped", TWIST_STAMPED),
            &twist,
        ),
        (
            "/striker/state",
            ros2("nav_msgs/msg/Odometry", ODOMETRY),
            &odometry,
        ),
        ("/tracked", ros2("demo_msgs/msg/Tracked", TRACKED), &tracked),
    ];
    let topics = [
        topic("/object/centroid", "point.x", "point.y"),
        topic("/striker/command", "twist.linear.x", "twist.linear.y"),
        topic(
            "/striker/state",
            "twist.twist.linear.x",
            "pose.pose.position.y",
        ),
        topic("/tracked", "u", "v"),
    ];
    for (preset, options) in presets() {
        let (samples, summary) = read(&bag(options, &channels), &topics).unwrap();
        let sample = |x, y| Sample { stamp: STAMP, x, y };
        let expected = [
            (0, sample(0.45, -0.02)),
            (1, sample(0.8, 0.1)),
            (2, sample(0.7, -0.1)),
            (3, sample(0.25, -0.5)),
        ];
        assert_eq!(samples, expected, "{preset}");
        assert_eq!(
            (summary.damage, summary.messages),
            (Vec::new(), 5),
            "{preset}"
        );
        assert_eq!(summary.topics.len(), 6, "{preset}");
    }
}

#[test]
fn a_topic_without_messages_is_there() {
    let point = (
        "geometry_msgs/msg/PointStamped",
        "ros2msg",
        full_text(POINT_STAMPED),
    );
    let file = bag(WriteOptions::new(), &[("/object/centroid", point, &[])]);
    let (samples, summary) =
        read(&file, &[topic("/object/centroid", "point.x", "point.y")]).unwrap();
    assert_eq!((samples, summary.messages), (Vec::new(), 0));
}

/// The error of a log whose only topic has this definition.
fn refusal(definition: Type<'_>) -> String {
    let message = Cdr::new().header().floats([0.45, -0.02, 0.0]).0;
    let file = bag(WriteOptions::new(), &[("/p", definition, &message)]);
    read(&file, &[topic("/p", "point.x", "point.y")])
        .expect_err("refused")
        .to_string()
}

#[test]
fn definitions_that_cannot_be_used_are_distinguished() {
    let idl = "================================================================================\nIDL: demo_msgs/msg/P\n\
               module demo_msgs { module msg { struct P { double x; }; }; };\n";
    let service = "================================================================================\nSRV: demo_msgs/srv/Ask\n\
                   int64 a\n---\nint64 sum\n";
    let missing = full_text("std_msgs/Header header\nMissing point\n");
    let (own, asked) = ("demo_msgs/msg/P", "demo_msgs/srv/Ask_Event");
    let not_installed = "where the message's package is installed";
    for (name, encoding, text, expected) in [
        (own, "ros2idl", idl, "record with a ros2msg schema"),
        (own, "unknown", "", not_installed),
        (own, "ros2msg", "", not_installed),
        (asked, "ros2msg", service, "defines a service"),
        (
            own,
            "ros2msg",
            &missing,
            "uses Missing, which is not defined",
        ),
    ] {
        let definition = (name, encoding, text.into());
        let text = refusal(definition);
        assert!(text.contains(expected) && text.contains("/p"), "{text}");
    }
}

#[test]
fn a_stream_that_was_compressed_as_a_whole_is_reported_as_such() {
    let zstd = b"\x28\xb5\x2f\xfd\x04\x00\x41\x00\x00";
    let text = read(zstd, &[]).expect_err("refused").to_string();
    assert!(text.contains("no MCAP"), "{text}");
}
