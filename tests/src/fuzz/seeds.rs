//! Inputs to begin with: small ones of every kind that is read.

use std::io::Cursor;

use logs::write::{RecordingWriter, Samples, Stamped};
use mcap::WriteOptions;
use mcap::records::MessageHeader;
use store::network::{LAYERS, Layer, SIZES};
use store::{
    Calibrated, Contents, InputFile, Logged, Model, Network, Provenance, ResidualModel,
    StageRecord, Store, TrainedRegion,
};
use values::{Point, Rig, Shape, StopErrors};
use world::effects::{EFFECTS, Parameters};
use world::{AddedEffect, Estimate, World};

use super::images::bytes;

const POINT_STAMPED: &str = "# A point.\nstd_msgs/Header header\nPoint point\n\
    ================================================================================\n\
    MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
    ================================================================================\n\
    MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n";

/// Logs as the demo writes them, and the same messages without compression and checksums.
pub(super) fn logs() -> Vec<Vec<u8>> {
    let topics = Rig::demo(Shape::Cylinder).topics;
    let stamped = |step: u64| {
        Stamped::at(
            1_700_000_000_000_000_000 + step * 16_000_000,
            Point::new(0.3 + 0.01 * step as f64, 0.1),
        )
    };
    let samples = Samples {
        centroids: (0..12).map(stamped).collect(),
        commands: (0..12).map(stamped).collect(),
        states: Vec::new(),
    };
    let mut writer = RecordingWriter::new(Cursor::new(Vec::new()), &topics).expect("writes");
    writer.write(&samples).expect("writes");
    let demo = writer.finish().expect("writes").into_inner();
    let plain = |chunked: bool, compression: Option<mcap::Compression>| {
        let options = WriteOptions::new()
            .use_chunks(chunked)
            .compression(compression)
            .calculate_chunk_crcs(false)
            .calculate_data_section_crc(false)
            .calculate_summary_section_crc(false);
        let mut file = Cursor::new(Vec::new());
        let mut writer = options.create(&mut file).expect("writes");
        for message in mcap::MessageStream::new(&demo).expect("an own log") {
            let message = message.expect("an own message");
            let schema = message.channel.schema.as_ref().expect("a schema");
            let schema = writer
                .add_schema(&schema.name, &schema.encoding, &schema.data)
                .expect("writes");
            let channel = writer
                .add_channel(
                    schema,
                    &message.channel.topic,
                    &message.channel.message_encoding,
                    &message.channel.metadata,
                )
                .expect("writes");
            let header = MessageHeader {
                channel_id: channel,
                sequence: message.sequence,
                log_time: message.log_time,
                publish_time: message.publish_time,
            };
            writer
                .write_to_known_channel(&header, &message.data)
                .expect("writes");
        }
        writer.finish().expect("writes");
        drop(writer);
        file.into_inner()
    };
    vec![
        plain(false, None),
        plain(true, None),
        plain(true, Some(mcap::Compression::Lz4)),
        plain(true, Some(mcap::Compression::Zstd)),
        demo.clone(),
    ]
}

/// A schema and a message, behind two bytes with the schema's length.
fn pair(schema: &[u8], message: &[u8]) -> Vec<u8> {
    let length = u16::try_from(schema.len()).expect("a short schema");
    [&length.to_le_bytes(), schema, message].concat()
}

pub(super) fn cdr() -> Vec<Vec<u8>> {
    let message = |mut bytes: Vec<u8>, little: bool| {
        let word = |value: u32| {
            if little {
                value.to_le_bytes()
            } else {
                value.to_be_bytes()
            }
        };
        bytes.extend([word(1_700_000_000), word(5), word(6)].concat());
        bytes.extend(b"table\0\0\0\0\0\0\0");
        for value in [0.3_f64, -0.1, 0.0] {
            bytes.extend(if little {
                value.to_le_bytes()
            } else {
                value.to_be_bytes()
            });
        }
        bytes
    };
    let little = message(vec![0, 1, 0, 0], true);
    // Fields of every sort before the wanted ones.
    let more = POINT_STAMPED.replace(
        "Point point",
        "bool[3] a\nfloat32[] b\nstring<=8[<=2] c\nint16 K=3\nuint8 d 7\nPoint[2] e\nPoint point",
    );
    let recursive = POINT_STAMPED.replace("float64 z", "Point[] z");
    let wide = POINT_STAMPED.replace("Point point", "wstring w\nPoint point");
    vec![
        pair(POINT_STAMPED.as_bytes(), &little),
        pair(POINT_STAMPED.as_bytes(), &message(vec![0, 0, 0, 0], false)),
        pair(more.as_bytes(), &[&little[..], &[0; 120]].concat()),
        pair(recursive.as_bytes(), &little),
        pair(wide.as_bytes(), &little),
    ]
}

pub(super) fn json() -> Vec<Vec<u8>> {
    [
        r#"{"header":{"frame_id":"t","stamp":{"sec":1700000000,"nanosec":5}},"point":{"x":0.3,"y":-1e-3,"z":0}}"#,
        r#"{"point":{"y":"0.1","x":[1,{"x":2}]},"header":{"stamp":1700000000.5}}"#,
        r#"{"a":[[[[]]],{"\u00e9":null}],"point":{"x":true,"x":1,"y":2}}"#,
    ]
    .iter()
    .map(|text| pair(b"{}", text.as_bytes()))
    .collect()
}

