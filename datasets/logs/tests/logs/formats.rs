//! Whatever a log is written with, the same samples are read from it.

use std::path::PathBuf;

use crate::common::{ENCODINGS, Encoding, read, read_topic, samples, write};
use crate::damage::record;
use logs::{Decoder, LogError, Sample, SchemaText, TopicRequest};
use mcap::{Compression, WriteOptions};
use proptest::prelude::*;
use values::FieldTopic;

#[test]
fn the_frame_of_a_message_is_read_beside_its_place() {
    for encoding in ENCODINGS {
        let (name, schema_encoding, message_encoding, data) = encoding.schema();
        let schema = SchemaText {
            name,
            encoding: schema_encoding,
            data: &data,
        };
        let (topic, frame) = (crate::common::topic("/p"), Some("header.frame_id"));
        let decoder = Decoder::compile_with(message_encoding, Some(schema), &topic, &[], frame)
            .expect("compiles");
        for sample in samples(9) {
            let (fields, _, frame) = decoder
                .decode_with(&encoding.message(&sample))
                .expect("is read");
            assert_eq!((fields.x, fields.stamp), (sample.x, Some(sample.stamp)));
            assert_eq!(frame.as_deref(), Some("table"), "{message_encoding}");
        }
    }
}

/// Every way to lay out a file, by the writer's options.
fn layouts() -> Vec<WriteOptions> {
    let mut layouts = Vec::new();
    for compression in [None, Some(Compression::Lz4), Some(Compression::Zstd)] {
        for (chunks, crc, index) in [
            (true, true, true),
            (true, false, true),
            (true, true, false),
            (false, true, true),
            (false, false, false),
        ] {
            for chunk_size in [200, 1 << 20] {
                layouts.push(
                    WriteOptions::new()
                        .compression(compression.filter(|_| chunks))
                        .use_chunks(chunks)
                        .chunk_size(Some(chunk_size))
                        .calculate_chunk_crcs(crc)
                        .calculate_data_section_crc(crc)
                        .calculate_summary_section_crc(crc)
                        .emit_summary_records(index)
                        .emit_summary_offsets(index)
                        .emit_message_indexes(index),
                );
            }
        }
    }
    layouts
}

#[test]
fn every_encoding_in_every_layout_gives_the_same_samples() {
    let written = samples(50);
    for encoding in ENCODINGS {
        for options in layouts() {
            let (read, summary) = read(&write(encoding, options.clone(), &written)).expect("reads");
            assert!(read == written, "{encoding:?} {options:?}");
            assert_eq!(summary.damage, [], "{options:?}");
            assert_eq!(summary.messages, 100);
        }
    }
}

#[test]
fn the_same_bytes_have_the_hash_that_other_tools_give() {
    let file = write(Encoding::Json, WriteOptions::new(), &samples(3));
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("a.mcap");
    std::fs::write(&path, &file).expect("writes");
    let Ok(output) = std::process::Command::new("sha256sum").arg(&path).output() else {
        eprintln!("skipped: sha256sum is not there");
        return;
    };
    let (_, summary) = read(&file).expect("reads");
    assert!(String::from_utf8_lossy(&output.stdout).starts_with(&summary.sha256));
}

