//! A log that lies elsewhere, such as in an object store: a copy of what is needed of it, and what the whole is.
//!
//! An MCAP says at its end which chunk holds which channels. Its copy has the chunks of the wanted topics and all that stands between chunks, byte
//! for byte: an MCAP of its own, which is read as any other. What has no such index, or is no MCAP, is copied whole.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

use mcap::records::{Record, op};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// Bytes before a record's body: its opcode and length.
const PREFIX: usize = 9;
/// A chunk beyond this is too large for the reader, too.
const LONGEST: u64 = 64 << 20;
/// Bytes that are read at once where more are wanted.
const PIECE: u64 = 8 << 20;
/// Bytes that are read at once at the end of a file, where its index is.
const TAIL: u64 = 32 << 10;
/// Bytes between two chunks that are read rather than asked around.
const GAP: u64 = 16 << 10;
/// Length of a footer in bytes: the record, and the magic bytes behind it.
const FOOTER: u64 = (PREFIX + 20 + mcap::MAGIC.len()) as u64;
/// Length in bytes of the record that ends the data.
const DATA_END: u64 = (PREFIX + 4) as u64;

/// A log as its store tells of it.
#[derive(Clone, Debug)]
pub struct Source<'a> {
    /// Bytes.
    pub size: u64,
    /// What changes when its content does.
    pub tag: &'a str,
    /// SHA-256 of its bytes in hex, where it is known without reading them.
    pub sha256: Option<&'a str>,
    /// What is needed of it; all, where nothing is said.
    pub wanted: Option<&'a Wanted>,
}

/// Topics that are needed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Wanted {
    /// By their names.
    pub topics: BTreeSet<String>,
    /// A topic that is needed where the first of these is there, and the second is not.
    pub instead: Option<(String, String)>,
}

/// What a copy was made of; kept beside it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Origin {
    sha256: String,
    size: u64,
    tag: String,
    wanted: Option<Wanted>,
    /// Bytes of the copy.
    copied: u64,
}

/// Reads a range of the source's bytes.
pub type Ranges<'a, E> = &'a mut dyn FnMut(Range<u64>) -> Result<Vec<u8>, E>;

impl Origin {
    fn path(copy: &Path) -> PathBuf {
        let name = copy.file_name().unwrap_or_default().to_string_lossy();
        copy.with_file_name(format!(".{name}.origin"))
    }

    /// The origin of a copy that is unchanged since it was made; none of any other file.
    fn of(copy: &Path) -> Option<Self> {
        let text = std::fs::read(Self::path(copy)).ok()?;
        let origin: Self = serde_json::from_slice(&text).ok()?;
        let size = std::fs::metadata(copy).ok()?.len();
        (size == origin.copied).then_some(origin)
    }
}

/// SHA-256 of the log that this is a copy of; none where it is no copy.
pub(crate) fn origin(path: &Path) -> Option<String> {
    Origin::of(path).map(|origin| origin.sha256)
}

/// Bytes of a log: of the whole, where only a part is here.
pub fn size(log: &Path) -> io::Result<u64> {
    match Origin::of(log) {
        Some(origin) => Ok(origin.size),
        None => Ok(std::fs::metadata(log)?.len()),
    }
}

/// Whether a copy is of this source, and has what is wanted.
pub fn is_copied(source: &Source<'_>, copy: &Path) -> bool {
    Origin::of(copy).is_some_and(|kept| {
        kept.tag == source.tag
            && kept.size == source.size
            && kept.wanted.as_ref() == source.wanted
            && source.sha256.is_none_or(|sha256| sha256 == kept.sha256)
    })
}

