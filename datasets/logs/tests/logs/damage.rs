//! Files that are cut, damaged or made to harm: what is whole is read, and nothing panics or takes much memory.

use crate::common::{ENCODINGS, Encoding, read, samples, write};
use logs::read::Extent;
use logs::{LogError, Summary};
use mcap::records::op;
use mcap::{Compression, WriteOptions};
use proptest::prelude::*;

fn options(compression: Option<Compression>, chunk_size: u64) -> WriteOptions {
    WriteOptions::new()
        .compression(compression)
        .chunk_size(Some(chunk_size))
}

/// Where a file's records of this kind begin.
fn records(file: &[u8], opcode: u8) -> Vec<usize> {
    let mut offsets = Vec::new();
    let mut at = mcap::MAGIC.len();
    while at + 9 <= file.len() - mcap::MAGIC.len() {
        if file[at] == opcode {
            offsets.push(at);
        }
        let length = u64::from_le_bytes(file[at + 1..at + 9].try_into().expect("eight bytes"));
        at += 9 + length as usize;
    }
    offsets
}

fn extents(summary: &Summary) -> Vec<Extent> {
    summary.damage.iter().map(|damage| damage.extent).collect()
}

/// A record as MCAP frames it: opcode, length, body.
pub fn record(opcode: u8, length: u64, body: &[u8]) -> Vec<u8> {
    [&[opcode][..], &length.to_le_bytes(), body].concat()
}

/// A chunk's record with this header and body.
fn chunk(compression: &str, unpacked: u64, crc: u32, packed: u64, records: &[u8]) -> Vec<u8> {
    let mut body = [0_u64, 0, unpacked].map(u64::to_le_bytes).concat();
    body.extend(crc.to_le_bytes());
    body.extend((compression.len() as u32).to_le_bytes());
    body.extend(compression.as_bytes());
    body.extend(packed.to_le_bytes());
    body.extend(records);
    record(op::CHUNK, body.len() as u64, &body)
}

/// A whole file with a record put in before its data ends.
fn with_record(record: &[u8]) -> Vec<u8> {
    let mut file = write(Encoding::Cdr, options(None, 1 << 20), &samples(10));
    let end = records(&file, op::DATA_END)[0];
    file.splice(end..end, record.iter().copied());
    // The CRC of the data section is left out, as rosbag2 does.
    let crc = end + record.len() + 9;
    file[crc..crc + 4].fill(0);
    file
}

#[test]
fn a_file_cut_at_any_byte_gives_what_is_whole_of_it() {
    let written = samples(12);
    let layouts = [
        WriteOptions::new().use_chunks(false),
        options(None, 300),
        options(None, 1 << 20),
        options(Some(Compression::Zstd), 300),
        options(Some(Compression::Lz4), 300),
    ];
    for layout in layouts {
        let file = write(Encoding::Cdr, layout.clone(), &written);
        let mut before = 0;
        for length in 0..file.len() {
            match read(&file[..length]) {
                Ok((read, summary)) => {
                    assert!(read == written[..read.len()]);
                    assert!(read.len() >= before, "a longer piece gives no less");
                    before = read.len();
                    assert_eq!(summary.damage.len(), 1, "{length} {:?}", summary.damage);
                    assert!(summary.truncated() || read.len() == written.len());
                }
                Err(error) => assert!(length < 8, "{length}: {error}"),
            }
        }
        assert_eq!(before, written.len());
    }
}

#[test]
fn what_is_whole_of_a_chunk_that_is_cut_is_given() {
    // One chunk of several zstd blocks of 128 KB, or of records as they are.
    let written = samples(6_000);
    for (compression, at_least) in [
        (None, 2_990),
        (Some(Compression::Zstd), 1_000),
        (Some(Compression::Lz4), 1_000),
    ] {
        let file = write(Encoding::Cdr, options(compression, 1 << 24), &written);
        let (read, summary) = read(&file[..file.len() / 2]).expect("reads");
        assert!(read.len() >= at_least, "{compression:?} {}", read.len());
        assert!(read == written[..read.len()]);
        assert!(summary.truncated());
    }
}

#[test]
fn a_damaged_chunk_is_left_out_and_the_others_are_read() {
    let written = samples(60);
    for compression in [None, Some(Compression::Zstd), Some(Compression::Lz4)] {
        let mut file = write(Encoding::Cdr, options(compression, 600), &written);
        let chunks = records(&file, op::CHUNK);
        assert!(chunks.len() > 5);
        file[chunks[3] + 9 + 80] ^= 0x10;
        let (read, summary) = read(&file).expect("reads");
        let parts: Vec<_> = summary
            .damage
            .iter()
            .filter(|damage| damage.extent == Extent::Part)
            .collect();
        assert_eq!(parts.len(), 1, "{:?}", summary.damage);
        assert_eq!(parts[0].offset, chunks[3] as u64);
        assert!(read.len() > 40 && read.len() < 60, "{}", read.len());
        assert!(
            read.iter().all(|sample| written.contains(sample)),
            "nothing wrong is given"
        );
        assert_eq!(read.last(), written.last());
    }
}

