//! `carom dataset`: logs pinned by hash, tables built from them, and the proof that they are the same bytes elsewhere.
//!
//! A recipe names logs; its lock, made at first sight, pins each by SHA-256 and records the hash of every table. Logs are known
//! by their content from then on: they may be renamed, copied, named in any order or lie elsewhere.

mod lock;
mod recipe;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use ingest::{Ingest, LogFile, LogOutcome, assemble, ingest_log};
use rayon::prelude::*;
use serde_json::json;
use sha2::{Digest, Sha256};
use values::{Reject, Rig, Strike};

use crate::Error;
use crate::args::{DatasetArgs, DatasetCommand};
use crate::commands::Said;
use crate::error::Outcome;
use crate::naming::tell_apart;
use lock::{Lock, Pinned, pin};
use recipe::Recipe;

/// Files of a dataset, beside its lock.
const FILES: [&str; 4] = [
    "rejects.parquet",
    "rig.toml",
    "strikes.parquet",
    "tracks.parquet",
];

/// Does what was asked.
pub fn dataset(command: &DatasetCommand) -> Result<Said, Error> {
    match command {
        DatasetCommand::Lock { dataset, again } => make_lock(dataset, *again),
        DatasetCommand::Build { dataset, out } => build(dataset, &folder(dataset, out.as_deref())),
        DatasetCommand::Verify { dataset, out } => {
            verify(dataset, &folder(dataset, out.as_deref()))
        }
    }
}

/// Where a dataset's tables lie: in a folder named as its recipe, unless told.
fn folder(args: &DatasetArgs, out: Option<&Path>) -> PathBuf {
    out.map_or_else(|| args.recipe.with_extension(""), Path::to_path_buf)
}

fn make_lock(args: &DatasetArgs, again: bool) -> Result<Said, Error> {
    let recipe = Recipe::load(&args.recipe)?;
    let (rig, found) = (recipe.rig()?, open_logs(&recipe, args)?);
    let before = if again {
        None
    } else {
        Lock::load(&args.recipe)?
    };
    let known = match &before {
        Some(before) => {
            before.locate(&found)?;
            before.log.clone()
        }
        None => Vec::new(),
    };
    // What was pinned keeps its name.
    let is_new = |log: &Pinned| known.iter().all(|known| known.sha256 != log.sha256);
    let mut logs = pin(&found, &recipe.filters);
    logs.retain(is_new);
    let new = logs.len();
    logs.extend(
        known
            .iter()
            .filter(|log| !recipe.filters.leave_out(Path::new(&log.name)))
            .cloned(),
    );
    logs.sort();

    let lock = Lock::new(
        hash(rig.to_toml().as_bytes()),
        recipe.seed,
        recipe.filters,
        logs,
    );
    let rows = Rows::read(&rig, &lock, &found)?;
    let scratch = tempfile::tempdir().map_err(Error::failed)?;
    let lock = Lock {
        files: rows.write(&rig, scratch.path())?,
        strikes: rows.strikes.len(),
        rejected: rows.rejects.len(),
        filtered: rows.filtered,
        ..lock
    };
    lock.save(&args.recipe)?;
    let path = Lock::path(&args.recipe);
    let text = format!(
        "{} logs pinned in {}, {new} of them new\n{}",
        lock.log.len(),
        path.display(),
        counts(&lock)
    );
    Ok(said(
        &lock,
        rows.is_clean,
        json!({ "lock": path, "new": new }),
        text,
    ))
}

fn build(args: &DatasetArgs, out: &Path) -> Result<Said, Error> {
    let (lock, rig, rows) = rebuild(args)?;
    let scratch = tempfile::tempdir().map_err(Error::failed)?;
    let differing = differing(&lock, &rows.write(&rig, scratch.path())?);
    if !differing.is_empty() {
        return Err(Error::failed(rebuilt_otherwise(&differing)));
    }
    rows.write(&rig, out)?;
    let text = format!("{} in {}\n", counts(&lock).trim_end(), out.display());
    Ok(said(&lock, rows.is_clean, json!({ "out": out }), text))
}

