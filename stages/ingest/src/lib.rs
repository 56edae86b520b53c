//! From logs to strikes: what was commanded, where the object rested before and after, and how it slid in between.
//!
//! Contract, section 1. A strike is found from the command (module `command`), its rests and its slide from the centroids
//! around it (module `slide`); both come from the log as a stream, of which no more is held than the strikes in hand need.
//! Every command that rises and falls is a [`Strike`] or a [`Reject`] with a reason: nothing is dropped in silence.
//!
//! Each log is ingested on its own ([`Ingest`], a list stage): its strikes go to the cache while they are found. [`Strikes`]
//! then joins all logs, one row for a strike that several logs hold, in the order of time, and reads them one by one; what is
//! held of a strike is what tells it from others ([`Found`]). [`assemble`] does the same with logs that are held whole.

mod assemble;
mod command;
mod error;
mod identity;
mod log;
mod robust;
mod segment;
mod slide;
mod strikes;

use std::path::{Path, PathBuf};

use logs::LogError;
use serde::{Deserialize, Serialize};
use stage::ListStage;
use values::{Reject, Rig, Strike};

pub use assemble::assemble;
pub use error::IngestError;
pub use log::ingest_log;
pub use strikes::Strikes;

use log::read_log;

/// The stage and its settings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Ingest {
    /// Deals strikes into training, validation and test ([`values::split_of`]).
    pub seed: u64,
}

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
        let name = log::file_name(path);
        let sha256 = error::hash_file(path)?;
        Ok(Self {
            name,
            sha256,
            path: path.into(),
        })
    }

    /// Answers are kept by the content that was hashed before.
    fn check(&self, read: LogOutcome<Found>) -> Result<LogOutcome<Found>, IngestError> {
        if read.sha256 == self.sha256 {
            Ok(read)
        } else {
            Err(IngestError::Changed {
                log: self.path.display().to_string(),
            })
        }
    }
}

/// What came out of one log; its strikes are held whole, or what tells them from others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LogOutcome<S = Strike> {
    /// Its name.
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
    /// Strikes that were not, by index.
    pub rejects: Vec<Reject>,
    /// What a person should know of the log: damage, messages that could not be decoded, frames left out.
    pub notes: Vec<String>,
}

impl<S> LogOutcome<S> {
    /// A log of which nothing could be read.
    fn left_out(log: &LogFile, error: &IngestError) -> Self {
        Self {
            log: log.name.clone(),
            sha256: log.sha256.clone(),
            messages: 0,
            whole: false,
            left_out: Some(error.to_string()),
            strikes: Vec::new(),
            rejects: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// The same with other strikes.
    fn with_strikes<T>(self, with: impl FnOnce(Vec<S>) -> Vec<T>) -> LogOutcome<T> {
        LogOutcome {
            log: self.log,
            sha256: self.sha256,
            messages: self.messages,
            whole: self.whole,
            left_out: self.left_out,
            strikes: with(self.strikes),
            rejects: self.rejects,
            notes: self.notes,
        }
    }
}

/// What tells a strike of a log from others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// Hash of what was measured, as the strike's.
    pub id: String,
    /// Its place among the strikes seen in the log, from 0.
    pub index: u32,
    /// Stamp of first motion, in s.
    pub t_start: f64,
    /// Frames of its track.
    pub frames: usize,
}

impl From<&Strike> for Found {
    fn from(strike: &Strike) -> Self {
        Self {
            id: strike.id.clone(),
            index: strike.index,
            t_start: strike.t_start,
            frames: strike.track.len(),
        }
    }
}

impl ListStage for Ingest {
    const NAME: &'static str = "ingest";
    const VERSION: u32 = 7;
    type Shared = Rig;
    type Item = LogFile;
    type Entry = Strike;
    type Output = LogOutcome<Found>;
    type Error = IngestError;

    fn run_item(
        &self,
        rig: &Rig,
        log: &LogFile,
        keep: &mut dyn FnMut(Strike),
    ) -> Result<LogOutcome<Found>, IngestError> {
        let read = read_log(&log.path, &log.name, rig, self, keep);
        match read.and_then(|read| log.check(read)) {
            // A disk may do better the next time: that answer is not one to keep.
            Err(error @ IngestError::Log(LogError::Io { .. })) => Err(error),
            // One log that is none does not take the others with it.
            Err(error) => Ok(LogOutcome::left_out(log, &error)),
            read => read,
        }
    }
}