/// Copies what is wanted; `writer` is a name that no one else has who makes the same copy at this time.
pub fn copy<E: From<durable::Error>>(
    source: &Source<'_>,
    copy: &Path,
    writer: &str,
    read: Ranges<'_, E>,
) -> Result<(), E> {
    let mut written = 0;
    // A hash that another content had is a stale one.
    let is_stale = |sha256: &&str| {
        Origin::of(copy).is_some_and(|old| old.sha256 == *sha256 && old.tag != source.tag)
    };
    let sha256 = source.sha256.filter(|sha256| !is_stale(sha256));
    let mut sha256 = sha256.map(String::from);
    durable::write_as::<E>(writer, copy, |file| {
        let mut put = |bytes: &[u8]| {
            written += bytes.len() as u64;
            file.write_all(bytes)
                .map_err(|source| E::from(durable::Error::new("write", copy, source)))
        };
        let plan = match source.wanted {
            Some(wanted) => plan(source.size, wanted, read)?,
            None => None,
        };
        if let Some(plan) = &plan {
            plan.copy(&mut put, read)?;
        }
        if plan.is_none() || sha256.is_none() {
            // Its hash is that of all its bytes.
            let mut hasher = Sha256::new();
            for at in (0..source.size).step_by(PIECE as usize) {
                let bytes = read(at..source.size.min(at + PIECE))?;
                hasher.update(&bytes);
                if plan.is_none() {
                    put(&bytes)?;
                }
            }
            sha256 = Some(durable::hex(&hasher.finalize()));
        }
        Ok(())
    })?;
    let origin = Origin {
        sha256: sha256.unwrap_or_default(),
        size: source.size,
        tag: source.tag.into(),
        wanted: source.wanted.cloned(),
        copied: written,
    };
    let path = Origin::path(copy);
    durable::write_as(writer, &path, |file| {
        serde_json::to_writer(file, &origin)
            .map_err(|source| E::from(durable::Error::new("write", &path, source.into())))
    })
}

/// What is read of an MCAP.
struct Plan {
    /// Schemas and channels, as records; they go before the first chunk.
    definitions: Vec<u8>,
    /// Ranges that are copied, in their order; the first one begins with the file's header.
    ranges: Vec<Range<u64>>,
}

/// None where the file has no index of all that is in it.
fn plan<E>(size: u64, wanted: &Wanted, read: Ranges<'_, E>) -> Result<Option<Plan>, E> {
    let start = size.saturating_sub(TAIL);
    let tail = read(start..size)?;
    let Some(summary) = summary_start(&tail).filter(|summary| *summary < size) else {
        return Ok(None);
    };
    let before = match summary < start {
        true => read(summary..start)?,
        false => Vec::new(),
    };
    let from = usize::try_from(summary.saturating_sub(start)).unwrap_or(usize::MAX);
    let index = [&before[..], tail.get(from..).unwrap_or_default()].concat();
    Ok(planned(summary, &index, wanted))
}

/// Where the summary begins that a file's last bytes name.
fn summary_start(tail: &[u8]) -> Option<u64> {
    let footer = tail.get(tail.len().checked_sub(FOOTER as usize)?..)?;
    let is_one = footer[0] == op::FOOTER && footer.ends_with(mcap::MAGIC);
    let start = u64::from_le_bytes(footer[PREFIX..PREFIX + 8].try_into().ok()?);
    (is_one && start > 0).then_some(start)
}

