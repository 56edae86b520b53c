//! Logs to strikes: the pipeline's first step, and what a score begins with.

use std::path::PathBuf;

use ingest::{Ingest, IngestError, LogFile, assemble};
use rayon::prelude::*;
use stage::{Run, RunError};
use values::{Reject, Rig, Strike};

use crate::Error;

/// What the logs held.
pub struct Read {
    /// Strikes kept, in order of time.
    pub strikes: Vec<Strike>,
    /// Strikes seen and not kept.
    pub rejects: Vec<Reject>,
    /// The logs, by name and hash.
    pub logs: Vec<LogFile>,
    /// Names of logs that are cut off or damaged.
    pub damaged: Vec<String>,
    /// What a person should know of the logs, each with the log's name.
    pub notes: Vec<String>,
}

/// Reads the logs; each is read once, until its content changes.
pub fn read(run: &Run, rig: &Rig, logs: &[PathBuf], seed: u64) -> Result<Read, Error> {
    let logs = logs
        .par_iter()
        .map(|path| LogFile::open(path).map_err(Error::input))
        .collect::<Result<Vec<_>, _>>()?;
    let outcomes = run
        .items(&Ingest { seed }, rig, &logs)
        .map_err(|error| match error {
            RunError::Stage(error @ IngestError::Log(_)) => Error::input(error),
            error => error.into(),
        })?;
    let notes = outcomes.iter().flat_map(|outcome| {
        let note = |note| format!("{}: {note}", outcome.log);
        outcome.notes.iter().map(note)
    });
    let notes = notes.collect();
    let damaged = outcomes.iter().filter(|outcome| !outcome.whole);
    let damaged = damaged.map(|outcome| outcome.log.clone()).collect();
    let (strikes, rejects) = assemble(outcomes);
    if strikes.is_empty() {
        return Err(Error::input(format!(
            "find strikes: none was kept in {} logs ({}); check the topics and the table's bounds in the rig file",
            logs.len(),
            if rejects.is_empty() {
                "no command rises and falls".into()
            } else {
                crate::summary::reasons(&rejects)
            }
        )));
    }
    Ok(Read {
        strikes,
        rejects,
        logs,
        damaged,
        notes,
    })
}
