//! `--recent` and `--adapt`: the table as its last strikes show it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use std::{fs, io};

use ingest::{IngestError, LogOutcome};
use logs::write::Lineage;
use serde::{Deserialize, Serialize};
use store::Artifact;
use strike::{Args, Planner, PlannerError, Reason, Recent, SESSION_GAP, tell};

use super::Failure;

/// Name of the file, beside the logs, that keeps what is known of the table.
const FILE: &str = "adapted.json";
/// Greatest number of logs read where nothing is kept: a table is known by its last strikes.
const MOST_LOGS: usize = 60;

/// Placeholder for the file's own hash while that is computed.
const UNSEALED: &str = "0000000000000000000000000000000000000000000000000000000000000000";

/// What is known of the table, and from which logs. It holds for one model of one version, and is computed anew from the logs where it
/// cannot be read or its hash is another.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    /// SHA-256 of the file's bytes with zeros in the place of these 64 hex digits.
    sha256: String,
    /// Hash of the version's manifest.
    manifest: String,
    model: String,
    /// Names of the logs that were followed or passed over, and hashes of those that were read.
    logs: BTreeMap<String, String>,
    recent: Recent,
}

pub fn by_logs(
    logs: &[PathBuf],
    artifact: &Artifact,
    planner: Planner,
) -> Result<Planner, Failure> {
    let outcomes: Result<Vec<_>, _> = logs.iter().map(|log| ingested(log, &planner)).collect();
    let (mut strikes, _) = ingest::assemble(outcomes.map_err(Failure::input)?);
    strikes.sort_by(|a, b| a.t_start.total_cmp(&b.t_start));
    if strikes.is_empty() {
        return Err(Failure::input(
            "follow the table: the recent logs hold no strike that can be used; `carom ingest` says why",
        ));
    }
    let mut recent = planner.recent();
    planner
        .follow(artifact, &mut recent, &strikes)
        .map_err(failure)?;
    Ok(planner.adapted(&recent, true))
}

/// Adapts a planner by the logs of the strikes that were made here since the version learnt.
pub fn by_own_strikes(
    args: &Args,
    artifact: &Artifact,
    planner: Planner,
) -> Result<Planner, Failure> {
    let folder = match &args.log {
        Some(file) => file.parent().unwrap_or(Path::new("")).to_path_buf(),
        None => args.artifacts.join("strikes"),
    };
    let all = logs(&folder).map_err(|error| {
        Failure::failed(format!("list the strikes in {}: {error}", folder.display()))
    })?;
    let manifest = &artifact.manifest.sha256;
    let model = args
        .model
        .unwrap_or(artifact.manifest.provenance.default_model)
        .to_string();
    let place = folder.join(FILE);
    let is_same = |kept: &Kept| kept.manifest == *manifest && kept.model == model;
    let mut kept = read(&place).filter(is_same).unwrap_or_else(|| {
        let passed_over = all.iter().take(all.len().saturating_sub(MOST_LOGS));
        Kept {
            sha256: UNSEALED.into(),
            manifest: manifest.clone(),
            model,
            logs: passed_over.map(|log| (name(log), String::new())).collect(),
            recent: planner.recent(),
        }
    });
    let is_new = |log: &&PathBuf| !kept.logs.contains_key(&name(log));
    let new: Vec<&PathBuf> = all.iter().filter(is_new).collect();
    let known = artifact.manifest.provenance.strikes;
    let known = known.map_or(f64::NEG_INFINITY, |known| known.last);
    let (mut outcomes, mut own) = (Vec::new(), BTreeSet::new());
    for log in &new {
        let mut sha256 = String::new();
        match ingested(log, &planner) {
            Ok(outcome) => {
                sha256.clone_from(&outcome.sha256);
                // A copy shows nothing new.
                if !kept.logs.values().any(|known| *known == sha256) {
                    outcomes.push(outcome);
                }
            }
            // What a robot wrote as it lost power must not stop every strike to come.
            Err(error) => tell(&format!("strike: {error}; it shows nothing of the table")),
        }
        if is_by(log, &artifact.version) {
            own.insert(name(log));
        }
        kept.logs.insert(name(log), sha256);
    }
    let (mut strikes, _) = ingest::assemble(outcomes);
    // Logs in the order of their names, whatever a clock that was set says.
    strikes.sort_by(|a, b| a.log.cmp(&b.log).then(a.t_start.total_cmp(&b.t_start)));
    let read = strikes.len();
    strikes.retain(|strike| strike.t_start > known || own.contains(&strike.log));
    if strikes.len() < read {
        tell(&format!(
            "strike: {} strikes in {} are stamped no later than the last one that {} learnt from: they are not followed",
            read - strikes.len(),
            folder.display(),
            artifact.version
        ));
    }
    let followed = planner.follow(artifact, &mut kept.recent, &strikes);
    if !new.is_empty()
        && let Err(error) = keep(&place, &mut kept)
    {
        // The logs are there: the next plan follows them again.
        tell(&format!(
            "strike: what is known of the table was not kept: {error}"
        ));
    }
    followed.map_err(failure)?;
    Ok(planner.adapted(&kept.recent, all.last().is_some_and(|log| is_of_today(log))))
}