/// A chunk that is too large to be held is read or unpacked twice: once for its CRC, before anything of it is given.
#[test]
fn a_large_chunk_is_given_as_a_whole_or_not_at_all() {
    let written = samples(100_000);
    for compression in [None, Some(Compression::Zstd), Some(Compression::Lz4)] {
        let mut file = write(Encoding::Cdr, options(compression, 1 << 25), &written);
        let unpacked = records(&file, op::CHUNK)[0] + 9 + 16;
        let size = u64::from_le_bytes(file[unpacked..unpacked + 8].try_into().expect("8 bytes"));
        assert!(size > 8 << 20, "{size}");
        let (read_whole, summary) = read(&file).expect("reads");
        assert!(read_whole == written && summary.damage.is_empty());
        let (part, summary) = read(&file[..file.len() / 2]).expect("reads");
        assert!(part.len() > 1_000 && part == written[..part.len()] && summary.truncated());

        file[unpacked + 8] ^= 1;
        match read(&file) {
            Ok((read, summary)) => {
                assert!(read.is_empty() && !summary.damage.is_empty());
                assert!(
                    summary.damage[0].why.contains("CRC"),
                    "{:?}",
                    summary.damage
                );
            }
            Err(error) => assert!(matches!(error, LogError::MissingTopic { .. }), "{error}"),
        }
    }
}

#[test]
fn a_flipped_bit_outside_of_chunks_distrusts_all() {
    let mut file = write(
        Encoding::Cdr,
        WriteOptions::new().use_chunks(false),
        &samples(20),
    );
    let messages = records(&file, op::MESSAGE);
    file[messages[8] + 70] ^= 1;
    let (_, summary) = read(&file).expect("reads");
    assert_eq!(extents(&summary), [Extent::Unlocated]);
}

#[test]
fn a_chunk_that_would_unpack_to_too_much_is_an_error() {
    let bomb = vec![0_u8; 200 << 20];
    let mut packed = Vec::new();
    let mut writer = WriteOptions::new()
        .compression(Some(Compression::Zstd))
        .chunk_size(None)
        .create(std::io::Cursor::new(&mut packed))
        .expect("writes");
    writer
        .write_private_record(
            0x80,
            &bomb,
            mcap::write::PrivateRecordOptions::IncludeInChunks.into(),
        )
        .expect("writes");
    writer.finish().expect("writes");
    drop((writer, bomb));
    assert!(packed.len() < 100_000, "{}", packed.len());
    assert!(matches!(
        read(&packed),
        Err(LogError::TooLarge { what: "chunk", .. })
    ));

    // The same, with a header that lies about what it unpacks to.
    let at = records(&packed, op::CHUNK)[0];
    for lie in [1_000_u64, 60 << 20] {
        let mut lying = packed.clone();
        lying[at + 9 + 16..at + 9 + 24].copy_from_slice(&lie.to_le_bytes());
        let (samples, summary) = match read(&lying) {
            Ok(read) => read,
            Err(LogError::MissingTopic { .. }) => continue,
            Err(error) => panic!("{error}"),
        };
        assert!(samples.is_empty() && !summary.damage.is_empty());
    }
}

#[test]
fn lengths_that_lie_take_no_memory() {
    let record = |length: u64, body: &[u8]| record(op::MESSAGE, length, body);
    let inner = record(u64::MAX, &[1; 50]);
    let huge = record(1 << 60, &[1; 50]);
    for (lie, is_rest) in [
        (huge.clone(), true),
        (record(u64::MAX, &[]), true),
        (record(60 << 20, &[]), true),
        (
            chunk("", inner.len() as u64, 0, inner.len() as u64, &inner),
            false,
        ),
        (chunk("", huge.len() as u64, 0, u64::MAX, &huge), false),
        (chunk("zstd", 1 << 20, 0, 50, &[3; 50]), false),
        (chunk("lz4", 1 << 20, 77, 50, &[3; 50]), false),
        (chunk("zstd", 0, 0, 0, &[]), true),
    ] {
        let (read, summary) = read(&with_record(&lie)).expect("reads");
        assert_eq!(read, samples(10), "what comes before is read");
        if lie.len() > 60 || is_rest {
            let extent = if is_rest { Extent::Rest } else { Extent::Part };
            let extents = extents(&summary);
            assert!(extents.iter().all(|found| *found == extent), "{extents:?}");
        }
    }
    let strange = chunk("bzip2", 10, 0, 10, &[0; 10]);
    assert!(matches!(
        read(&with_record(&strange)),
        Err(LogError::Compression { .. })
    ));
    let claims = chunk("zstd", u64::MAX, 0, 10, &[0; 10]);
    assert!(matches!(
        read(&with_record(&claims)),
        Err(LogError::TooLarge { .. })
    ));
}

