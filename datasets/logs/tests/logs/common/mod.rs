//! Logs as other programs write them: by mcap's writer, in every encoding.

use std::collections::BTreeMap;
use std::io::Cursor;

use logs::{Event, Limits, LogError, Sample, Summary, TopicRequest};
use mcap::records::MessageHeader;
use mcap::{WriteOptions, Writer};
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};
use values::FieldTopic;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Encoding {
    Cdr,
    CdrBigEndian,
    Json,
    Protobuf,
}

pub const ENCODINGS: [Encoding; 4] = [
    Encoding::Cdr,
    Encoding::CdrBigEndian,
    Encoding::Json,
    Encoding::Protobuf,
];

const POINT_STAMPED: &str = "# A point.\nstd_msgs/Header header\nPoint point\n\
    ================================================================================\n\
    MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
    ================================================================================\n\
    MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n";

pub fn topic(name: &str) -> FieldTopic {
    topic_of(name, "point.x", "point.y")
}

pub fn topic_of(name: &str, x: &str, y: &str) -> FieldTopic {
    FieldTopic {
        name: name.into(),
        stamp: "header.stamp".into(),
        x: x.into(),
        y: y.into(),
    }
}

impl Encoding {
    /// Schema name, schema encoding, message encoding and schema data.
    pub fn schema(self) -> (&'static str, &'static str, &'static str, Vec<u8>) {
        match self {
            Self::Cdr | Self::CdrBigEndian => (
                "geometry_msgs/msg/PointStamped",
                "ros2msg",
                "cdr",
                POINT_STAMPED.into(),
            ),
            Self::Json => ("PointStamped", "jsonschema", "json", b"{}".to_vec()),
            Self::Protobuf => (
                "demo.PointStamped",
                "protobuf",
                "protobuf",
                descriptor_set(),
            ),
        }
    }

    pub fn message(self, sample: &Sample) -> Vec<u8> {
        let (sec, nanosec) = (
            sample.stamp.div_euclid(1_000_000_000),
            sample.stamp.rem_euclid(1_000_000_000),
        );
        match self {
            Self::Cdr | Self::CdrBigEndian => {
                let is_little = self == Self::Cdr;
                let mut data = vec![0, is_little.into(), 0, 0];
                let ordered = |mut little: Vec<u8>| {
                    if !is_little {
                        little.reverse();
                    }
                    little
                };
                for word in [sec as u32, nanosec as u32, 6] {
                    data.extend(ordered(word.to_le_bytes().to_vec()));
                }
                data.extend(b"table\0\0\0\0\0\0\0");
                for number in [sample.x, sample.y, 0.0] {
                    data.extend(ordered(number.to_le_bytes().to_vec()));
                }
                data
            }
            Self::Json => format!(
                r#"{{"header":{{"frame_id":"table","stamp":{{"sec":{sec},"nanosec":{nanosec}}}}},"point":{{"x":{:?},"y":{:?}}}}}"#,
                sample.x, sample.y
            )
            .into_bytes(),
            Self::Protobuf => {
                let mut stamp = Vec::new();
                prost::encoding::int64::encode(1, &sec, &mut stamp);
                prost::encoding::int32::encode(2, &(nanosec as i32), &mut stamp);
                let mut header = Vec::new();
                prost::encoding::string::encode(1, &"table".into(), &mut header);
                prost::encoding::bytes::encode(2, &stamp, &mut header);
                let mut point = Vec::new();
                for (tag, value) in [(1, sample.x), (2, sample.y)] {
                    // As every writer does: zero is left out.
                    if value.to_bits() != 0 {
                        prost::encoding::double::encode(tag, &value, &mut point);
                    }
                }
                let mut message = Vec::new();
                prost::encoding::bytes::encode(1, &header, &mut message);
                prost::encoding::bytes::encode(7, &point, &mut message);
                message
            }
        }
    }
}

fn field(name: &str, number: i32, kind: Type, of: Option<&str>) -> FieldDescriptorProto {
    FieldDescriptorProto {
        name: Some(name.into()),
        number: Some(number),
        label: Some(Label::Optional.into()),
        r#type: Some(kind.into()),
        type_name: of.map(String::from),
        ..Default::default()
    }
}

fn message(name: &str, field: Vec<FieldDescriptorProto>) -> DescriptorProto {
    DescriptorProto {
        name: Some(name.into()),
        field,
        ..Default::default()
    }
}

