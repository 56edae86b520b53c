//! Logs to strikes: the pipeline's first step, and what a score begins with.

use std::path::PathBuf;

use ingest::{Ingest, IngestError, LogFile, Strikes};
use rayon::iter::Either;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use stage::{Run, RunError};
use values::{Reject, Rig};

use crate::{Error, summary};

/// What the logs held.
pub struct Read {
    /// Strikes kept, in order of time.
    pub strikes: Strikes,
    /// Strikes seen and not kept.
    pub rejects: Vec<Reject>,
    /// The logs that were read, by name and hash.
    pub logs: Vec<LogFile>,
    /// The others.
    pub left_out: Vec<LeftOut>,
    /// Names of logs that are cut off or damaged.
    pub damaged: Vec<String>,
    /// What a person should know of the logs, each with the log's name.
    pub notes: Vec<String>,
}

/// A log of which nothing could be read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LeftOut {
    /// File name, without folder.
    pub log: String,
    /// Why; completes "failed to …".
    pub why: String,
}

/// Files that can be read, with their hashes, and those that cannot.
pub fn open(paths: &[PathBuf]) -> (Vec<LogFile>, Vec<LeftOut>) {
    let left_out = |path: &PathBuf, error: IngestError| LeftOut {
        log: path
            .file_name()
            .unwrap_or(path.as_os_str())
            .to_string_lossy()
            .into_owned(),
        why: error.to_string(),
    };
    paths
        .par_iter()
        .partition_map(|path| match LogFile::open(path) {
            Ok(log) => Either::Left(log),
            Err(error) => Either::Right(left_out(path, error)),
        })
}

/// Reads the logs; each is read once, until its content changes. One that cannot be is left out, if another can.
pub fn read(run: &Run, rig: &Rig, logs: &[PathBuf], seed: u64) -> Result<Read, Error> {
    let (mut logs, mut left_out) = open(logs);
    let mut read = run
        .lists(&Ingest { seed }, rig, &logs)
        .map_err(|error| match error {
            RunError::Stage(error @ IngestError::Log(_)) => Error::input(error),
            error => error.into(),
        })?;
    for (outcome, _) in &read {
        let log = &outcome.log;
        left_out.extend(outcome.left_out.clone().map(|why| LeftOut {
            log: log.clone(),
            why,
        }));
    }
    let mut is_read = read.iter().map(|(outcome, _)| outcome.left_out.is_none());
    logs.retain(|_| is_read.next().unwrap_or(false));
    read.retain(|(outcome, _)| outcome.left_out.is_none());
    if let (true, Some(first)) = (logs.is_empty(), left_out.first()) {
        return Err(Error::input(first.why.clone()));
    }
    let notes = read.iter().flat_map(|(outcome, _)| {
        let note = |note| format!("{}: {note}", outcome.log);
        outcome.notes.iter().map(note)
    });
    let notes = left_out
        .iter()
        .map(LeftOut::sentence)
        .chain(notes)
        .collect();
    let damaged = read.iter().filter(|(outcome, _)| !outcome.whole);
    let damaged = damaged.map(|(outcome, _)| outcome.log.clone()).collect();
    let (strikes, rejects) = Strikes::join(read);
    if strikes.is_empty() {
        return Err(Error::input(format!(
            "find strikes: none was kept in {} logs ({}); check the topics and the table's bounds in the rig file",
            logs.len(),
            if rejects.is_empty() {
                "no command rises and falls".into()
            } else {
                let examples = summary::examples(&rejects).join("; ");
                format!("{}; {examples}", summary::reasons(&rejects))
            }
        )));
    }
    Ok(Read {
        strikes,
        rejects,
        logs,
        left_out,
        damaged,
        notes,
    })
}

impl LeftOut {
    /// For a person.
    pub fn sentence(&self) -> String {
        format!("{} is left out: failed to {}", self.log, self.why)
    }
}
