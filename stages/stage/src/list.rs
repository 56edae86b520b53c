//! Long answers: a file an item, `cache/STAGE/KEY.lists/ITEM.list`, written while its entries are found and read an entry
//! at a time.
//!
//! Layout, little-endian: a line that names the format; the key (32 bytes) of what the list answers; the entries and then
//! the answer to the whole, each as its length (u32) and its encoding; the SHA-256 of all that comes before.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, ErrorKind, Read, Seek, SeekFrom, Write};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use durable::Output;
use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

use crate::key::Key;
use crate::{ListStage, RunError, StageError, codec};

const FORMAT: &[u8] = b"carom list 2\n";
const HEAD: u64 = FORMAT.len() as u64 + 32;
const HASH: u64 = 32;
const LENGTH: u64 = 4;

/// The answer to one item: what holds for the list as a whole, and its entries.
pub type ListAnswer<S> = (<S as ListStage>::Output, Entries<<S as ListStage>::Entry>);

/// The entries of one list, which lie in the cache of the run that gave them.
#[derive(Clone, Debug)]
pub struct Entries<E> {
    stage: &'static str,
    path: PathBuf,
    /// Where each entry begins in the file.
    places: Vec<u64>,
    entry: PhantomData<fn() -> E>,
}

impl<E: DeserializeOwned> Entries<E> {
    /// Opens the list to read entries of it.
    pub fn open(&self) -> Result<Reader<'_, E>, StageError> {
        let file = File::open(&self.path).map_err(|error| unread(&self.path, error))?;
        Ok(Reader {
            entries: self,
            file: BufReader::new(file),
            at: 0,
            bytes: Vec::new(),
        })
    }
}

/// Reads the entries of one list, quickest in their order.
pub struct Reader<'a, E> {
    entries: &'a Entries<E>,
    file: BufReader<File>,
    at: u64,
    bytes: Vec<u8>,
}

impl<E: DeserializeOwned> Reader<'_, E> {
    /// The entry that was found as the `index`-th, from 0; an error where the list has no such entry.
    pub fn entry(&mut self, index: usize) -> Result<E, StageError> {
        let Entries { stage, path, .. } = self.entries;
        let place = self.entries.places.get(index).copied();
        place
            .ok_or_else(|| ErrorKind::UnexpectedEof.into())
            .and_then(|place| self.read(place))
            .map_err(|error| unread(path, error))?;
        codec::decode(&self.bytes, stage)
    }

    fn read(&mut self, place: u64) -> io::Result<()> {
        // Within the buffer where it can be.
        match i64::try_from(place).ok().zip(i64::try_from(self.at).ok()) {
            Some((to, from)) => self.file.seek_relative(to - from)?,
            None => drop(self.file.seek(SeekFrom::Start(place))?),
        }
        self.at = place + record(&mut self.file, &mut self.bytes)?;
        Ok(())
    }
}

/// Reads a record's encoding; gives the length of the record.
fn record(file: &mut impl Read, bytes: &mut Vec<u8>) -> io::Result<u64> {
    let mut length = [0; LENGTH as usize];
    file.read_exact(&mut length)?;
    let length = u64::from(u32::from_le_bytes(length));
    bytes.clear();
    if file.take(length).read_to_end(bytes)? as u64 == length {
        Ok(LENGTH + length)
    } else {
        Err(ErrorKind::UnexpectedEof.into())
    }
}

/// Where the list of an item lies, and the key that it must hold: another item's list in its place is none.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Place {
    path: PathBuf,
    key: Key,
}

impl Place {
    /// In the folder of the lists that have a stage, its settings and what is shared in common.
    pub fn of<S: ListStage>(folder: &Path, group: Key, item: &S::Item) -> Result<Self, StageError> {
        let item = Key::of_item(S::NAME, item)?;
        Ok(Self {
            path: folder.join(format!("{item}.list")),
            key: Key::of_bytes(&[&group.0, &item.0]),
        })
    }

    /// A name that the place of no other item has.
    pub fn name(&self) -> String {
        self.key.to_string()
    }
}

/// What the cache holds of an item.
pub(crate) enum Cached<S: ListStage> {
    List(S::Output, Entries<S::Entry>),
    Nothing,
    /// A file that its hash does not prove, of another item or of another type.
    Damaged,
}

