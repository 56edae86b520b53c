//! The records of a file, one after another, and how it ends. A chunk that is large is given where it stands.

use std::io::{Read, Seek, SeekFrom};

use mcap::McapError;
use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use sha2::{Digest, Sha256};

use super::body::{Body, HELD, PREFIX, READ_SIZE};
use crate::LogError;

/// Opcodes up to this one are defined by the format.
const LAST_OPCODE: u8 = op::DATA_END;
/// Opcodes from this one on are anyone's own.
const FIRST_PRIVATE: u8 = 0x80;

pub(super) enum Ending {
    /// With all that the format asks for.
    Whole,
    /// The messages are whole, what follows them is not.
    Index { offset: u64, why: String },
    /// The messages' CRC, which ends here, is wrong.
    DataCrc { offset: u64 },
    /// In the middle of its data; the record that is cut begins at `offset`.
    Cut { offset: u64 },
    /// From here on it makes no sense.
    Broken { offset: u64, why: String },
}

/// Called with the offset, opcode and body of a record.
pub(super) type EachRecord<'a, E> = &'a mut dyn FnMut(u64, u8, Body<'_>) -> Result<(), E>;

/// A file's records, streamed, and the hash of its bytes.
pub(super) struct Records<'a, R> {
    log: &'a str,
    source: R,
    size: u64,
    /// Bytes read and hashed so far.
    taken: u64,
    hasher: Sha256,
    limit: usize,
}

impl<'a, R: Read + Seek> Records<'a, R> {
    /// Records of at most this many bytes each.
    pub(super) fn new(log: &'a str, mut source: R, limit: usize) -> Result<Self, LogError> {
        let io = |source| LogError::io(log, source);
        let size = source.seek(SeekFrom::End(0)).map_err(io)?;
        source.seek(SeekFrom::Start(0)).map_err(io)?;
        Ok(Self {
            log,
            source,
            size,
            taken: 0,
            hasher: Sha256::new(),
            limit,
        })
    }

    /// Calls `each` with the offset, opcode and body of every record up to the end of the data.
    pub(super) fn each<E: From<LogError>>(&mut self, each: EachRecord<'_, E>) -> Result<Ending, E> {
        let mut reader = LinearReader::new_with_options(self.options(true));
        let mut at = 0;
        let start = mcap::MAGIC.len() as u64;
        let mut in_data = true;
        let mut crc = crc32fast::Hasher::new();
        crc.update(mcap::MAGIC);
        loop {
            match reader.next_event() {
                None => return Ok(Ending::Whole),
                Some(Ok(LinearReadEvent::ReadRequest(need))) => {
                    if self.size == 0 {
                        return Err(E::from(LogError::Empty {
                            log: self.log.into(),
                        }));
                    }
                    if self.taken == 0 && self.size < mcap::MAGIC.len() as u64 {
                        return Err(self.not_mcap().into());
                    }
                    self.feed(&mut reader, need)?;
                }
                Some(Ok(LinearReadEvent::Record { opcode, data })) => {
                    at = at.max(start);
                    if opcode == op::DATA_END {
                        in_data = false;
                        let saved = data.first_chunk::<4>().copied().map(u32::from_le_bytes);
                        let saved = saved.filter(|saved| *saved != 0);
                        if saved.is_some_and(|saved| saved != crc.clone().finalize()) {
                            return Ok(Ending::DataCrc { offset: at });
                        }
                    }
                    if in_data {
                        crc.update(&[opcode]);
                        crc.update(&(data.len() as u64).to_le_bytes());
                        crc.update(data);
                        each(at, opcode, Body::Held(data))?;
                    }
                    at += (PREFIX + data.len()) as u64;
                }
                Some(Err(McapError::BadMagic)) if at == 0 => return Err(self.not_mcap().into()),
                Some(Err(McapError::RecordTooLarge { opcode, len })) if in_data => {
                    let offset = at.max(start);
                    let end = len
                        .checked_add(offset + PREFIX as u64)
                        .filter(|end| *end <= self.size);
                    let is_large = len > self.limit as u64;
                    let Some(end) = end else {
                        if !is_large {
                            return Ok(Ending::Cut { offset });
                        }
                        let why =
                            "a record says that it is longer than what is left of the file".into();
                        return Ok(Ending::Broken { offset, why });
                    };
                    if is_large && !may_be_skipped(opcode) {
                        let (log, limit) = (self.log.into(), self.limit as u64);
                        return Err(E::from(LogError::TooLarge {
                            log,
                            what: "record",
                            offset,
                            size: len,
                            limit,
                        }));
                    }
                    if opcode == op::CHUNK {
                        each(offset, opcode, self.in_file(offset, len))?;
                    } else if !may_be_skipped(opcode) {
                        let mut body = Vec::new();
                        self.read_at(offset + PREFIX as u64, len, &mut body)?;
                        each(offset, opcode, Body::Held(&body))?;
                    }
                    self.pass_over(offset, end, &mut crc)?;
                    reader = LinearReader::new_with_options(self.options(false));
                    at = end;
                }
                Some(Err(error)) => {
                    drop(reader);
                    return Ok(Self::ending(error, at.max(start), in_data));
                }
            }
        }
    }

