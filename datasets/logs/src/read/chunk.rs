//! The records within a chunk. Its CRC, where it has one, is checked before the first of them is given.

use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::records::PREFIX;
use super::request::Limits;

/// What can be wrong with a chunk.
pub(super) enum ChunkFault<E> {
    /// Its bytes are not what they should be.
    Damaged(String),
    Compression(String),
    /// It takes too much memory to unpack.
    TooLarge {
        size: u64,
        limit: u64,
    },
    Ended(E),
}

/// Called with the opcode and body of a record, and whether a CRC covers it.
type EachRecord<'a, E> = &'a mut dyn FnMut(u8, &[u8], bool) -> Result<(), E>;

/// Calls `each` with the records of a chunk; of one that is not `whole`, with those that are there.
pub(super) fn each<E>(
    body: &[u8],
    whole: bool,
    limits: &Limits,
    each: EachRecord<'_, E>,
) -> Result<(), ChunkFault<E>> {
    let header = Header::parse(body)
        .ok_or_else(|| ChunkFault::Damaged("a chunk's header is not whole".into()))?;
    if whole && header.packed > header.records.len() as u64 {
        return Err(ChunkFault::Damaged(
            "a chunk says that it is longer than its record".into(),
        ));
    }
    if header.unpacked > limits.chunk as u64 {
        return Err(ChunkFault::TooLarge {
            size: header.unpacked,
            limit: limits.chunk as u64,
        });
    }
    match header.compression {
        "" => each_plain(&header, whole, each),
        "zstd" | "lz4" => {
            let both = header.packed.saturating_add(header.unpacked);
            if both > limits.open_chunk as u64 {
                return Err(ChunkFault::TooLarge {
                    size: both,
                    limit: limits.open_chunk as u64,
                });
            }
            each_packed(body, &header, whole, limits, each)
        }
        other => Err(ChunkFault::Compression(other.into())),
    }
}

/// A chunk's fields. Source: MCAP specification, Chunk (op=0x06).
struct Header<'a> {
    unpacked: u64,
    crc: u32,
    compression: &'a str,
    packed: u64,
    records: &'a [u8],
}

impl<'a> Header<'a> {
    fn parse(body: &'a [u8]) -> Option<Self> {
        let (_times, rest) = body.split_first_chunk::<16>()?;
        let (unpacked, rest) = rest.split_first_chunk::<8>()?;
        let (crc, rest) = rest.split_first_chunk::<4>()?;
        let (length, rest) = rest.split_first_chunk::<4>()?;
        let (compression, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        let (packed, records) = rest.split_first_chunk::<8>()?;
        Some(Self {
            unpacked: u64::from_le_bytes(*unpacked),
            crc: u32::from_le_bytes(*crc),
            compression: std::str::from_utf8(compression).ok()?,
            packed: u64::from_le_bytes(*packed),
            records,
        })
    }
}

/// Records that are not compressed stand in the chunk as they are.
fn each_plain<E>(
    header: &Header<'_>,
    whole: bool,
    each: EachRecord<'_, E>,
) -> Result<(), ChunkFault<E>> {
    let length = usize::try_from(header.packed)
        .unwrap_or(usize::MAX)
        .min(header.records.len());
    let mut rest = &header.records[..length];
    let checked = whole && header.crc != 0;
    if checked {
        let found = crc32fast::hash(rest);
        if found != header.crc {
            return Err(crc_mismatch(header.crc, found));
        }
    }
    while let Some((prefix, after)) = rest.split_first_chunk::<PREFIX>() {
        let [opcode, length @ ..] = *prefix;
        let length = usize::try_from(u64::from_le_bytes(length)).unwrap_or(usize::MAX);
        let Some((body, next)) = after.split_at_checked(length) else {
            break;
        };
        each(opcode, body, checked).map_err(ChunkFault::Ended)?;
        rest = next;
    }
    if rest.is_empty() {
        Ok(())
    } else {
        Err(ChunkFault::Damaged(
            "a record within a chunk says that it is longer than the chunk".into(),
        ))
    }
}

/// An unpacked chunk up to this size is held as a whole while its CRC is checked; a larger one is unpacked twice, a record at a time.
const HELD: u64 = 8 << 20;

/// Records that are compressed are unpacked by the mcap crate, fed with this chunk alone.
fn each_packed<E>(
    body: &[u8],
    header: &Header<'_>,
    whole: bool,
    limits: &Limits,
    each: EachRecord<'_, E>,
) -> Result<(), ChunkFault<E>> {
    let checked = whole && header.crc != 0;
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_record_length_limit(limits.chunk);
    let unpack = |options, each: EachRecord<'_, E>| unpack(body, header, whole, options, each);
    let is_held = header.unpacked <= HELD;
    if checked && !is_held {
        let options = options.clone().with_validate_chunk_crcs(true);
        unpack(options, &mut |_, _, _| Ok(()))?;
    }
    let options = options.with_prevalidate_chunk_crcs(checked && is_held);
    unpack(options, &mut |opcode, data, _| each(opcode, data, checked))
}

fn unpack<E>(
    body: &[u8],
    header: &Header<'_>,
    whole: bool,
    options: LinearReaderOptions,
    each: EachRecord<'_, E>,
) -> Result<(), ChunkFault<E>> {
    let mut reader = LinearReader::new_with_options(options);
    let header_length = body.len() - header.records.len();
    let length = if whole {
        body.len() as u64
    } else {
        header.packed.saturating_add(header_length as u64)
    };
    let mut prefix = [op::CHUNK; PREFIX];
    prefix[1..].copy_from_slice(&length.to_le_bytes());
    let mut parts = [&prefix[..], body].into_iter();
    let mut left: &[u8] = &[];
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(need)) => {
                if left.is_empty() {
                    left = parts.next().unwrap_or_default();
                }
                let (now, later) = left.split_at(need.min(left.len()));
                reader.insert(now.len()).copy_from_slice(now);
                reader.notify_read(now.len());
                left = later;
            }
            Ok(LinearReadEvent::Record { opcode, data }) => {
                each(opcode, data, false).map_err(ChunkFault::Ended)?;
            }
            Err(mcap::McapError::BadChunkCrc { saved, calculated }) => {
                return Err(crc_mismatch(saved, calculated));
            }
            Err(error) => {
                return Err(ChunkFault::Damaged(format!(
                    "a chunk cannot be unpacked: {error}"
                )));
            }
        }
    }
    Ok(())
}

fn crc_mismatch<E>(saved: u32, found: u32) -> ChunkFault<E> {
    ChunkFault::Damaged(format!(
        "a chunk's CRC is {found:08x} where {saved:08x} was written"
    ))
}