#[test]
fn a_large_attachment_is_passed_over() {
    let mut body = [0_u64, 0].map(u64::to_le_bytes).concat();
    body.resize(70 << 20, 0);
    let attachment = record(op::ATTACHMENT, body.len() as u64, &body);
    let (read, summary) = read(&with_record(&attachment)).expect("reads");
    assert_eq!((read, summary.damage), (samples(10), vec![]));
}

#[test]
fn messages_that_do_not_decode_are_counted() {
    let mut file = write(
        Encoding::Json,
        options(None, 1 << 20)
            .calculate_chunk_crcs(false)
            .calculate_data_section_crc(false),
        &samples(10),
    );
    let needle = br#""point""#;
    let at = file
        .windows(needle.len())
        .rposition(|window| window == needle)
        .expect("a point");
    file[at + 1] = b'q';
    let (read, summary) = read(&file).expect("reads");
    assert_eq!(read.len(), 9);
    assert_eq!(summary.undecodable[0].0, 1);
    assert!(
        summary.undecodable[0].1.contains("`x`"),
        "{}",
        summary.undecodable[0].1
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn flipped_bits_never_panic_and_a_crc_lets_nothing_wrong_through(
        flips in prop::collection::vec((any::<prop::sample::Index>(), 0..8_u32), 1..6),
        packing in 0..4_usize,
        encoding in 0..ENCODINGS.len(),
    ) {
        let written = samples(15);
        let layout = match packing {
            0 => WriteOptions::new().use_chunks(false).calculate_data_section_crc(false),
            1 => options(None, 300),
            2 => options(Some(Compression::Zstd), 300),
            _ => options(Some(Compression::Lz4), 300),
        };
        let mut file = write(ENCODINGS[encoding], layout, &written);
        for (at, bit) in &flips {
            let at = at.index(file.len());
            file[at] ^= 1 << bit;
        }
        if let Ok((read, summary)) = read(&file) && packing > 0 {
            // A flip in the chunk's own CRC field may take the check away, but then the data section's shows it.
            let wrong = read.iter().any(|sample| !written.contains(sample));
            prop_assert!(!wrong || !summary.damage.is_empty());
        }
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..400), chunked in any::<bool>()) {
        let file = if chunked {
            with_record(&chunk("", bytes.len() as u64, 0, bytes.len() as u64, &bytes))
        } else {
            [mcap::MAGIC, &bytes].concat()
        };
        let _ = read(&file);
    }

    #[test]
    fn any_schema_and_message_are_decoded_or_refused(text in "[a-z0-9/ \\[\\]<=\n]{0,80}", name in "[a-z/]{0,8}", data in prop::collection::vec(any::<u8>(), 0..60)) {
        for (message, encoding) in [("cdr", "ros2msg"), ("ros1", "ros1msg"), ("protobuf", "protobuf"), ("json", "")] {
            let topic = values::FieldTopic { name: "/p".into(), stamp: "a.b".into(), x: "a".into(), y: "b[1]".into() };
            for text in [text.as_bytes(), &data] {
                let schema = logs::SchemaText { name: &name, encoding, data: text };
                if let Ok(decoder) = logs::Decoder::compile(message, Some(schema), &topic) {
                    let _ = decoder.decode(&data);
                }
            }
        }
    }

    #[test]
    fn a_broken_message_is_decoded_or_refused(cut in any::<prop::sample::Index>(), flip in any::<prop::sample::Index>(), encoding in 0..4_usize) {
        let encoding = ENCODINGS[encoding];
        let (name, schema, message, data) = encoding.schema();
        let text = logs::SchemaText { name, encoding: schema, data: &data };
        let decoder = logs::Decoder::compile(message, Some(text), &crate::common::topic("/p")).expect("compiles");
        let mut message = encoding.message(&samples(2)[1]);
        let at = flip.index(message.len());
        message[at] ^= 0x41;
        message.truncate(1 + cut.index(message.len()));
        let _ = decoder.decode(&message);
    }
}
