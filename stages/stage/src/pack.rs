//! Answers to many items in one file, `cache/STAGE/KEY.pack`, that only grows.
//!
//! Layout, little-endian: a line that names the format; the key (32 bytes) of what all its answers have in common: a pack of other
//! settings under this name is none; then records: item key (32 bytes), length of the answer (u32),
//! SHA-256 of the answer (32), the first 8 bytes of the SHA-256 of what came before in the record, the answer. A record
//! whose head is not proved ends the file (a torn end, or damage: what follows is computed again); one whose answer is
//! not proved is passed over.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufReader, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use crate::StageError;
use crate::key::Key;

const FORMAT: &[u8] = b"carom pack 2\n";
/// Length of what comes before the records.
const OPENING: usize = FORMAT.len() + 32;
const HEAD: usize = 32 + 4 + 32;
const CHECK: usize = 8;

/// An item's key and the encoding of its answer.
pub(crate) type CachedAnswer = (Key, Vec<u8>);

/// A pack and its end: where the last proved record ends.
pub(crate) struct Pack {
    path: PathBuf,
    group: Key,
    end: u64,
}

impl Pack {
    /// Reads a pack, passing each proved answer to `visit`. Also returns whether damage was seen.
    pub fn open(
        path: PathBuf,
        group: Key,
        visit: impl FnMut(Key, &[u8]),
    ) -> Result<(Self, bool), StageError> {
        match File::open(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => Ok((
                Self {
                    path,
                    group,
                    end: 0,
                },
                false,
            )),
            Err(error) => Err(durable::Error::new("read", &path, error).into()),
            Ok(file) => {
                let (end, damaged) = scan(file, group, visit)
                    .map_err(|source| durable::Error::new("read", &path, source))?;
                Ok((Self { path, group, end }, damaged))
            }
        }
    }

    /// Where the pack lies.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What all its answers have in common.
    pub fn group(&self) -> Key {
        self.group
    }

    /// Keeps answers, in this order, and syncs them.
    pub fn append(&mut self, answers: &[CachedAnswer]) -> Result<(), StageError> {
        let opening = [FORMAT, &self.group.0].concat();
        let mut bytes = if self.end == 0 { opening } else { Vec::new() };
        put(&mut bytes, answers);
        durable::append(&self.path, self.end, &bytes)?;
        self.end += bytes.len() as u64;
        Ok(())
    }

    /// Where several workers put their answers, each block in a pack of its own, until a run takes them in.
    pub fn parts(&self) -> PathBuf {
        self.path.with_extension("parts")
    }

    /// Takes in what workers left ([`write_part`]), passing each proved answer to `visit`.
    pub fn absorb(&mut self, mut visit: impl FnMut(Key, &[u8])) -> Result<(), StageError> {
        let folder = self.parts();
        let failed = |source| durable::Error::new("read", &folder, source);
        let entries = match fs::read_dir(&folder) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
            entries => entries.map_err(failed)?,
        };
        // In an order of their own, whoever wrote them.
        let mut taken = BTreeMap::new();
        for entry in entries {
            let path = entry.map_err(failed)?.path();
            Self::open(path, self.group, |key, bytes| {
                taken.insert(key, bytes.to_vec());
            })?;
        }
        // A run that was killed in between took them in before.
        Self::open(self.path.clone(), self.group, |key, _| {
            taken.remove(&key);
        })?;
        for (key, bytes) in &taken {
            visit(*key, bytes);
        }
        if !taken.is_empty() {
            self.append(&taken.into_iter().collect::<Vec<_>>())?;
        }
        Ok(durable::remove_dir(&folder)?)
    }
}

/// Writes a pack of these answers alone, whole or absent.
pub(crate) fn write_part(
    writer: &str,
    path: &Path,
    group: Key,
    answers: &[CachedAnswer],
) -> Result<(), StageError> {
    let mut bytes = [FORMAT, &group.0].concat();
    put(&mut bytes, answers);
    durable::write_as(writer, path, |file| {
        file.write_all(&bytes)
            .map_err(|source| durable::Error::new("write", path, source).into())
    })
}

fn put(bytes: &mut Vec<u8>, answers: &[CachedAnswer]) {
    for (key, answer) in answers {
        bytes.extend_from_slice(&head(*key, answer));
        bytes.extend_from_slice(answer);
    }
}