/// A field of a message, in protobuf's wire format: a number.
fn number(tag: u8, value: u8) -> Vec<u8> {
    vec![tag << 3, value]
}

/// What protoc puts out for a stamped point, and a message of it.
pub(super) fn protobuf() -> Vec<Vec<u8>> {
    const DOUBLE: u8 = 1;
    const INT64: u8 = 3;
    const MESSAGE: u8 = 11;
    let field = |name: &str, tag: u8, kind: u8, of: &str| {
        let mut field = [
            bytes(1, name.as_bytes()),
            number(3, tag),
            number(4, 1),
            number(5, kind),
        ]
        .concat();
        if !of.is_empty() {
            field.extend(bytes(6, of.as_bytes()));
        }
        bytes(2, &field)
    };
    let message = |name: &str, fields: &[Vec<u8>]| {
        bytes(4, &[bytes(1, name.as_bytes()), fields.concat()].concat())
    };
    let types = [
        message(
            "Stamp",
            &[field("sec", 1, INT64, ""), field("nanosec", 2, INT64, "")],
        ),
        message("Header", &[field("stamp", 2, MESSAGE, ".demo.Stamp")]),
        message(
            "Point",
            &[
                field("x", 1, DOUBLE, ""),
                field("y", 2, DOUBLE, ""),
                field("next", 3, MESSAGE, ".demo.Point"),
            ],
        ),
        message(
            "PointStamped",
            &[
                field("header", 1, MESSAGE, ".demo.Header"),
                field("point", 7, MESSAGE, ".demo.Point"),
            ],
        ),
    ];
    let file = [
        bytes(1, b"a.proto"),
        bytes(2, b"demo"),
        types.concat(),
        bytes(12, b"proto3"),
    ]
    .concat();
    let schema = bytes(1, &file);
    let double = |tag: u8, value: f64| [&[tag << 3 | 1][..], &value.to_le_bytes()].concat();
    let stamp = [number(1, 100), number(2, 7)].concat();
    let point = [double(1, 0.3), double(2, -0.1)].concat();
    let sample = [bytes(1, &bytes(2, &stamp)), bytes(7, &point)].concat();
    vec![pair(&schema, &sample), pair(&schema, &[])]
}

pub(super) fn rigs() -> Vec<Vec<u8>> {
    let demo = |shape| Rig::demo(shape).to_toml().into_bytes();
    vec![
        Rig::template().as_bytes().to_vec(),
        demo(Shape::Cylinder),
        demo(Shape::Box),
    ]
}

/// A plain world, and one with every effect of the library.
pub(super) fn worlds() -> Vec<Vec<u8>> {
    let plain = World::nominal().with("friction", 0.2);
    let mut worlds = vec![plain.to_toml().into_bytes()];
    for spec in EFFECTS {
        let Parameters::Listed(parameters) = spec.parameters else {
            continue;
        };
        let estimate = |value| Estimate::with_interval(value, value, value);
        let mut world = plain.clone();
        world.effects.push(AddedEffect {
            name: spec.name.into(),
            parameters: parameters
                .iter()
                .map(|parameter| (parameter.name.to_string(), estimate(parameter.neutral)))
                .collect(),
        });
        worlds.push(world.to_toml().into_bytes());
    }
    worlds
}

fn network() -> Network {
    let numbers = |count: usize| (0..count).map(|i| (i % 7) as f32 * 0.01).collect();
    let layer = |i: usize| Layer {
        weight: numbers(SIZES[i] * SIZES[i + 1]),
        bias: numbers(SIZES[i + 1]),
    };
    Network::new((0..LAYERS).map(layer).collect()).expect("right shapes")
}

pub(super) fn weights() -> Vec<u8> {
    ResidualModel::from(network()).to_safetensors()
}

/// What a version may hold.
pub(super) fn contents() -> Contents {
    let rig = Rig::demo(Shape::Cylinder);
    let metrics = StopErrors::of([0.008, 0.009, 0.012].into_iter()).expect("errors");
    let strikes = [
        (Point::new(0.2, 0.0), Point::new(0.5, 0.1)),
        (Point::new(0.3, 0.1), Point::new(0.9, -0.1)),
    ];
    Contents {
        sysid: Calibrated {
            world: World::nominal(),
            residual: Some(network().into()),
        },
        rig,
        effect: None,
        provenance: Provenance {
            default_model: Model::SysidResidual,
            metrics: [(Model::Nominal, metrics), (Model::SysidResidual, metrics)].into(),
            noise_floor: Some(metrics),
            explained: [].into(),
            varies: [].into(),
            trained_region: TrainedRegion::of(strikes.into_iter()).expect("two strikes"),
            strikes: Some(Logged {
                count: 2,
                last: 1.7e9,
            }),
            moved: None,
            without_effects: false,
            seeds: [("split".to_string(), 7)].into(),
            inputs: vec![InputFile {
                name: "a.mcap".into(),
                sha256: "ab".repeat(32),
                size: 12,
            }],
            stages: vec![StageRecord {
                name: "train".into(),
                version: 3,
                settings: serde_json::json!({"rate": 1e-3}),
            }],
        },
    }
}

pub(super) fn manifest() -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let store = Store::open(folder.path());
    store.publish(&contents()).expect("a version");
    store.show(None).expect("a manifest").to_json()
}
