//! The records within a chunk, one at a time. Its CRC, where it has one, is checked before the first of them is given: the chunk is read, or
//! unpacked, twice, so that none is held as a whole.

use std::io::{self, BufRead, Read};

use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::body::{Body, HELD, PREFIX};
use super::event::Limits;

/// What can be wrong with a chunk.
pub(super) enum ChunkFault<E> {
    /// Its bytes are not what they should be.
    Damaged(String),
    Compression(String),
    Io(io::Error),
    /// It takes too much memory to unpack.
    TooLarge {
        size: u64,
        limit: u64,
    },
    Ended(E),
}

impl<E> From<io::Error> for ChunkFault<E> {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// Called with the opcode and body of a record, and whether a CRC covers it.
type EachRecord<'a, E> = &'a mut dyn FnMut(u8, &[u8], bool) -> Result<(), E>;

/// Calls `each` with the records of a chunk; of one that is not `whole`, with those that are there.
pub(super) fn each<E>(
    body: &mut Body<'_>,
    whole: bool,
    limits: &Limits,
    each: EachRecord<'_, E>,
) -> Result<(), ChunkFault<E>> {
    let mut start = Vec::new();
    body.after(0)?
        .take(LONGEST_HEADER)
        .read_to_end(&mut start)?;
    let header = Header::parse(&start)
        .ok_or_else(|| ChunkFault::Damaged("a chunk's header is not whole".into()))?;
    if whole && header.packed > body.length() - header.length {
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
        "" => each_plain(body, &header, whole, each),
        "zstd" | "lz4" => each_packed(body, &header, whole, limits, each),
        other => Err(ChunkFault::Compression(other.into())),
    }
}

/// A header with a longer name of a compression is none.
const LONGEST_HEADER: u64 = 4096;

/// A chunk's fields. Source: MCAP specification, Chunk (op=0x06).
struct Header<'a> {
    unpacked: u64,
    crc: u32,
    compression: &'a str,
    packed: u64,
    /// Bytes before the records.
    length: u64,
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
            length: (body.len() - records.len()) as u64,
        })
    }
}

/// Records that are not compressed stand in the chunk as they are.
fn each_plain<E>(
    body: &mut Body<'_>,
    header: &Header<'_>,
    whole: bool,
    each: EachRecord<'_, E>,
) -> Result<(), ChunkFault<E>> {
    let mut left = header.packed.min(body.length() - header.length);
    let checked = whole && header.crc != 0;
    if checked {
        let found = crc_of(body.after(header.length)?.take(left))?;
        if found != header.crc {
            return Err(crc_mismatch(header.crc, found));
        }
    }
    let mut records = body.after(header.length)?.take(left);
    let mut record = Vec::new();
    while left >= PREFIX as u64 {
        let mut prefix = [0; PREFIX];
        records.read_exact(&mut prefix)?;
        let [opcode, length @ ..] = prefix;
        let length = u64::from_le_bytes(length);
        if length > left - PREFIX as u64 {
            break;
        }
        record.resize(length as usize, 0);
        records.read_exact(&mut record)?;
        each(opcode, &record, checked).map_err(ChunkFault::Ended)?;
        left -= PREFIX as u64 + length;
    }
    if left == 0 {
        Ok(())
    } else {
        Err(ChunkFault::Damaged(
            "a record within a chunk says that it is longer than the chunk".into(),
        ))
    }
}

fn crc_of(mut bytes: impl BufRead) -> io::Result<u32> {
    let mut hasher = crc32fast::Hasher::new();
    loop {
        let some = bytes.fill_buf()?;
        if some.is_empty() {
            return Ok(hasher.finalize());
        }
        hasher.update(some);
        let length = some.len();
        bytes.consume(length);
    }
}

/// Records that are compressed are unpacked by the mcap crate, fed with this chunk alone.
fn each_packed<E>(
    body: &mut Body<'_>,
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
    let mut unpack = |options, each: EachRecord<'_, E>| unpack(body, header, whole, options, each);
    let is_held = header.unpacked <= HELD;
    if checked && !is_held {
        let options = options.clone().with_validate_chunk_crcs(true);
        unpack(options, &mut |_, _, _| Ok(()))?;
    }
    let options = options.with_prevalidate_chunk_crcs(checked && is_held);
    unpack(options, &mut |opcode, data, _| each(opcode, data, checked))
}

fn unpack<E>(
    body: &mut Body<'_>,
    header: &Header<'_>,
    whole: bool,
    options: LinearReaderOptions,
    each: EachRecord<'_, E>,
) -> Result<(), ChunkFault<E>> {
    let mut reader = LinearReader::new_with_options(options);
    let length = if whole {
        body.length()
    } else {
        header.packed.saturating_add(header.length)
    };
    let mut prefix = [op::CHUNK; PREFIX];
    prefix[1..].copy_from_slice(&length.to_le_bytes());
    let mut left = PREFIX as u64 + body.length();
    let mut bytes = prefix.chain(body.after(0)?);
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(need)) => {
                let size = left.min(need as u64) as usize;
                let read = bytes.read(reader.insert(size))?;
                reader.notify_read(read);
                left -= read as u64;
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