/// Whether the last strike is so recent that the session goes on. By the file's age, for a log's clock need not be this computer's.
fn is_of_today(log: &Path) -> bool {
    let written = fs::metadata(log).and_then(|metadata| metadata.modified());
    let age = written.map(|written| SystemTime::now().duration_since(written));
    match age {
        Ok(Ok(age)) => age.as_secs_f64() < SESSION_GAP,
        // Written after now: a clock was set.
        Ok(Err(_)) => true,
        Err(_) => false,
    }
}

/// The strikes of a log; a person is told what of it shows nothing.
fn ingested(log: &Path, planner: &Planner) -> Result<LogOutcome, IngestError> {
    let outcome = ingest::ingest_log(log, planner.rig(), &ingest::Ingest::default())?;
    let lost = outcome.rejects.iter().map(|reject| {
        format!(
            "its strike {} shows nothing of the table: {}",
            reject.index + 1,
            reject.detail
        )
    });
    let notes = outcome.notes.iter().map(ToString::to_string);
    for what in notes.chain(lost) {
        tell(&format!("strike: log {}: {what}", log.display()));
    }
    Ok(outcome)
}

/// The logs of a folder, in the order of their names; none where the folder does not exist yet.
fn logs(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(error),
    };
    let mut logs: Vec<PathBuf> = entries
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<io::Result<_>>()?;
    logs.retain(|path| path.extension().is_some_and(|ending| ending == "mcap"));
    logs.sort();
    Ok(logs)
}

fn name(log: &Path) -> String {
    log.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

/// Whether this version planned a strike of a log, which was then made after it learnt.
fn is_by(log: &Path, version: &str) -> bool {
    let lineages = logs::write::lineages(log).unwrap_or_default();
    let planned_by = |lineage: &Lineage| lineage.get("version").is_some_and(|by| by == version);
    lineages.iter().any(planned_by)
}

fn read(place: &Path) -> Option<Kept> {
    let text = fs::read_to_string(place).ok()?;
    let kept: Kept = serde_json::from_str(&text).ok()?;
    let unsealed = text.replacen(&kept.sha256, UNSEALED, 1);
    (durable::sha256(unsealed.as_bytes()) == kept.sha256).then_some(kept)
}

fn keep(place: &Path, kept: &mut Kept) -> Result<(), String> {
    kept.sha256 = UNSEALED.into();
    let text = serde_json::to_string(kept).map_err(|error| error.to_string())?;
    let text = text.replacen(UNSEALED, &durable::sha256(text.as_bytes()), 1);
    durable::write_bytes(place, text.as_bytes()).map_err(|error| error.to_string())
}

fn failure(error: PlannerError) -> Failure {
    match error {
        PlannerError::TableChanged { .. } => {
            Failure::refused(Reason::TableChanged, format!("failed to {error}"))
        }
        error => Failure::input(error),
    }
}
