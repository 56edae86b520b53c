//! What workers say of their work, each in a file of its own, `cache/work/workers/NAME.jsonl`: a line an event.

use std::fs::{self, File, TryLockError};
use std::io::ErrorKind;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use crate::StageError;

/// Folder, in a run's cache, of what workers need while they work.
pub(crate) const FOLDER: &str = "work";
pub(crate) const LOGS: &str = "workers";

/// What a worker did.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Event {
    /// The worker began.
    Began {
        /// Name of its machine.
        host: String,
        /// Number of its process there.
        process: u32,
        /// Its share's number, from 0, and the number of shares.
        shard: [usize; 2],
    },
    /// The worker came to a stage.
    Found {
        /// The stage.
        stage: String,
        /// What all its jobs have in common.
        group: String,
        /// Number of jobs.
        jobs: usize,
        /// Number of jobs without an answer.
        missing: usize,
    },
    /// The worker began a job.
    Took {
        /// The stage.
        stage: String,
    },
    /// The worker waits for jobs that other workers compute.
    Waits {
        /// The stage.
        stage: String,
    },
    /// The worker answered a job.
    Done {
        /// The stage.
        stage: String,
        /// What all its jobs have in common.
        group: String,
        /// The job's name.
        job: String,
        /// Items that it answers.
        items: usize,
        /// Time that it took, in s.
        seconds: f64,
    },
    /// The worker gave up.
    Failed {
        /// Why; completes "failed to …".
        why: String,
    },
    /// Every answer is there.
    Ended,
}

/// An event and when it was.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Time since 1970, in s, by the worker's clock.
    pub at: f64,
    /// What happened.
    #[serde(flatten)]
    pub event: Event,
}

impl Line {
    pub(crate) fn now(event: Event) -> Self {
        let at = SystemTime::now().duration_since(UNIX_EPOCH);
        Self {
            at: at.map_or(0.0, |at| at.as_secs_f64()),
            event,
        }
    }

    pub(crate) fn to_json(&self) -> String {
        serde_json::to_string(self).expect("plain data") + "\n"
    }
}

/// What is known of a worker from its file alone.
#[derive(Clone, Debug, PartialEq)]
pub struct WorkerSeen {
    /// Its name: machine, process, number.
    pub name: String,
    /// Whether its process lives.
    pub is_alive: bool,
    /// What it did, in order.
    pub lines: Vec<Line>,
}

/// The workers of a run's folder since its last run began, by name; none where no worker was there.
pub fn workers(dir: &Path) -> Result<Vec<WorkerSeen>, StageError> {
    let folder = dir.join("cache").join(FOLDER).join(LOGS);
    let failed = |source| durable::Error::new("read", &folder, source);
    let entries = match fs::read_dir(&folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(failed)?,
    };
    let mut seen = Vec::new();
    for entry in entries {
        let path = entry.map_err(failed)?.path();
        // A run that begins removes them.
        let Ok(file) = File::open(&path) else {
            continue;
        };
        let is_alive = matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock));
        drop(file);
        let text = fs::read(&path).unwrap_or_default();
        let text = String::from_utf8_lossy(&text);
        // The last line of one that was killed may be torn.
        let lines = text
            .lines()
            .filter_map(|line| serde_json::from_str(line).ok());
        seen.push(WorkerSeen {
            name: path
                .file_stem()
                .unwrap_or_default()
                .to_string_lossy()
                .into(),
            is_alive,
            lines: lines.collect(),
        });
    }
    seen.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(seen)
}