fn verify(args: &DatasetArgs, out: &Path) -> Result<Said, Error> {
    let (lock, rig, rows) = rebuild(args)?;
    let scratch = tempfile::tempdir().map_err(Error::failed)?;
    let rebuilt = differing(&lock, &rows.write(&rig, scratch.path())?);
    let mut built = Vec::new();
    if out.is_dir() {
        let names = differing(&lock, &hashes(out)?).into_iter();
        built.extend(names.map(|name| out.join(name).display().to_string()));
    }
    if !(rebuilt.is_empty() && built.is_empty()) {
        let why = if rebuilt.is_empty() {
            format!(
                "find the locked bytes in {}: the logs still give them, `carom dataset build {}` writes them again",
                built.join(", "),
                args.recipe.display()
            )
        } else {
            rebuilt_otherwise(&rebuilt)
        };
        let differing = [rebuilt, built].concat();
        let json = json!({ "same": false, "differing": differing });
        let text = format!("failed to {why}\n");
        return Ok(Said {
            outcome: Outcome::Failed,
            json,
            text,
        });
    }
    let text = format!("every byte is the same: {}", counts(&lock));
    Ok(said(
        &lock,
        true,
        json!({ "same": true, "differing": [] }),
        text,
    ))
}

/// The rows again, from the logs that are pinned.
fn rebuild(args: &DatasetArgs) -> Result<(Lock, Rig, Rows), Error> {
    let recipe = Recipe::load(&args.recipe)?;
    let rig = recipe.rig()?;
    let lock = Lock::load(&args.recipe)?.ok_or_else(|| {
        Error::input(format!(
            "find {}: the dataset was never locked; `carom dataset lock {}` pins its logs",
            Lock::path(&args.recipe).display(),
            args.recipe.display()
        ))
    })?;
    let is_same = lock.rig == hash(rig.to_toml().as_bytes())
        && lock.seed == recipe.seed
        && lock.filters == recipe.filters;
    if !is_same {
        return Err(Error::input(format!(
            "build {}: its rig, seed or filters are not those that were locked; `carom dataset lock` takes the new ones",
            args.recipe.display()
        )));
    }
    let rows = Rows::read(&rig, &lock, &open_logs(&recipe, args)?)?;
    Ok((lock, rig, rows))
}

fn open_logs(recipe: &Recipe, args: &DatasetArgs) -> Result<Vec<LogFile>, Error> {
    let paths = recipe.find_logs(&args.logs)?;
    let open = |path: &PathBuf| LogFile::open(path).map_err(Error::input);
    let mut logs: Vec<LogFile> = paths.par_iter().map(open).collect::<Result<_, _>>()?;
    tell_apart(&mut logs);
    Ok(logs)
}

/// What the tables hold.
struct Rows {
    strikes: Vec<Strike>,
    rejects: Vec<Reject>,
    filtered: usize,
    /// Whether nothing was rejected, and no log damaged.
    is_clean: bool,
}

impl Rows {
    /// Reads the pinned logs, each under the name that it was pinned by.
    fn read(rig: &Rig, lock: &Lock, found: &[LogFile]) -> Result<Self, Error> {
        let settings = Ingest { seed: lock.seed };
        let read = |(pinned, path): &(Pinned, PathBuf)| {
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
    fn write(&self, rig: &Rig, dir: &Path) -> Result<BTreeMap<String, String>, Error> {
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
fn hashes(dir: &Path) -> Result<BTreeMap<String, String>, Error> {
    let mut hashes = BTreeMap::new();
    for name in FILES {
        let path = dir.join(name);
        if path.exists() {
            let bytes = fs::read(&path).map_err(|error| Error::unreadable(&path, &error))?;
            hashes.insert(name.to_string(), hash(&bytes));
        }
    }
    Ok(hashes)
}

fn hash(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Files whose bytes are not those that the lock records.
fn differing(lock: &Lock, files: &BTreeMap<String, String>) -> Vec<String> {
    let differs = |name: &&str| files.get(*name) != lock.files.get(*name);
    let names = FILES.into_iter().filter(differs);
    names.map(String::from).collect()
}

fn rebuilt_otherwise(differing: &[String]) -> String {
    format!(
        "rebuild the dataset: other bytes in {}; use the carom that locked it, or lock it again",
        differing.join(", ")
    )
}

fn counts(lock: &Lock) -> String {
    format!(
        "{} strikes, {} rejected, {} left out by filters\n",
        lock.strikes, lock.rejected, lock.filtered
    )
}

fn said(lock: &Lock, is_clean: bool, more: serde_json::Value, text: String) -> Said {
    let mut json = json!({
        "logs": lock.log, "strikes": lock.strikes, "rejected": lock.rejected, "filtered": lock.filtered, "files": lock.files,
    });
    if let (Some(json), serde_json::Value::Object(more)) = (json.as_object_mut(), more) {
        json.extend(more);
    }
    Said {
        outcome: if is_clean {
            Outcome::Done
        } else {
            Outcome::Rejected
        },
        json,
        text,
    }
}
