//! Copies of what is needed of a log, made by ranges.

use std::collections::BTreeSet;
use std::io::Cursor;
use std::ops::Range;
use std::path::Path;

use logs::part::{Source, Wanted, copy, is_copied, size};
use logs::{Event, Limits, Sample, TopicRequest};
use mcap::WriteOptions;
use mcap::records::MessageHeader;

use crate::common::{Encoding, samples, topic};

/// A log with chunks of `/p` and, between them, chunks of images.
fn log(options: WriteOptions, samples: &[Sample]) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut writer = options.create(&mut file).unwrap();
    let (name, encoding, message_encoding, data) = Encoding::Cdr.schema();
    let schema = writer.add_schema(name, encoding, &data).unwrap();
    let none = Default::default();
    let point = writer
        .add_channel(schema, "/p", message_encoding, &none)
        .unwrap();
    let images =
        ["/images", "/more"].map(|name| writer.add_channel(0, name, "cdr", &none).unwrap());
    for (sequence, sample) in (0..).zip(samples) {
        let header = |channel_id| MessageHeader {
            channel_id,
            sequence,
            log_time: sample.stamp as u64,
            publish_time: sample.stamp as u64,
        };
        let message = Encoding::Cdr.message(sample);
        writer
            .write_to_known_channel(&header(point), &message)
            .unwrap();
        if sequence % 10 == 9 {
            writer.flush().unwrap();
            for image in images {
                writer
                    .write_to_known_channel(&header(image), &[7; 40_000])
                    .unwrap();
                writer.flush().unwrap();
            }
        }
    }
    writer.finish().unwrap();
    drop(writer);
    file.into_inner()
}

fn wanted(topics: &[&str]) -> Wanted {
    Wanted {
        topics: topics.iter().map(|name| (*name).into()).collect(),
        instead: Some(("/images".into(), "/centroid".into())),
    }
}

/// Copies it; the bytes that were read.
fn copied(whole: &[u8], source: &Source<'_>, path: &Path) -> u64 {
    let mut moved = 0;
    let mut read = |range: Range<u64>| -> Result<Vec<u8>, durable::Error> {
        moved += range.end - range.start;
        Ok(whole[range.start as usize..range.end as usize].to_vec())
    };
    copy(source, path, "test", &mut read).unwrap();
    moved
}

fn read(path: &Path) -> (Vec<Sample>, logs::Summary) {
    let mut samples = Vec::new();
    let request = topic("/p");
    let wanted = [TopicRequest::required(&request)];
    let summary = logs::read(path, &wanted, Limits::default(), &mut |event| {
        if let Event::Sample(0, sample) = event {
            samples.push(sample);
        }
    });
    (samples, summary.unwrap())
}

#[test]
fn a_copy_has_the_samples_and_the_hash_of_the_whole_and_few_of_its_bytes() {
    let dir = tempfile::tempdir().unwrap();
    let (whole, part) = (dir.path().join("whole.mcap"), dir.path().join("part.mcap"));
    let bytes = log(WriteOptions::new().compression(None), &samples(100));
    std::fs::write(&whole, &bytes).unwrap();
    let sha256 = logs::hash(&whole).unwrap();
    let all_but_images = wanted(&["/p", "/centroid"]);
    let wanted = Wanted {
        instead: None,
        ..all_but_images.clone()
    };
    let source = Source {
        size: bytes.len() as u64,
        tag: "1",
        sha256: Some(&sha256),
        wanted: Some(&wanted),
    };
    assert!(!is_copied(&source, &part));
    let moved = copied(&bytes, &source, &part);
    assert!(moved < 50_000, "{moved} of {} bytes", bytes.len());
    let (expected, found) = (read(&whole), read(&part));
    assert_eq!(found.0, expected.0);
    assert_eq!(found.0.len(), 100);
    assert_eq!(found.1.sha256, sha256);
    assert_eq!(found.1.damage, expected.1.damage);
    assert_eq!(logs::hash(&part).unwrap(), sha256);
    assert_eq!(size(&part).unwrap(), bytes.len() as u64);
    let names = |summary: &logs::Summary| -> BTreeSet<String> {
        summary
            .topics
            .iter()
            .map(|topic| topic.name.clone())
            .collect()
    };
    assert_eq!(names(&found.1), names(&expected.1));

    // Another content, or more that is wanted, is another copy.
    assert!(is_copied(&source, &part));
    for other in [
        Source {
            tag: "2",
            ..source.clone()
        },
        Source {
            size: 1,
            ..source.clone()
        },
        Source {
            wanted: None,
            ..source.clone()
        },
        Source {
            wanted: Some(&all_but_images),
            ..source.clone()
        },
    ] {
        assert!(!is_copied(&other, &part));
    }
    // What was written into since is no copy.
    let damaged = [std::fs::read(&part).unwrap(), vec![0]].concat();
    std::fs::write(&part, damaged).unwrap();
    assert!(!is_copied(&source, &part));
    assert_ne!(logs::hash(&part).unwrap(), sha256);
}

#[test]
fn without_a_hash_all_is_read_and_images_are_copied_where_nothing_else_tells_the_place() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("part.mcap");
    let bytes = log(WriteOptions::new(), &samples(40));
    let wanted = wanted(&["/p", "/centroid"]);
    let source = Source {
        size: bytes.len() as u64,
        tag: "1",
        sha256: None,
        wanted: Some(&wanted),
    };
    assert!(copied(&bytes, &source, &path) > bytes.len() as u64);
    let mut seen = std::collections::BTreeMap::new();
    logs::read::read_raw::<logs::LogError>(&path, Limits::default(), &mut |message| {
        *seen.entry(message.channel.topic.clone()).or_insert(0) += 1;
        Ok(())
    })
    .unwrap();
    assert_eq!(seen.get("/images"), Some(&4));
    assert_eq!(seen.get("/more"), None);
    assert_eq!(seen.get("/p"), Some(&40));
    std::fs::write(dir.path().join("whole.mcap"), &bytes).unwrap();
    let whole = logs::hash(&dir.path().join("whole.mcap")).unwrap();
    assert_eq!(logs::hash(&path).unwrap(), whole);
}

#[test]
fn what_has_no_index_is_copied_whole() {
    let whole = log(WriteOptions::new().compression(None), &samples(40));
    let mut damaged = whole.clone();
    // Within the index, whose CRC tells.
    let at = damaged.len() - 200;
    damaged[at] ^= 1;
    let cases = [
        whole[..whole.len() * 2 / 3].to_vec(),
        whole[..5].to_vec(),
        Vec::new(),
        damaged,
        log(WriteOptions::new().use_chunks(false), &samples(40)),
        log(
            WriteOptions::new().emit_message_indexes(false),
            &samples(40),
        ),
        log(WriteOptions::new().emit_statistics(false), &samples(40)),
        b"SQLite format 3\0 and so on, for longer than a footer of MCAP would be".to_vec(),
    ];
    for (case, bytes) in cases.iter().enumerate() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("part.mcap");
        let source = Source {
            size: bytes.len() as u64,
            tag: "1",
            sha256: None,
            wanted: Some(&wanted(&["/p"])),
        };
        copied(bytes, &source, &path);
        assert_eq!(std::fs::read(&path).unwrap(), *bytes, "case {case}");
    }
}
