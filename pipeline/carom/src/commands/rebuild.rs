//! `carom rebuild`: a version computed again from the inputs that it records, and compared byte by byte.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use ingest::LogFile;
use serde_json::json;
use stage::Run;
use store::{Artifact, SIGNATURE, Store};

use crate::args::Global;
use crate::error::{Outcome, Output};
use crate::inputs::Inputs;
use crate::pipeline::{Step, pipeline};
use crate::publishing::{SPLIT_SEED, store_error};
use crate::steps::open;
use crate::tracking::tracked;
use crate::{Error, publishing};

/// `carom rebuild`.
#[derive(Args, Debug)]
pub struct RebuildArgs {
    /// Version to compute again.
    pub version: String,
    /// Folder of the run that published it.
    #[arg(long, value_name = "DIR")]
    pub artifacts: PathBuf,
}

/// Rebuilds in a folder of its own and compares.
pub fn run(args: &RebuildArgs, global: Global) -> Result<Output, Error> {
    let store = Store::open(&args.artifacts);
    let artifact = store.load(Some(&args.version)).map_err(store_error)?;
    if let Some(moved) = &artifact.manifest.provenance.moved {
        return Err(Error::input(format!(
            "rebuild {}: its worlds are those of {}, moved by {} strikes since the table changed; rebuild that one",
            artifact.version, moved.version, moved.strikes
        )));
    }
    let scratch = tempfile::tempdir().map_err(Error::failed)?;
    let run = open(scratch.path(), global)?;
    let inputs = recorded_inputs(&run, &args.artifacts, &artifact)?;
    let results = pipeline(&run, &inputs, Step::Publish)?;
    if results.read.check.is_meaningless() {
        return Err(Error::Refused(
            "rebuild it: by today's check a model of its logs is meaningless; `carom check` says why".into(),
        ));
    }
    let scratch = Store::open(scratch.path());
    let rebuilt = publishing::publish(&scratch, &results, false)?.unwrap_or_default();
    let again = scratch.version_dir(&rebuilt);
    let differing = compare(&store.version_dir(&args.version), &again)?;

    let version = &args.version;
    let json = json!({ "version": version, "same": differing.is_empty(), "differing": differing });
    Ok(if differing.is_empty() {
        let text = format!("{version} rebuilt: every byte is the same\n");
        Output::done(json, text)
    } else {
        let names = differing.join(", ");
        let text = format!("{version} rebuilt: other bytes in {names}\n");
        Output::ended(Outcome::Failed, json, text)
    })
}

/// The inputs that the version's manifest names: its rig, seed and whether effects were kept out, and of the logs that the run keeps those of its hashes.
fn recorded_inputs(run: &Run, dir: &Path, artifact: &Artifact) -> Result<Inputs, Error> {
    let recorded = &artifact.manifest.provenance;
    // Of logs with images, the logs with centroids that the run made, or the same made again.
    let kept = tracked(run, dir, &artifact.rig, &Inputs::kept(dir)?.logs)?;
    let kept: Vec<LogFile> = kept
        .logs
        .iter()
        .filter_map(|path| LogFile::open(path).ok())
        .collect();
    let find = |name: &str, sha256: &str| {
        let log = kept
            .iter()
            .find(|log| log.sha256 == sha256 && log.path.ends_with(name));
        log.map(|log| log.path.clone()).ok_or_else(|| {
            Error::input(format!(
                "find the log {name} (SHA-256 {sha256}) that {} was computed from: it is not among the logs of the run in {}; \
                 put it back where it was",
                artifact.version,
                dir.display()
            ))
        })
    };
    let logs = recorded
        .inputs
        .iter()
        .map(|input| find(&input.name, &input.sha256))
        .collect::<Result<Vec<_>, _>>()?;
    let seed = *recorded.seeds.get(SPLIT_SEED).ok_or_else(|| {
        Error::input(format!(
            "rebuild {}: its manifest names no seed `{SPLIT_SEED}`",
            artifact.version
        ))
    })?;
    Ok(Inputs {
        named: Vec::new(),
        rig: artifact.rig.clone(),
        logs,
        seed,
        without_effects: recorded.without_effects,
    })
}

/// Names of files that one folder lacks or that differ; signatures, which no rebuild can make, aside.
fn compare(before: &Path, again: &Path) -> Result<Vec<String>, Error> {
    let mut names = BTreeSet::new();
    for dir in [before, again] {
        for entry in fs::read_dir(dir).map_err(|error| Error::unreadable(dir, &error))? {
            let entry = entry.map_err(|error| Error::unreadable(dir, &error))?;
            names.insert(entry.file_name().to_string_lossy().into_owned());
        }
    }
    names.remove(SIGNATURE);
    let differs = |name: &String| match (fs::read(before.join(name)), fs::read(again.join(name))) {
        (Ok(before), Ok(again)) => before != again,
        _ => true,
    };
    Ok(names.into_iter().filter(differs).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_and_changed_files_are_named() {
        let dirs = [0, 1].map(|_| tempfile::tempdir().expect("folder"));
        for (dir, files) in dirs.iter().zip([
            [("a", "1"), ("b", "2"), ("c", "3")],
            [("a", "1"), ("b", "x"), ("d", "3")],
        ]) {
            for (name, text) in files {
                fs::write(dir.path().join(name), text).expect("file");
            }
        }
        let differing = compare(dirs[0].path(), dirs[1].path()).expect("compared");
        assert_eq!(differing, ["b", "c", "d"]);
    }
}