fn planned(start: u64, index: &[u8], wanted: &Wanted) -> Option<Plan> {
    let crc_at = index.len().checked_sub(mcap::MAGIC.len() + 4)?;
    let crc = u32::from_le_bytes(index[crc_at..][..4].try_into().ok()?);
    if crc != 0 && crc32fast::hash(&index[..crc_at]) != crc {
        return None;
    }
    let (mut definitions, mut topics, mut schemas) = (Vec::new(), BTreeMap::new(), 0);
    let (mut chunks, mut statistics) = (Vec::new(), None);
    let mut rest = &index[..index.len().checked_sub(FOOTER as usize)?];
    while let Some((prefix, after)) = rest.split_first_chunk::<PREFIX>() {
        let [opcode, length @ ..] = *prefix;
        let length = usize::try_from(u64::from_le_bytes(length)).ok()?;
        let (body, next) = after.split_at_checked(length)?;
        match mcap::parse_record(opcode, body).ok()? {
            Record::Schema { .. } => schemas += 1,
            Record::Channel(channel) => drop(topics.insert(channel.id, channel.topic)),
            Record::ChunkIndex(chunk) => chunks.push(chunk),
            Record::Statistics(found) => statistics = Some(found),
            _ => {}
        }
        if matches!(opcode, op::SCHEMA | op::CHANNEL) {
            definitions.extend_from_slice(&rest[..PREFIX + length]);
        }
        rest = next;
    }
    let counts = statistics?;
    let is_whole = counts.chunk_count as usize == chunks.len()
        && counts.channel_count as usize == topics.len()
        && usize::from(counts.schema_count) == schemas
        && !chunks.is_empty();
    // A chunk without an index of its messages may hold any.
    let is_indexed = |chunk: &mcap::records::ChunkIndex| !chunk.message_index_offsets.is_empty();
    if !is_whole || !chunks.iter().all(is_indexed) {
        return None;
    }
    let has = |name: &String| topics.values().any(|topic| topic == name);
    let instead = wanted.instead.as_ref();
    let instead = instead.filter(|(there, absent)| has(there) && !has(absent));
    let is_wanted = |id: &u16| {
        topics.get(id).is_none_or(|topic| {
            wanted.topics.contains(topic) || instead.is_some_and(|(there, _)| there == topic)
        })
    };
    chunks.sort_by_key(|chunk| chunk.chunk_start_offset);
    let (mut ranges, mut at) = (Vec::new(), mcap::MAGIC.len() as u64);
    for chunk in &chunks {
        let begin = chunk.chunk_start_offset;
        let end = begin.checked_add(chunk.chunk_length)?;
        if begin < at || chunk.chunk_length > LONGEST {
            return None;
        }
        ranges.push(at..begin);
        if chunk.message_index_offsets.keys().any(is_wanted) {
            ranges.push(begin..end);
        }
        at = end.checked_add(chunk.message_index_length)?;
    }
    let end = start.checked_sub(DATA_END).filter(|end| *end >= at)?;
    ranges.push(at..end);
    // What stands between chunks may be an attachment of any size.
    if ranges.iter().any(|range| range.end - range.start > LONGEST) {
        return None;
    }
    // The first one has the header, with which a file begins.
    let first = ranges.remove(0);
    ranges.retain(|range| !range.is_empty());
    ranges.insert(0, first);
    Some(Plan {
        definitions,
        ranges,
    })
}

impl Plan {
    fn copy<E>(
        &self,
        put: &mut dyn FnMut(&[u8]) -> Result<(), E>,
        read: Ranges<'_, E>,
    ) -> Result<(), E> {
        put(mcap::MAGIC)?;
        let mut left = &self.ranges[..];
        let mut is_first = true;
        while let Some(first) = left.first() {
            // As many as lie close together.
            let joined = left.windows(2).take_while(|pair| {
                pair[1].start - pair[0].end <= GAP && pair[1].end - first.start <= PIECE
            });
            let (now, later) = left.split_at(1 + joined.count());
            let bytes = read(first.start..now[now.len() - 1].end)?;
            for range in now {
                let place = |at: u64| usize::try_from(at - first.start).unwrap_or(usize::MAX);
                put(bytes
                    .get(place(range.start)..place(range.end))
                    .unwrap_or_default())?;
                if std::mem::take(&mut is_first) {
                    put(&self.definitions)?;
                }
            }
            left = later;
        }
        // No CRC, and no index.
        put(&record(op::DATA_END, &[0; 4]))?;
        put(&record(op::FOOTER, &[0; 20]))?;
        put(mcap::MAGIC)
    }
}

fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    let length = (body.len() as u64).to_le_bytes();
    [&[opcode][..], &length, body].concat()
}