fn head(key: Key, answer: &[u8]) -> [u8; HEAD + CHECK] {
    let mut head = [0; HEAD + CHECK];
    let length = u32::try_from(answer.len()).expect("the answer to one item is shorter than 4 GB");
    head[..32].copy_from_slice(&key.0);
    head[32..36].copy_from_slice(&length.to_le_bytes());
    head[36..HEAD].copy_from_slice(&Key::of_bytes(&[answer]).0);
    let check = Key::of_bytes(&[&head[..HEAD]]).0;
    head[HEAD..].copy_from_slice(&check[..CHECK]);
    head
}

/// Where the last proved head's record ends, and whether anything was not proved.
fn scan(file: File, group: Key, mut visit: impl FnMut(Key, &[u8])) -> io::Result<(u64, bool)> {
    let length = file.metadata()?.len();
    let mut file = BufReader::with_capacity(1 << 20, file);
    let mut opening = [0; OPENING];
    if length < OPENING as u64 {
        return Ok((0, length > 0));
    }
    file.read_exact(&mut opening)?;
    if opening[..] != [FORMAT, &group.0].concat() {
        return Ok((0, true));
    }
    let mut end = OPENING as u64;
    let mut answer = Vec::new();
    let mut damaged = false;
    while length - end >= (HEAD + CHECK) as u64 {
        let mut head = [0; HEAD + CHECK];
        file.read_exact(&mut head)?;
        let proved = Key::of_bytes(&[&head[..HEAD]]).0[..CHECK] == head[HEAD..];
        let size = u64::from(u32::from_le_bytes([head[32], head[33], head[34], head[35]]));
        if !proved || length - end - ((HEAD + CHECK) as u64) < size {
            break;
        }
        answer.clear();
        (&mut file).take(size).read_to_end(&mut answer)?;
        if Key::of_bytes(&[&answer]).0 == head[36..HEAD] {
            let mut key = [0; 32];
            key.copy_from_slice(&head[..32]);
            visit(Key(key), &answer);
        } else {
            damaged = true;
        }
        end += (HEAD + CHECK) as u64 + size;
    }
    Ok((end, damaged || end < length))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn read(path: &Path) -> (BTreeMap<Key, Vec<u8>>, Pack, bool) {
        let mut found = BTreeMap::new();
        let (pack, damaged) = Pack::open(path.into(), Key::of_bytes(&[b"group"]), |key, answer| {
            found.insert(key, answer.to_vec());
        })
        .expect("reads");
        (found, pack, damaged)
    }

    fn answers(contents: &[Vec<u8>]) -> Vec<(Key, Vec<u8>)> {
        contents
            .iter()
            .enumerate()
            .map(|(i, content)| (Key::of_bytes(&[&[i as u8]]), content.clone()))
            .collect()
    }

    #[test]
    fn a_pack_of_other_settings_is_none() {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("a.pack");
        let (_, mut pack, _) = read(&path);
        pack.append(&answers(&[vec![1]])).expect("appends");
        let mut seen = 0;
        let other = Key::of_bytes(&[b"other"]);
        let (_, damaged) = Pack::open(path, other, |_, _| seen += 1).expect("reads");
        assert!(damaged && seen == 0);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn a_damaged_or_cut_pack_gives_only_true_answers_and_grows_again(
            contents in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..40), 1..6),
            place in any::<prop::sample::Index>(),
            flip in 1u8..,
            cut in any::<bool>(),
        ) {
            let dir = tempfile::tempdir().expect("folder");
            let path = dir.path().join("a.pack");
            let answers = answers(&contents);
            let (_, mut pack, _) = read(&path);
            pack.append(&answers).expect("appends");

            let mut bytes = fs::read(&path).expect("is there");
            let at = place.index(bytes.len());
            if cut { bytes.truncate(at) } else { bytes[at] ^= flip }
            fs::write(&path, &bytes).expect("writes");

            let truth: BTreeMap<_, _> = answers.iter().cloned().collect();
            let (found, mut pack, damaged) = read(&path);
            prop_assert!(found.iter().all(|(key, answer)| truth[key] == *answer));
            let missing: Vec<_> = answers.iter().filter(|(key, _)| !found.contains_key(key)).cloned().collect();
            prop_assert!(damaged || bytes.is_empty() || missing.is_empty() || cut);
            pack.append(&missing).expect("appends");
            prop_assert_eq!(read(&path).0, truth);
        }
    }
}