    fn ending(error: McapError, offset: u64, in_data: bool) -> Ending {
        let why = match error {
            McapError::UnexpectedEof if in_data => return Ending::Cut { offset },
            McapError::UnexpectedEof => "the file ends within its index".into(),
            error => error.to_string(),
        };
        match in_data {
            true => Ending::Broken { offset, why },
            false => Ending::Index { offset, why },
        }
    }

    fn options(&self, from_start: bool) -> LinearReaderOptions {
        LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_record_length_limit(self.limit.min(HELD as usize))
            .with_skip_start_magic(!from_start)
    }

    /// Gives the reader what it needs, or as much as the file has left: a length that lies takes no memory.
    fn feed(&mut self, reader: &mut LinearReader, need: usize) -> Result<(), LogError> {
        let left = self.size - self.taken;
        let size = usize::try_from(left.min((READ_SIZE as u64).max(need as u64))).unwrap_or(need);
        let buffer = reader.insert(size);
        let read = self.source.read(buffer);
        let read = read.map_err(|source| LogError::io(self.log, source))?;
        self.hasher.update(&buffer[..read]);
        self.taken += read as u64;
        reader.notify_read(read);
        Ok(())
    }

    /// What is there of the record at `offset`, which is cut: its opcode and body.
    pub(super) fn cut(&mut self, offset: u64) -> Result<Option<(u8, Body<'_>)>, LogError> {
        let from = offset + PREFIX as u64;
        if from > self.size {
            return Ok(None);
        }
        let mut opcode = Vec::new();
        self.read_at(offset, 1, &mut opcode)?;
        let length = self.size - from;
        Ok(opcode
            .first()
            .map(|opcode| (*opcode, self.in_file(offset, length))))
    }

    /// The body, so long, of the record at `offset`.
    fn in_file(&mut self, offset: u64, length: u64) -> Body<'_> {
        Body::InFile {
            source: &mut self.source,
            from: offset + PREFIX as u64,
            length,
        }
    }

    fn read_at(&mut self, at: u64, length: u64, bytes: &mut Vec<u8>) -> Result<(), LogError> {
        let mut read = || {
            bytes.reserve_exact(usize::try_from(length).unwrap_or_default());
            self.source.seek(SeekFrom::Start(at))?;
            self.source.by_ref().take(length).read_to_end(bytes)
        };
        let read = read();
        read.map(drop).map_err(|source| self.io(source))
    }

    /// Reads a part of the file, up to which all was taken or which was read where it stands, and keeps nothing but its CRC.
    fn pass_over(
        &mut self,
        from: u64,
        end: u64,
        crc: &mut crc32fast::Hasher,
    ) -> Result<(), LogError> {
        let mut buffer = vec![0; 64 << 10];
        let mut at = from;
        let sought = self.source.seek(SeekFrom::Start(from));
        sought.map_err(|source| self.io(source))?;
        while at < end {
            let size = (end - at).min(buffer.len() as u64);
            let buffer = &mut buffer[..usize::try_from(size).unwrap_or_default()];
            let read = self.source.read(buffer);
            let read = read.map_err(|source| self.io(source))?;
            if read == 0 {
                break;
            }
            crc.update(&buffer[..read]);
            let hashed = usize::try_from(self.taken.saturating_sub(at)).unwrap_or(read);
            self.hasher.update(&buffer[hashed.min(read)..read]);
            at += read as u64;
            self.taken = self.taken.max(at);
        }
        Ok(())
    }

    /// SHA-256 of the whole file, in hex.
    pub(super) fn sha256(mut self) -> Result<String, LogError> {
        self.pass_over(self.taken, self.size, &mut crc32fast::Hasher::new())?;
        Ok(durable::hex(&self.hasher.finalize()))
    }

    fn not_mcap(&self) -> LogError {
        LogError::NotMcap {
            log: self.log.into(),
        }
    }

    fn io(&self, source: std::io::Error) -> LogError {
        LogError::io(self.log, source)
    }
}

/// Whether a record that is too large to hold can hold no message.
fn may_be_skipped(opcode: u8) -> bool {
    opcode >= FIRST_PRIVATE || (opcode > op::CHUNK && opcode <= LAST_OPCODE)
}
