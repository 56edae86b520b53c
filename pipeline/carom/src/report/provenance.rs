//! Where a version comes from: what it was made from and by, with hashes.

use std::collections::BTreeSet;
use std::path::Path;

use store::Store;

use crate::Error;
use crate::publishing::store_error;
use crate::results::Results;

/// What a version was made from and holds, for a person: name and hash.
#[derive(Clone, Debug, Default)]
pub struct Provenance {
    /// Version; none where nothing is published.
    pub version: Option<String>,
    /// Whether that is no more than a candidate, or was taken back.
    pub is_unused: bool,
    /// The version in use, where that is not what is shown.
    pub in_use: Option<String>,
    /// Programs and their versions, seeds.
    pub made_by: Vec<(String, String)>,
    /// Files and their hashes.
    pub hashes: Vec<(String, String)>,
}

/// Where a version of results comes from (the latest unless it is named, or the newest candidate); none where nothing is published. Of a version
/// that was computed from other logs there is its name alone: the results are not its.
pub fn provenance(
    dir: &Path,
    results: &Results,
    version: Option<&str>,
) -> Result<Option<Provenance>, Error> {
    let store = Store::open(dir);
    let latest = store.latest().ok();
    let newest = || Some(store.list().ok()?.pop()?.version);
    let version = version.map(String::from).or_else(|| latest.clone());
    let Some(version) = version.or_else(newest) else {
        return Ok(None);
    };
    let is_unused = latest.as_ref() != Some(&version);
    let manifest = store.show(Some(&version)).map_err(store_error)?;
    let inputs = &manifest.provenance.inputs;
    let learnt_from: BTreeSet<&str> = inputs.iter().map(|log| log.sha256.as_str()).collect();
    let shown = results.read.logs.iter().map(|log| log.sha256.as_str());
    if learnt_from != shown.collect() {
        return Ok(Some(Provenance {
            in_use: latest,
            ..Provenance::default()
        }));
    }
    let files = manifest
        .files
        .iter()
        .map(|(name, file)| (name, &file.sha256));
    let logs = inputs.iter().map(|log| (&log.name, &log.sha256));
    let hashes = files.chain(logs);
    let hashes = hashes
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
    for stage in &manifest.provenance.stages {
        let row = (
            format!("stage {}", stage.name),
            format!("version {}", stage.version),
        );
        // A stage that ran twice, with other settings, is the same stage.
        if !made_by.contains(&row) {
            made_by.push(row);
        }
    }
    Ok(Some(Provenance {
        version: Some(version),
        is_unused,
        in_use: None,
        made_by,
        hashes,
    }))
}
