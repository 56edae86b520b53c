//! What a folder holds of a collection: a log for each strike since it was last joined, and sessions that were.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use durable::{Aside, Lock};
use ingest::{Ingest, LogOutcome, ingest_log};
use logs::write::CopyWriter;
use logs::{Limits, LogError as ReadError};
use values::{Command, Point, RejectReason, Rig};

use super::error::CollectError;
use super::request::StrikeRequest;
use crate::CommandPlanner;
use crate::log::LogError;

/// The name of a joined log: `session_NNNNNN.mcap`.
pub const SESSION: &str = "session_";
const STRIKE: &str = "strike_";
const ENDING: &str = ".mcap";
const LOCK: &str = ".collect.lock";
/// How many times as far as predicted an object may slide, before any strike was made.
const UNKNOWN: f64 = 2.0;
/// Number of strikes from which an object's distance is estimated; and by how much more than the farthest of these the next one may.
const TELLING: usize = 3;
const BEYOND: f64 = 1.15;
/// What to mend where a camera's stamps are late.
const LATE: &str = "; set the clocks of camera and computer alike (NTP, PTP), or state frames.camera_delay, which `carom check` measures";
/// Differences in m/s and rad within which a strike is the one that was requested.
const SAME: f64 = 2e-3;

#[derive(Clone, Debug)]
struct CollectedStrike {
    id: String,
    from: Point,
    stop: Point,
    command: Command,
}

/// The folder, locked.
#[derive(Debug)]
pub(super) struct Collection {
    folder: PathBuf,
    made: Vec<CollectedStrike>,
    useless: usize,
    _lock: Lock,
}

impl Collection {
    pub(super) fn open(folder: &Path, rig: &Rig) -> Result<Self, CollectError> {
        durable::create_dir(folder)?;
        let lock = Lock::acquire(&folder.join(LOCK))?;
        // The folder is locked: what was begun there is nobody's any more.
        durable::sweep(folder)?;
        let mut collection = Self {
            folder: folder.into(),
            made: Vec::new(),
            useless: 0,
            _lock: lock,
        };
        for path in named(folder, SESSION)? {
            collection.add(ingest_log(&path, rig, &Ingest::default())?);
        }
        let joined: BTreeSet<String> = collection.made.iter().map(|made| made.id.clone()).collect();
        for path in named(folder, STRIKE)? {
            let outcome = ingest_log(&path, rig, &Ingest::default())?;
            let is_joined = !outcome.strikes.is_empty()
                && outcome
                    .strikes
                    .iter()
                    .all(|strike| joined.contains(&strike.id));
            if is_joined {
                // It was joined, and the program ended before it was removed.
                remove(&path)?;
            } else {
                collection.add(outcome);
            }
        }
        Ok(collection)
    }

    pub(super) fn len(&self) -> usize {
        self.made.len()
    }

    /// Number of strikes made, those that cannot be used included.
    pub(super) fn strikes_made(&self) -> usize {
        self.made.len() + self.useless
    }

    pub(super) fn made(&self) -> Vec<StrikeRequest> {
        let request = |made: &CollectedStrike| StrikeRequest {
            from: made.from,
            command: made.command,
        };
        self.made.iter().map(request).collect()
    }

    /// The requests that were not struck yet.
    pub(super) fn left_of(&self, requested: &[StrikeRequest]) -> Vec<StrikeRequest> {
        let mut made = self.made();
        let is_same = |a: &StrikeRequest, b: &StrikeRequest| {
            (a.command.speed - b.command.speed).abs() <= SAME
                && (a.command.angle - b.command.angle).abs() <= SAME
        };
        let is_left =
            |request: &&StrikeRequest| match made.iter().position(|made| is_same(made, request)) {
                Some(place) => {
                    made.swap_remove(place);
                    false
                }
                None => true,
            };
        requested.iter().filter(is_left).copied().collect()
    }

    /// How many times as far as foreseen the next object may slide: as the strikes made show.
    pub(super) fn farther(&self, planner: &CommandPlanner) -> f64 {
        let ratio = |made: &CollectedStrike| {
            let foreseen = planner
                .foreseen(made.from, made.command)?
                .distance(made.from);
            (foreseen > 0.0).then(|| made.stop.distance(made.from) / foreseen)
        };
        // The last ones show how it slides today; each takes milliseconds to foresee.
        let recent = self.made.iter().rev().take(10 * TELLING);
        let ratios: Vec<f64> = recent.filter_map(ratio).collect();
        if ratios.len() < TELLING {
            return UNKNOWN;
        }
        BEYOND * ratios.iter().copied().fold(0.0, f64::max)
    }

