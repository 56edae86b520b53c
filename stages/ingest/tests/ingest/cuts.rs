//! Logs that are cut off or have flipped bits.

use crate::common::{Folder, ingest, session, truths};
use ingest::LogOutcome;

/// Where the records of a file begin, those within a chunk that is not compressed too.
fn records(bytes: &[u8]) -> Vec<usize> {
    const CHUNK: u8 = 6;
    let (mut at, mut begins) = (8, Vec::new());
    while at + 9 <= bytes.len() - 8 {
        begins.push(at);
        let length = bytes[at + 1..at + 9].try_into().expect("eight bytes");
        // A chunk's own fields: times, sizes, CRC and the empty name of no compression.
        let inner = 9 + 8 + 8 + 8 + 4 + 4 + 8;
        at += if bytes[at] == CHUNK && bytes[at + 9 + 28..at + 9 + 32] == [0; 4] {
            inner
        } else {
            9 + u64::from_le_bytes(length) as usize
        };
    }
    begins
}

/// A log with its messages rewritten uncompressed, so that each is found as a record of its own.
fn unpacked(log: &[u8]) -> Vec<u8> {
    let options = mcap::WriteOptions::new().compression(None);
    let mut file = std::io::Cursor::new(Vec::new());
    let mut writer = options.create(&mut file).expect("writes");
    for message in mcap::MessageStream::new(log).expect("a log") {
        writer.write(&message.expect("a message")).expect("writes");
    }
    writer.finish().expect("writes");
    drop(writer);
    file.into_inner()
}

#[test]
fn a_log_that_is_cut_at_any_record_or_byte_keeps_the_strikes_before() {
    let truths = truths(4);
    let samples = session(&truths);
    let folder = Folder::new();
    let path = folder.write("whole.mcap", &samples);
    let packed = std::fs::read(&path).expect("reads");
    let plain = unpacked(&packed);
    let begins = records(&plain);
    assert!(begins.len() > samples.centroids.len() + samples.commands.len());
    // Of some ten thousand records every seventh, so that all of a message's places are met; and bytes anywhere.
    let at_records = begins.into_iter().step_by(7);
    keeps_the_strikes_before(&folder, &plain, at_records);
    let at_bytes = (8..packed.len()).step_by(packed.len() / 150);
    keeps_the_strikes_before(&folder, &packed, at_bytes);
}

fn keeps_the_strikes_before(folder: &Folder, bytes: &[u8], cuts: impl Iterator<Item = usize>) {
    let path = folder.path("uncut.mcap");
    std::fs::write(&path, bytes).expect("writes");
    let whole = ingest(&path);
    assert_eq!(whole.strikes.len(), 4);
    let cut_path = folder.path("cut.mcap");
    let mut seen = std::collections::BTreeSet::new();
    for length in cuts {
        std::fs::write(&cut_path, &bytes[..length]).expect("writes");
        let cut = ingest(&cut_path);
        let ids = |outcome: &LogOutcome, count: usize| {
            outcome.strikes[..count]
                .iter()
                .map(|s| s.id.clone())
                .collect::<Vec<_>>()
        };
        assert_eq!(ids(&cut, cut.strikes.len()), ids(&whole, cut.strikes.len()));
        // A file whose index alone is cut has all its messages.
        let words = if cut.whole {
            "the index is not whole"
        } else {
            "truncated"
        };
        assert!(
            cut.notes.iter().any(|note| note.contains(words)),
            "{:?}",
            cut.notes
        );
        assert!(!cut.whole || cut.strikes.len() == 4);
        assert!(
            cut.rejects
                .iter()
                .all(|reject| reject.reason.name() == "truncated"),
            "{:?}",
            cut.rejects
        );
        assert!(cut.rejects.len() <= 1);
        seen.insert(cut.strikes.len());
    }
    assert!(seen.contains(&0) && seen.len() > 1, "{seen:?}");
}

#[test]
fn flipped_bits_change_no_strike_that_is_kept_where_there_is_a_checksum() {
    let folder = Folder::new();
    let path = folder.write("whole.mcap", &session(&truths(3)));
    let (whole, bytes) = (ingest(&path), std::fs::read(&path).expect("reads"));
    let flipped_path = folder.path("flipped.mcap");
    let mut kept = std::collections::BTreeSet::new();
    for (count, at) in (8..bytes.len()).step_by(bytes.len() / 120).enumerate() {
        let mut flipped = bytes.clone();
        flipped[at] ^= 1 << (count % 8);
        std::fs::write(&flipped_path, flipped).expect("writes");
        // A schema or a name may be what is flipped: then the log is refused.
        let Ok(read) = ingest::ingest_log(
            &flipped_path,
            &crate::common::rig(),
            &ingest::Ingest { seed: 1 },
        ) else {
            continue;
        };
        let ids: Vec<_> = whole.strikes.iter().map(|strike| &strike.id).collect();
        let all_whole = read.strikes.iter().all(|strike| ids.contains(&&strike.id));
        assert!(all_whole || !read.whole, "byte {at}: {:?}", read.notes);
        assert!(
            read.strikes.len() + read.rejects.len() >= 3 || !read.whole,
            "byte {at}"
        );
        kept.insert(read.strikes.len());
    }
    assert!(kept.contains(&3) && kept.len() > 1, "{kept:?}");
}
