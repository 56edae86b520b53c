//! Whole answers: one file each, `cache/STAGE/KEY.answer`, that begins with the SHA-256 of its key and the answer: another key's
//! answer under this name is none.

use std::collections::HashSet;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use crate::StageError;
use crate::key::Key;

/// Answers, packs and folders of lists that no current input asks for: so many are kept for each stage, the newest.
const SPARE: usize = 8;

/// The cache's folder.
pub(crate) struct Answers {
    dir: PathBuf,
    /// A name that nobody else who writes here has; empty where nobody else does.
    writer: String,
    /// Files, and folders of lists, that this run wrote or used.
    used: Mutex<HashSet<PathBuf>>,
}

/// What the cache holds for a key.
pub(crate) enum Cached {
    Answer(Vec<u8>),
    Nothing,
    /// A file that its hash does not prove.
    Damaged,
}

impl Answers {
    /// The cache of one who is alone in it.
    pub fn open(dir: PathBuf) -> Result<Self, StageError> {
        durable::sweep(&dir)?;
        Ok(Self::beside_others(dir, String::new()))
    }

    /// The cache of one of several, by its name.
    pub fn beside_others(dir: PathBuf, writer: String) -> Self {
        Self {
            dir,
            writer,
            used: Mutex::default(),
        }
    }

    /// The name to write under ([`durable::write_as`]).
    pub fn writer(&self) -> &str {
        &self.writer
    }

    /// The place of a key, in its stage's folder, which is made.
    pub fn path(&self, stage: &str, key: Key, extension: &str) -> Result<PathBuf, StageError> {
        let folder = self.dir.join(stage);
        durable::create_dir(&folder)?;
        Ok(folder.join(format!("{key}.{extension}")))
    }

    pub fn load(&self, path: &Path, key: Key) -> Result<Cached, StageError> {
        let bytes = match fs::read(path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Cached::Nothing),
            Err(error) => return Err(durable::Error::new("read", path, error).into()),
        };
        match bytes.split_at_checked(32) {
            Some((hash, answer)) if hash == Key::of_bytes(&[&key.0, answer]).0 => {
                self.mark_used(path);
                Ok(Cached::Answer(answer.to_vec()))
            }
            _ => Ok(Cached::Damaged),
        }
    }

    pub fn store(&self, path: &Path, key: Key, answer: &[u8]) -> Result<(), StageError> {
        durable::write_as(&self.writer, path, |file| {
            use std::io::Write;
            file.write_all(&Key::of_bytes(&[&key.0, answer]).0)
                .and_then(|()| file.write_all(answer))
                .map_err(|source| durable::Error::new("write", path, source))
        })?;
        self.mark_used(path);
        Ok(())
    }

    pub fn mark_used(&self, path: &Path) {
        self.used
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .insert(path.into());
    }

    /// Removes the oldest of what this run did not use, where a stage's folder holds more than [`SPARE`] of it and nobody else works in it.
    pub fn prune(&self, stage: &str) -> Result<(), StageError> {
        if !self.writer.is_empty() {
            return Ok(());
        }
        let folder = self.dir.join(stage);
        let failed = |source| durable::Error::new("tidy", &folder, source);
        let used = self.used.lock().unwrap_or_else(PoisonError::into_inner);
        let mut spare = Vec::new();
        for entry in fs::read_dir(&folder).map_err(failed)? {
            let entry = entry.map_err(failed)?;
            if !used.contains(&entry.path()) {
                let written = entry
                    .metadata()
                    .and_then(|data| data.modified())
                    .unwrap_or(SystemTime::UNIX_EPOCH);
                spare.push((written, entry.path()));
            }
        }
        spare.sort();
        let surplus = spare.len().saturating_sub(SPARE);
        for (_, path) in &spare[..surplus] {
            if path.is_dir() {
                durable::remove_dir(path)?;
            } else {
                fs::remove_file(path)
                    .map_err(|source| durable::Error::new("remove", path, source))?;
            }
        }
        Ok(())
    }
}