/// What protoc puts out for a stamped point that uses `google.protobuf.Timestamp`.
fn descriptor_set() -> Vec<u8> {
    let file = |name: &str, package: &str, dependency: &[&str], message_type| FileDescriptorProto {
        name: Some(name.into()),
        package: Some(package.into()),
        dependency: dependency.iter().map(|name| (*name).into()).collect(),
        message_type,
        syntax: Some("proto3".into()),
        ..Default::default()
    };
    let timestamp = message(
        "Timestamp",
        vec![
            field("seconds", 1, Type::Int64, None),
            field("nanos", 2, Type::Int32, None),
        ],
    );
    let header = message(
        "Header",
        vec![
            field("frame_id", 1, Type::String, None),
            field(
                "stamp",
                2,
                Type::Message,
                Some(".google.protobuf.Timestamp"),
            ),
        ],
    );
    let point = message(
        "Point",
        vec![
            field("x", 1, Type::Double, None),
            field("y", 2, Type::Double, None),
        ],
    );
    let stamped = message(
        "PointStamped",
        vec![
            field("header", 1, Type::Message, Some(".demo.Header")),
            field("point", 7, Type::Message, Some(".demo.Point")),
        ],
    );
    let set = FileDescriptorSet {
        file: vec![
            file(
                "google/protobuf/timestamp.proto",
                "google.protobuf",
                &[],
                vec![timestamp],
            ),
            file(
                "point.proto",
                "demo",
                &["google/protobuf/timestamp.proto"],
                vec![header, point, stamped],
            ),
        ],
    };
    prost::Message::encode_to_vec(&set)
}

/// Samples that a camera could have seen, or not.
pub fn samples(count: usize) -> Vec<Sample> {
    (0..count)
        .map(|i| Sample {
            stamp: 1_700_000_000_000_000_000 + i as i64 * 16_666_667,
            x: 0.3 + 0.001 * i as f64,
            y: if i % 7 == 0 { 0.0 } else { -0.2 * i as f64 },
        })
        .collect()
}

/// A log of these samples on `/p`, and of other messages that must be passed over.
pub fn write(encoding: Encoding, options: WriteOptions, samples: &[Sample]) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut writer: Writer<_> = options.create(&mut file).expect("writes");
    let (name, schema_encoding, message_encoding, data) = encoding.schema();
    let schema = writer
        .add_schema(name, schema_encoding, &data)
        .expect("writes");
    let channel = writer
        .add_channel(schema, "/p", message_encoding, &BTreeMap::new())
        .expect("writes");
    let other = writer
        .add_channel(0, "/other", "bytes", &BTreeMap::new())
        .expect("writes");
    for (i, sample) in (0..).zip(samples) {
        let header = |channel_id| MessageHeader {
            channel_id,
            sequence: i,
            log_time: sample.stamp as u64 + 5,
            publish_time: sample.stamp as u64,
        };
        writer
            .write_to_known_channel(&header(channel), &encoding.message(sample))
            .expect("writes");
        writer
            .write_to_known_channel(&header(other), &[7; 30])
            .expect("writes");
    }
    writer.finish().expect("writes");
    drop(writer);
    file.into_inner()
}

/// What is read of topic `/p`, and what was in the log.
pub fn read(bytes: &[u8]) -> Result<(Vec<Sample>, Summary), LogError> {
    read_topic(bytes, TopicRequest::required(&topic("/p")))
}

pub fn read_topic(
    bytes: &[u8],
    topic: TopicRequest<'_>,
) -> Result<(Vec<Sample>, Summary), LogError> {
    let (samples, summary) = read_topics(bytes, &[topic])?;
    let samples = samples.into_iter().map(|(_, sample)| sample);
    Ok((samples.collect(), summary))
}

/// Samples with the indices of their topics.
pub fn read_topics(
    bytes: &[u8],
    wanted: &[TopicRequest<'_>],
) -> Result<(Vec<(usize, Sample)>, Summary), LogError> {
    let mut samples = Vec::new();
    let log = Cursor::new(bytes);
    let summary = logs::read_from("test.mcap", log, wanted, Limits::default(), &mut |event| {
        if let Event::Sample(index, sample) = event {
            samples.push((index, sample));
        }
    })?;
    Ok((samples, summary))
}
