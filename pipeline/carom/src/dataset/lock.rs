//! A lock: what a dataset was made of, and what came out.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use ingest::LogFile;
use serde::{Deserialize, Serialize};

use super::recipe::Filters;
use crate::Error;

/// Version of the lock's layout.
const SCHEMA: u32 = 1;

const HEAD: &str = "\
# Written by `carom dataset lock`; belongs beside its recipe, under version control.
# rosbag2 writes no checksums by default: that a log is what it was is known from here alone.
";

/// `NAME.lock`, beside `NAME.toml`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lock {
    /// Version of this layout.
    pub schema: u32,
    /// SHA-256 of the rig's settings, comments and order aside.
    pub rig: String,
    /// The recipe's seed.
    pub seed: u64,
    pub strikes: usize,
    /// Strikes in `rejects.parquet`.
    pub rejected: usize,
    /// Strikes that the filters left out.
    pub filtered: usize,
    /// The recipe's filters.
    pub filters: Filters,
    /// SHA-256 of each file of the dataset.
    pub files: BTreeMap<String, String>,
    /// The logs, by name and hash.
    pub log: Vec<PinnedLog>,
}

/// A log as it was at first sight.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PinnedLog {
    /// File name at first sight, with folders where others were called the same: its name in the tables, however it is called
    /// later.
    pub name: String,
    /// SHA-256 of its bytes, in hex.
    pub sha256: String,
}

impl Lock {
    /// A lock of logs out of which nothing came yet.
    pub fn new(rig: String, seed: u64, filters: Filters, log: Vec<PinnedLog>) -> Self {
        Self {
            schema: SCHEMA,
            rig,
            seed,
            strikes: 0,
            rejected: 0,
            filtered: 0,
            filters,
            files: BTreeMap::new(),
            log,
        }
    }

    /// Where a recipe's lock lies.
    pub fn path(recipe: &Path) -> PathBuf {
        recipe.with_extension("lock")
    }

    /// The lock of a recipe; none where it was never locked.
    pub fn load(recipe: &Path) -> Result<Option<Self>, Error> {
        let path = Self::path(recipe);
        let text = match fs::read_to_string(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            text => text.map_err(|error| Error::unreadable(&path, &error))?,
        };
        let bad = |why: String| {
            Error::input(format!(
                "read the lock {}: {why}; take it from version control again",
                path.display()
            ))
        };
        let lock: Self = toml::from_str(&text).map_err(|error| bad(error.to_string()))?;
        if lock.schema == SCHEMA {
            Ok(Some(lock))
        } else {
            Err(bad(format!(
                "its layout is {}, this program knows {SCHEMA}",
                lock.schema
            )))
        }
    }

    /// Writes it beside its recipe.
    pub fn save(&self, recipe: &Path) -> Result<(), Error> {
        let text = toml::to_string(self).map_err(Error::failed)?;
        let text = format!("{HEAD}{text}");
        Ok(durable::write_bytes(&Self::path(recipe), text.as_bytes())?)
    }

    /// Each pinned log where it lies now, by its hash, whatever its name; an error names the first that was changed or is
    /// not there.
    pub fn locate(&self, found: &[LogFile]) -> Result<Vec<(PinnedLog, PathBuf)>, Error> {
        let locate = |pinned: &PinnedLog| {
            let same = found.iter().find(|log| log.sha256 == pinned.sha256);
            same.map(|log| (pinned.clone(), log.path.clone()))
                .ok_or_else(|| Self::lost(pinned, found))
        };
        self.log.iter().map(locate).collect()
    }

    fn lost(pinned: &PinnedLog, found: &[LogFile]) -> Error {
        let PinnedLog { name, sha256 } = pinned;
        Error::input(match found.iter().find(|log| log.path.ends_with(name)) {
            Some(log) => format!(
                "use the log {}: it is not what it was when it was pinned (SHA-256 {} instead of {sha256}); take it from a \
                 copy, or `carom dataset lock --again` if the change is meant",
                log.path.display(),
                log.sha256
            ),
            None => format!(
                "find the log {name} (SHA-256 {sha256}), which is pinned; name its folder with `--logs`, or `carom dataset \
                 lock --again` to go on without it"
            ),
        })
    }
}

/// The logs to pin: each content once, under the first of its names.
pub fn pin(found: &[LogFile], filters: &Filters) -> Vec<PinnedLog> {
    let mut logs: Vec<PinnedLog> = found
        .iter()
        .filter(|log| !filters.leave_out(&log.path))
        .map(|log| PinnedLog {
            name: log.name.clone(),
            sha256: log.sha256.clone(),
        })
        .collect();
    logs.sort();
    let mut seen = BTreeSet::new();
    logs.retain(|log| seen.insert(log.sha256.clone()));
    logs
}