    /// Takes the log of a strike that was just made. Gives why it cannot be used, where it cannot.
    pub(super) fn take(
        &mut self,
        path: &Path,
        rig: &Rig,
    ) -> Result<Result<(), String>, CollectError> {
        let outcome = ingest_log(path, rig, &Ingest::default())?;
        let why = match (outcome.strikes.is_empty(), outcome.rejects.first()) {
            (false, _) => None,
            (true, Some(reject)) => {
                let mend = match reject.reason {
                    RejectReason::ClockSkew => LATE,
                    _ => "",
                };
                Some(format!("{}: {}{mend}", reject.reason.name(), reject.detail))
            }
            (true, None) => Some("its log shows no strike".into()),
        };
        let shows_nothing = outcome.strikes.is_empty() && outcome.rejects.is_empty();
        self.useless += usize::from(shows_nothing);
        self.add(outcome);
        Ok(why.map_or(Ok(()), Err))
    }

    fn add(&mut self, outcome: LogOutcome) {
        self.useless += outcome.rejects.len();
        self.made
            .extend(outcome.strikes.into_iter().map(|strike| CollectedStrike {
                id: strike.id,
                from: strike.initial,
                stop: strike.stop,
                command: strike.command,
            }));
    }

    /// Joins the logs of single strikes into a session's, and removes them once that is safe on the disk.
    pub(super) fn join(&self) -> Result<Option<PathBuf>, CollectError> {
        let strikes = named(&self.folder, STRIKE)?;
        if strikes.is_empty() {
            return Ok(None);
        }
        let mut aside = Aside::create(&self.folder, "session")?;
        aside.fill(|file| copy(&strikes, file))?;
        for number in 1u64.. {
            let path = self.folder.join(format!("{SESSION}{number:06}{ENDING}"));
            if aside.name(&path)? {
                strikes.iter().try_for_each(|path| remove(path))?;
                return Ok(Some(path));
            }
        }
        Ok(None)
    }
}

fn copy(
    strikes: &[PathBuf],
    file: &mut (impl std::io::Write + std::io::Seek),
) -> Result<(), CollectError> {
    let written = |error: logs::write::WriteError| CollectError::Log(LogError::Content(error));
    let mut writer = CopyWriter::new(file).map_err(written)?;
    for path in strikes {
        writer.next_log();
        for lineage in
            logs::write::lineages(path).map_err(|error| CollectError::Collected(error.into()))?
        {
            writer.lineage(&lineage).map_err(written)?;
        }
        logs::read::read_raw(path, Limits::default(), &mut |message| {
            writer.copy(&message).map_err(JoinError::Write)
        })
        .map_err(|error| match error {
            JoinError::Read(error) => CollectError::Collected(error.into()),
            JoinError::Write(error) => written(error),
        })?;
    }
    writer.finish().map(drop).map_err(written)
}

/// What can fail while one log is copied into another.
enum JoinError {
    Read(ReadError),
    Write(logs::write::WriteError),
}

impl From<ReadError> for JoinError {
    fn from(error: ReadError) -> Self {
        Self::Read(error)
    }
}

fn remove(path: &Path) -> Result<(), CollectError> {
    fs::remove_file(path).map_err(|source| durable::Error::new("remove", path, source).into())
}

/// The folder's logs whose names begin with `begins`, in the order of their names.
fn named(folder: &Path, begins: &str) -> Result<Vec<PathBuf>, CollectError> {
    let failed = |source| durable::Error::new("read", folder, source);
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(begins) && name.ends_with(ENDING) {
            paths.push(entry.path());
        }
    }
    paths.sort();
    Ok(paths)
}

#[cfg(test)]
mod tests {
    use values::Shape;

    use super::*;

    #[test]
    fn a_log_that_was_only_begun_is_removed_at_the_next_start() {
        let (folder, rig) = (
            tempfile::tempdir().expect("folder"),
            Rig::demo(Shape::Cylinder),
        );
        let begun = folder.path().join(".strike.1_0.partial");
        fs::write(&begun, "").expect("writes");
        Collection::open(folder.path(), &rig).expect("opens");
        assert!(!begun.exists());
    }
}