/// "Records may be extended by adding new fields at the end of existing fields. Readers should ignore any unknown fields."
/// Source: MCAP specification.
#[test]
fn bytes_after_the_fields_of_records_are_passed_over() {
    let record = |opcode, body: &[u8]| record(opcode, body.len() as u64, body);
    let text = |text: &[u8]| [&(text.len() as u32).to_le_bytes(), text].concat();
    let later = |fields: Vec<u8>| [fields, vec![1, 2, 3]].concat();
    let (name, schema_encoding, message_encoding, schema) = Encoding::Cdr.schema();
    let sample = samples(1)[0];
    let schema = [
        &[1, 0],
        &text(name.as_bytes())[..],
        &text(schema_encoding.as_bytes()),
        &text(&schema),
    ]
    .concat();
    let channel = [
        &[0, 0, 1, 0],
        &text(b"/p")[..],
        &text(message_encoding.as_bytes()),
        &text(b""),
    ]
    .concat();
    let message = [&[0; 2 + 4 + 8 + 8], &Encoding::Cdr.message(&sample)[..]].concat();
    let records = [
        record(3, &later(schema)),
        record(4, &later(channel)),
        record(5, &message),
    ]
    .concat();
    let length = (records.len() as u64).to_le_bytes();
    let chunk = [
        &[0; 16],
        &length[..],
        &[0; 4],
        &text(b""),
        &length,
        &records,
    ]
    .concat();
    for data in [records, record(6, &later(chunk))] {
        let file = [
            mcap::MAGIC.to_vec(),
            record(1, &later([text(b"ros2"), text(b"")].concat())),
            data,
            record(15, &later(vec![0; 4])),
            record(2, &[0; 20]),
            mcap::MAGIC.to_vec(),
        ]
        .concat();
        let (read, summary) = read(&file).expect("reads");
        assert_eq!((read, summary.damage), (vec![sample], Vec::new()));
    }
}

#[test]
fn a_missing_topic_is_named_with_those_that_are_there() {
    let file = write(Encoding::Cdr, WriteOptions::new(), &samples(3));
    let topic = crate::common::topic("/object/centroid");
    let wanted = TopicRequest::required(&topic);
    let text = read_topic(&file, wanted).expect_err("refused").to_string();
    assert!(
        text.contains("/object/centroid") && text.contains("/p (geometry_msgs/msg/PointStamped)"),
        "{text}"
    );
    let optional = TopicRequest {
        required: false,
        ..wanted
    };
    assert!(read_topic(&file, optional).is_ok());
}

#[test]
fn a_schema_without_a_stamp_leaves_the_log_time() {
    let file = write(Encoding::Cdr, WriteOptions::new(), &samples(3));
    let topic = FieldTopic {
        stamp: "time".into(),
        ..crate::common::topic("/p")
    };
    let (read, summary) = read_topic(&file, TopicRequest::required(&topic)).expect("reads");
    let stamps = |samples: &[Sample]| samples.iter().map(|s| s.stamp).collect::<Vec<_>>();
    let logged = stamps(&samples(3))
        .iter()
        .map(|stamp| stamp + 5)
        .collect::<Vec<_>>();
    assert_eq!(stamps(&read), logged);
    assert_eq!(summary.unstamped, [true]);
}

#[test]
fn what_is_no_mcap_is_said_so() {
    for bytes in [&b"\x89MCAP"[..], b"SQLite format 3\0 and more of it"] {
        assert!(matches!(read(bytes), Err(LogError::NotMcap { .. })));
    }
    assert!(matches!(read(b""), Err(LogError::Empty { .. })));
}

/// Files that the mcap crate ships in its tests, recorded on a real robot (ROS 1) by the Go writer.
fn shipped(name: &str) -> Option<PathBuf> {
    let cargo = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = cargo.or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".cargo")))?;
    let found = std::fs::read_dir(home.join("registry/src"))
        .ok()?
        .flatten()
        .find_map(|registry| {
            let crates = std::fs::read_dir(registry.path()).ok()?.flatten();
            let crates =
                crates.filter(|entry| entry.file_name().to_string_lossy().starts_with("mcap-"));
            crates
                .map(|entry| entry.path().join("tests/data").join(name))
                .find(|path| path.is_file())
        });
    if found.is_none() {
        eprintln!("skipped: the mcap crate's {name} is not there");
    }
    found
}

