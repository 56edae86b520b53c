//! Datasets with a version: a recipe names logs; its lock pins each by SHA-256 and records the hash of every table.
//!
//! Logs are known by their content once they are pinned: they may be renamed, copied, named in any order or lie elsewhere.

mod lerobot;
mod lock;
mod recipe;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use ingest::{Ingest, LogFile, LogOutcome, assemble, ingest_log};
use rayon::prelude::*;
use values::{Reject, Rig, Strike};

use crate::Error;

pub use lerobot::{MOST_FPS, all_turn, episode, usual_fps};
pub use lock::{Lock, PinnedLog, pin};
pub use recipe::Recipe;

/// Files of a dataset, beside its lock.
pub const FILES: [&str; 4] = [
    "rejects.parquet",
    "rig.toml",
    "strikes.parquet",
    "tracks.parquet",
];

/// What the tables hold.
pub struct Rows {
    pub strikes: Vec<Strike>,
    pub rejects: Vec<Reject>,
    /// Strikes that the filters left out.
    pub filtered: usize,
    /// Whether nothing was rejected, and no log damaged.
    pub is_clean: bool,
}

impl Rows {
    /// Reads the pinned logs, each under the name that it was pinned by.
    pub fn read(rig: &Rig, lock: &Lock, found: &[LogFile]) -> Result<Self, Error> {
        let settings = Ingest { seed: lock.seed };
        let read = |(pinned, path): &(PinnedLog, PathBuf)| {
            let outcome = ingest_log(path, rig, &settings).map_err(Error::input)?;
            if outcome.sha256 == pinned.sha256 {
                Ok(named(outcome, &pinned.name))
            } else {
                Err(Error::input(format!(
                    "read {}: it changes while it is read; lock when its recording has ended",
                    path.display()
                )))
            }
        };
        let located = lock.locate(found)?;
        let mut outcomes: Vec<LogOutcome> =
            located.par_iter().map(read).collect::<Result<_, Error>>()?;
        let all_whole = outcomes.iter().all(|outcome| outcome.whole);
        outcomes.retain(|outcome| outcome.whole || !lock.filters.whole_logs);
        let (mut strikes, rejects) = assemble(outcomes);
        let before = strikes.len();
        strikes.retain(|strike| lock.filters.keeps(strike));
        Ok(Self {
            filtered: before - strikes.len(),
            is_clean: all_whole && rejects.is_empty(),
            strikes,
            rejects,
        })
    }

    /// Writes the files of the dataset; gives the hash of each.
    pub fn write(&self, rig: &Rig, dir: &Path) -> Result<BTreeMap<String, String>, Error> {
        tables::write_strikes(dir, &self.strikes).map_err(Error::failed)?;
        tables::write_rejects(dir, &self.rejects).map_err(Error::failed)?;
        durable::write_bytes(&dir.join("rig.toml"), rig.to_toml().as_bytes())?;
        hashes(dir)
    }
}

/// An outcome as if its log had this name.
fn named(mut outcome: LogOutcome, name: &str) -> LogOutcome {
    for strike in &mut outcome.strikes {
        strike.log = name.into();
        strike.conditions.session = name.into();
    }
    for reject in &mut outcome.rejects {
        reject.log = name.into();
    }
    outcome.log = name.into();
    outcome
}

/// SHA-256 of each file of a dataset; files that are not there are left out.
pub fn hashes(dir: &Path) -> Result<BTreeMap<String, String>, Error> {
    let mut hashes = BTreeMap::new();
    for name in FILES {
        let path = dir.join(name);
        if path.exists() {
            let bytes = fs::read(&path).map_err(|error| Error::unreadable(&path, &error))?;
            hashes.insert(name.to_string(), durable::sha256(&bytes));
        }
    }
    Ok(hashes)
}