/// Reads a list through once, to prove it.
pub(crate) fn load<S: ListStage>(place: &Place) -> Result<Cached<S>, StageError> {
    let Place { path, key } = place;
    let proved = match File::open(path).and_then(|file| prove(file, *key)) {
        Ok(proved) => proved,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Cached::Nothing),
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => None,
        Err(error) => return Err(unread(path, error)),
    };
    let Some((places, whole)) = proved else {
        return Ok(Cached::Damaged);
    };
    let entries = Entries {
        stage: S::NAME,
        path: path.into(),
        places,
        entry: PhantomData,
    };
    Ok(match codec::decode(&whole, S::NAME) {
        Ok(whole) => Cached::List(whole, entries),
        Err(_) => Cached::Damaged,
    })
}

pub(crate) fn written<S: ListStage>(place: &Place) -> Result<ListAnswer<S>, StageError> {
    match load::<S>(place)? {
        Cached::List(whole, entries) => Ok((whole, entries)),
        _ => Err(StageError::Decode {
            stage: S::NAME,
            why: format!("{} is not what was written", place.path.display()),
        }),
    }
}

/// Where each entry begins, and the encoding of the answer to the whole; none where the hash or the key is another.
fn prove(file: File, key: Key) -> io::Result<Option<(Vec<u64>, Vec<u8>)>> {
    let Some(end) = file.metadata()?.len().checked_sub(HASH) else {
        return Ok(None);
    };
    let mut file = Hashing {
        inner: BufReader::with_capacity(1 << 16, file),
        hash: Sha256::new(),
    };
    let mut format = [0; FORMAT.len()];
    file.read_exact(&mut format)?;
    let mut head = [0; 32];
    file.read_exact(&mut head)?;
    let (mut places, mut bytes) = (Vec::new(), Vec::new());
    let mut at = HEAD;
    while at < end {
        places.push(at);
        at += record(&mut file, &mut bytes)?;
    }
    let hash = file.hash.clone().finalize();
    let mut kept = [0; HASH as usize];
    file.read_exact(&mut kept)?;
    let is_proved = format == FORMAT && head == key.0 && at == end && hash[..] == kept;
    Ok(places.pop().filter(|_| is_proved).map(|_| (places, bytes)))
}

/// Computes a list into its file, which is whole or absent.
pub(crate) fn write<S: ListStage>(
    writer: &str,
    Place { path, key }: &Place,
    stage: &S,
    shared: &S::Shared,
    item: &S::Item,
) -> Result<(), RunError<S::Error>> {
    durable::write_as(writer, path, |file| {
        let mut writer = Writer {
            stage: S::NAME,
            path,
            file: Hashing {
                inner: file,
                hash: Sha256::new(),
            },
            bytes: Vec::new(),
        };
        writer.put(FORMAT)?;
        writer.put(&key.0)?;
        let mut put = Ok(());
        let whole = stage
            .run_item(shared, item, &mut |entry| {
                if put.is_ok() {
                    put = writer.record(&entry);
                }
            })
            .map_err(RunError::Stage)?;
        put.and_then(|()| writer.record(&whole))
            .and_then(|()| writer.finish())
            .map_err(RunError::Store)
    })
}

struct Writer<'a> {
    stage: &'static str,
    path: &'a Path,
    file: Hashing<&'a mut BufWriter<Output>>,
    bytes: Vec<u8>,
}

impl Writer<'_> {
    fn put(&mut self, bytes: &[u8]) -> Result<(), StageError> {
        let failed = |source| durable::Error::new("write", self.path, source);
        Ok(self.file.write_all(bytes).map_err(failed)?)
    }

    fn record<T: Serialize>(&mut self, value: &T) -> Result<(), StageError> {
        let mut bytes = std::mem::take(&mut self.bytes);
        bytes.clear();
        codec::encode_into(&mut bytes, value, self.stage, "the output")?;
        let length = u32::try_from(bytes.len()).expect("a record is shorter than 4 GB");
        self.put(&length.to_le_bytes())?;
        self.put(&bytes)?;
        self.bytes = bytes;
        Ok(())
    }

    fn finish(mut self) -> Result<(), StageError> {
        let hash = self.file.hash.clone().finalize();
        self.put(&hash)
    }
}

/// Hashes what passes through.
struct Hashing<F> {
    inner: F,
    hash: Sha256,
}

impl<F: Read> Read for Hashing<F> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.inner.read(bytes)?;
        self.hash.update(&bytes[..read]);
        Ok(read)
    }
}

impl<F: Write> Write for Hashing<F> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.hash.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

fn unread(path: &Path, source: io::Error) -> StageError {
    durable::Error::new("read", path, source).into()
}
