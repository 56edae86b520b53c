//! A log that is ingested, and what came out of it.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use values::{Reject, Sentence, Strike};

use crate::caught::Braking;
use crate::error::IngestError;
use crate::identity::places_id;
use crate::notes::Note;
use crate::rejection::Detail;
use crate::seen::Seen;

/// A log to ingest: known by its name and content, wherever it lies.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LogFile {
    /// The log's name in every table: the file's, without folder unless another log of the run is called the same.
    pub name: String,
    /// SHA-256 of its bytes, in hex.
    pub sha256: String,
    /// Where it lies; no part of what it is.
    #[serde(skip)]
    pub path: PathBuf,
}

impl LogFile {
    /// Hashes a log's content; its name is the file's.
    pub fn open(path: &Path) -> Result<Self, IngestError> {
        let name = file_name(path);
        let sha256 = logs::hash(path)?;
        Ok(Self {
            name,
            sha256,
            path: path.into(),
        })
    }

    /// Answers are kept by the content that was hashed before.
    pub(crate) fn check(
        &self,
        read: LogOutcome<StrikeSummary>,
    ) -> Result<LogOutcome<StrikeSummary>, IngestError> {
        if read.sha256 == self.sha256 {
            Ok(read)
        } else {
            Err(self.changed())
        }
    }

    /// The error of a log that was written to while it was read: an answer must not be kept for what was hashed.
    pub(crate) fn changed(&self) -> IngestError {
        IngestError::Changed {
            log: self.path.display().to_string(),
        }
    }
}

/// What came out of one log; its strikes are held whole, or what distinguishes them from others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LogOutcome<S = Strike> {
    /// Name of the log.
    pub log: String,
    /// SHA-256 of its bytes, in hex.
    pub sha256: String,
    /// Messages in it, over all topics.
    pub messages: u64,
    /// Whether the file is whole: neither cut off nor damaged.
    pub whole: bool,
    /// Why nothing could be read of it, as what completes "failed to …"; none where it was read, be it in part.
    #[serde(default)]
    pub left_out: Option<String>,
    /// Strikes that were kept, by index; their order among all logs is not yet known.
    pub strikes: Vec<S>,
    /// Strikes that were rejected, by index.
    pub rejects: Vec<Reject<Sentence<Detail>>>,
    /// What a person should know of the log: damage, messages that could not be decoded, frames left out.
    pub notes: Vec<Sentence<Note>>,
    /// Commands and motions, whatever became of them.
    #[serde(default)]
    pub seen: Seen,
}

impl<S> LogOutcome<S> {
    /// A log of which nothing could be read.
    pub(crate) fn left_out(log: &LogFile, error: &IngestError) -> Self {
        Self {
            log: log.name.clone(),
            sha256: log.sha256.clone(),
            messages: 0,
            whole: false,
            left_out: Some(error.to_string()),
            strikes: Vec::new(),
            rejects: Vec::new(),
            notes: Vec::new(),
            seen: Seen::default(),
        }
    }

    /// This outcome with other strikes.
    pub(crate) fn with_strikes<T>(self, with: impl FnOnce(Vec<S>) -> Vec<T>) -> LogOutcome<T> {
        LogOutcome {
            log: self.log,
            sha256: self.sha256,
            messages: self.messages,
            whole: self.whole,
            left_out: self.left_out,
            strikes: with(self.strikes),
            rejects: self.rejects,
            notes: self.notes,
            seen: self.seen,
        }
    }
}

/// What identifies a strike of a log among others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StrikeSummary {
    /// Hash of what was measured, as the strike's.
    pub id: String,
    /// Its index among the strikes seen in the log, from 0.
    pub index: u32,
    /// Stamp of first motion, in s.
    pub t_start: f64,
    /// Frames of its track.
    pub frames: usize,
    /// Hash of its command and its places without their stamps, where no other strike has it by chance.
    pub places: Option<String>,
    /// How the object was braked to its stop, where it came to one.
    pub braking: Option<Braking>,
}

impl From<&Strike> for StrikeSummary {
    fn from(strike: &Strike) -> Self {
        Self {
            id: strike.id.clone(),
            index: strike.index,
            t_start: strike.t_start,
            frames: strike.track.len(),
            places: places_id(strike),
            braking: Braking::of(strike),
        }
    }
}

/// A file's name, without folder.
pub(crate) fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}
