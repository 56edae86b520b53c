//! A record's body, in memory or where it stands in the file.

use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};

/// Bytes before a record's body: its opcode and length.
pub(super) const PREFIX: usize = 9;
/// An unpacked chunk up to this size is held as a whole while its CRC is checked, and a record up to this size is read as a whole.
pub(super) const HELD: u64 = 8 << 20;

/// What can be read at any place.
pub(super) trait Source: Read + Seek {}

impl<S: Read + Seek> Source for S {}

/// A record's body: in memory, or where it stands in the file.
pub(super) enum Body<'a> {
    Held(&'a [u8]),
    InFile {
        source: &'a mut dyn Source,
        from: u64,
        length: u64,
    },
}

/// Bytes of a file that are read at once.
pub(super) const READ_SIZE: usize = 256 << 10;

impl Body<'_> {
    pub(super) fn length(&self) -> u64 {
        match self {
            Self::Held(bytes) => bytes.len() as u64,
            Self::InFile { length, .. } => *length,
        }
    }

    /// Its bytes from one of them on.
    pub(super) fn after(&mut self, at: u64) -> io::Result<Box<dyn BufRead + '_>> {
        Ok(match self {
            Self::Held(bytes) => Box::new(&bytes[(at as usize).min(bytes.len())..]),
            Self::InFile {
                source,
                from,
                length,
            } => {
                source.seek(SeekFrom::Start(*from + at))?;
                let rest = source.take(length.saturating_sub(at));
                Box::new(BufReader::with_capacity(READ_SIZE, rest))
            }
        })
    }
}
