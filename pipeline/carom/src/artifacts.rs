//! `carom artifacts`: a look into the store.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;

use serde_json::{Value, json};
use store::{Key, Manifest, Store};

use crate::Error;
use crate::commands::to_json;
use crate::publishing::store_error;
use crate::report::Provenance;
use crate::results::Results;

/// For machines, and for people.
type Told = Result<(Value, String), Error>;

/// All versions, oldest first.
pub fn list(dir: &Path) -> Told {
    if !dir.is_dir() {
        return Err(Error::input(format!(
            "list the versions in {}: there is no such folder; `--artifacts` names the folder of a run",
            dir.display()
        )));
    }
    let versions = Store::open(dir).list().map_err(store_error)?;
    let mut rows = Vec::new();
    let mut text = String::new();
    for listing in versions {
        let mark = if listing.is_latest { "latest" } else { "" };
        let said = match &listing.manifest {
            Ok(manifest) => describe(manifest),
            Err(error) => format!("failed to {error}"),
        };
        let line = format!("{:<8} {mark:<7} {said}", listing.version);
        let _ = writeln!(text, "{}", line.trim_end());
        rows.push(json!({
            "version": listing.version,
            "latest": listing.is_latest,
            "manifest": listing.manifest.as_ref().ok(),
            "error": listing.manifest.as_ref().err().map(ToString::to_string),
        }));
    }
    if rows.is_empty() {
        text = format!("no versions in {}\n", dir.display());
    }
    Ok((Value::Array(rows), text))
}

fn describe(manifest: &Manifest) -> String {
    let model = manifest.provenance.default_model;
    let logs = manifest.provenance.inputs.len();
    match manifest.provenance.metrics.get(&model) {
        Some(metrics) => format!(
            "{model:<15} {:.2} ± {:.2} cm on {} held-out strikes, from {logs} logs",
            metrics.mean * 100.0,
            metrics.sd * 100.0,
            metrics.n
        ),
        None => format!("{model:<15} not evaluated, from {logs} logs"),
    }
}

/// A version's manifest.
pub fn show(dir: &Path, version: Option<&str>) -> Told {
    let manifest = Store::open(dir).show(version).map_err(store_error)?;
    Ok((to_json(&manifest)?, manifest.to_json()))
}

/// Whether a version is whole, and signed by a key where one is given.
pub fn verify(dir: &Path, version: Option<&str>, key: Option<&Key>) -> Told {
    let store = Store::open(dir);
    let (artifact, sequence) = match key {
        Some(key) => store
            .load_trusted(version, key)
            .map(|(artifact, sequence)| (artifact, Some(sequence))),
        None => store.load(version).map(|artifact| (artifact, None)),
    }
    .map_err(store_error)?;
    let files = artifact.manifest.files.len();
    let mut text = format!(
        "{} is whole: {files} files with the hashes, shapes and versions that its manifest names\n",
        artifact.version
    );
    if let Some(sequence) = sequence {
        text += &format!("it is signed by the key, as number {sequence}\n");
    }
    Ok((
        json!({ "version": artifact.version, "files": files, "whole": true, "sequence": sequence }),
        text,
    ))
}

/// Signs the version in use.
pub fn sign(store: &Store) -> Told {
    let version = store.sign().map_err(store_error)?;
    let text = format!("{version} is signed\n");
    Ok((json!({ "version": version }), text))
}

/// Makes another version the latest.
pub fn rollback(store: &Store, version: Option<&str>) -> Told {
    let version = store.rollback(version).map_err(store_error)?;
    let text = format!("latest is {version}\n");
    Ok((json!({ "latest": version }), text))
}

/// Where a version of results comes from (the latest unless they name theirs); none where nothing is published. Of a version
/// that was computed from other logs there is its name alone: the results are not its.
pub fn provenance(dir: &Path, results: &Results) -> Result<Option<Provenance>, Error> {
    let store = Store::open(dir);
    let version = results.version.clone();
    let Some(version) = version.or_else(|| store.latest().ok()) else {
        return Ok(None);
    };
    let manifest = store.show(Some(&version)).map_err(store_error)?;
    let learnt_from: BTreeSet<&str> = manifest
        .provenance
        .inputs
        .iter()
        .map(|log| log.sha256.as_str())
        .collect();
    let shown: BTreeSet<&str> = results.logs.iter().map(|log| log.sha256.as_str()).collect();
    if learnt_from != shown {
        return Ok(Some(Provenance {
            in_use: Some(version),
            ..Provenance::default()
        }));
    }
    let files = manifest
        .files
        .iter()
        .map(|(name, file)| (name, &file.sha256));
    let logs = manifest
        .provenance
        .inputs
        .iter()
        .map(|log| (&log.name, &log.sha256));
    let hashes = files
        .chain(logs)
        .map(|(name, hash)| (name.clone(), hash.clone()))
        .collect();
    let mut made_by = vec![
        ("carom".to_string(), manifest.carom.clone()),
        ("MuJoCo".to_string(), manifest.mujoco.clone()),
        (
            "default model".to_string(),
            manifest.provenance.default_model.to_string(),
        ),
    ];
    let stages = manifest.provenance.stages.iter();
    made_by.extend(stages.map(|stage| {
        let name = format!("stage {}", stage.name);
        (name, format!("version {}", stage.version))
    }));
    Ok(Some(Provenance {
        version: Some(version),
        in_use: None,
        made_by,
        hashes,
    }))
}