#[test]
fn files_that_others_recorded_are_read() {
    let topic = FieldTopic {
        name: "/tf".into(),
        stamp: "transforms[0].header.stamp".into(),
        x: "transforms[0].transform.translation.x".into(),
        y: "transforms[0].transform.translation.y".into(),
    };
    let mut all: Vec<Vec<Sample>> = Vec::new();
    for name in ["uncompressed.mcap", "compressed.mcap"] {
        let Some(path) = shipped(name) else { return };
        let file = std::fs::read(&path).expect("a file");
        let (samples, summary) = read_topic(&file, TopicRequest::required(&topic)).expect("reads");
        assert!(
            summary.damage.is_empty() && summary.undecodable[0].0 == 0,
            "{summary:?}"
        );
        assert!(
            summary
                .topics
                .iter()
                .any(|topic| topic.name == "/diagnostics")
        );
        // Stamps of March 2017, some seconds long, and a car's places within the map.
        assert!(samples.len() > 100, "{}", samples.len());
        assert!(
            samples
                .iter()
                .all(|s| (1_480_000_000..1_500_000_000).contains(&(s.stamp / 1_000_000_000))),
            "{:?}",
            samples[0]
        );
        assert!(samples.iter().all(|s| s.x.is_finite() && s.x.abs() < 1e6));
        all.push(samples);
    }
    assert_eq!(all[0], all[1], "both hold the same messages");
}

fn sample() -> impl Strategy<Value = Sample> {
    let stamp = 0..i64::from(i32::MAX) * 1_000_000_000;
    (stamp, any::<f64>(), any::<f64>()).prop_map(|(stamp, x, y)| Sample { stamp, x, y })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_sample_survives_any_encoding(samples in prop::collection::vec(sample(), 0..20), layout in 0..30_usize, encoding in 0..4_usize) {
        let encoding = ENCODINGS[encoding];
        let samples: Vec<Sample> = samples
            .into_iter()
            .filter(|sample| encoding != Encoding::Json || (sample.x.is_finite() && sample.y.is_finite()))
            .collect();
        let file = write(encoding, layouts()[layout].clone(), &samples);
        let (read, _) = read(&file).expect("reads");
        let bits = |samples: &[Sample]| -> Vec<_> {
            samples.iter().map(|s| (s.stamp, s.x.to_bits(), s.y.to_bits())).collect()
        };
        prop_assert_eq!(bits(&read), bits(&samples));
    }
}

#[test]
fn messages_that_rosbag2_packed_one_by_one_are_read_as_if_they_were_plain() {
    use logs::read::read_raw;
    use logs::write::{CopyWriter, RecordingWriter, Samples, Stamped};
    use logs::{Event, Limits, TopicRequest, read};

    let folder = tempfile::tempdir().expect("a folder");
    let [plain, packed] = ["plain.mcap", "packed.mcap"].map(|name| folder.path().join(name));
    let topics = values::Topics::default();
    let at = |i: u64| {
        Stamped::at(
            1_700_000_000_000_000_000 + i * 10_000_000,
            values::Point::new(0.3 + 0.001 * i as f64, -0.1),
        )
    };
    let samples = Samples {
        centroids: (0..20).map(at).collect(),
        commands: (0..20).map(at).collect(),
        states: Vec::new(),
    };
    let mut writer = RecordingWriter::create(&plain, &topics).expect("creates");
    writer.write(&samples).expect("writes");
    writer.finish().expect("finishes");
    let mut copy = CopyWriter::create(&packed).expect("creates");
    read_raw(&plain, Limits::default(), &mut |message| {
        let channel = message.channel;
        let data = zstd::bulk::compress(message.data, 3).expect("packs");
        let schema = (
            channel.schema.as_str(),
            channel.schema_encoding.as_str(),
            &channel.schema_data[..],
        );
        copy.add(
            &channel.topic,
            schema,
            &channel.encoding,
            message.log_time,
            &data,
        )
        .expect("writes");
        Ok::<(), logs::LogError>(())
    })
    .expect("reads");
    copy.finish().expect("finishes");
    let [plain, packed] = [plain, packed].map(|log| {
        let wanted = [&topics.centroid, &topics.command].map(TopicRequest::required);
        let mut seen = Vec::new();
        read(&log, &wanted, Limits::default(), &mut |event| match event {
            Event::Sample(topic, sample) => seen.push((topic, sample)),
            other => panic!("{other:?}"),
        })
        .expect("reads");
        seen
    });
    assert_eq!(plain.len(), 40);
    assert_eq!(plain, packed);
}
