//! `--recent` and `--adapt`: the table as its last strikes show it.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use std::{fs, io};

use ingest::{IngestError, LogOutcome};
use serde::{Deserialize, Serialize};
use store::Artifact;
use strike::{Args, Planner, PlannerError, Reason, Recent, SESSION_GAP, tell};
use values::{Reject, Strike};

use super::Failure;

/// Where what is known of the table is kept, beside the logs.
const FILE: &str = "adapted.json";
/// Logs that are read where nothing is kept: a table is known by its last strikes.
const MOST_LOGS: usize = 60;

/// What is known of the table, and from which logs. It holds for one model of one version, and is computed anew from the logs where it
/// cannot be read.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    /// Hash of the version's manifest.
    manifest: String,
    model: String,
    /// Names of the logs that were followed or passed over.
    logs: BTreeSet<String>,
    recent: Recent,
}

/// By the strikes of these logs.
pub fn by_logs(
    logs: &[PathBuf],
    artifact: &Artifact,
    planner: Planner,
) -> Result<Planner, Failure> {
    let outcomes: Result<Vec<_>, _> = logs.iter().map(|log| ingested(log, &planner)).collect();
    let strikes = in_order(outcomes.map_err(Failure::input)?);
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

/// By the strikes that were made here since the version learnt.
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
        let passed_over = all.len().saturating_sub(MOST_LOGS);
        Kept {
            manifest: manifest.clone(),
            model,
            logs: all.iter().take(passed_over).map(|log| name(log)).collect(),
            recent: planner.recent(),
        }
    });
    let new: Vec<PathBuf> = all
        .iter()
        .filter(|log| !kept.logs.contains(&name(log)))
        .cloned()
        .collect();
    let known = artifact.manifest.provenance.strikes;
    let known = known.map_or(f64::NEG_INFINITY, |known| known.last);
    let since = kept.recent.last().map_or(known, |last| last.max(known));
    let mut outcomes = Vec::new();
    for log in &new {
        match ingested(log, &planner) {
            Ok(outcome) => outcomes.push(outcome),
            // What a robot wrote as it lost power must not stop every strike to come.
            Err(error) => tell(&format!("strike: {error}; it shows nothing of the table")),
        }
    }
    let mut strikes = in_order(outcomes);
    strikes.retain(|strike| strike.t_start > since);
    let followed = planner.follow(artifact, &mut kept.recent, &strikes);
    kept.logs.extend(new.iter().map(|log| name(log)));
    if !new.is_empty()
        && let Err(error) = keep(&place, &kept)
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

/// What a log holds; what of it shows nothing is told.
fn ingested(log: &Path, planner: &Planner) -> Result<LogOutcome, IngestError> {
    let outcome = ingest::ingest_log(log, planner.rig(), &ingest::Ingest::default())?;
    let lost = outcome.rejects.iter().map(|reject| {
        let Reject {
            index,
            reason,
            detail,
            ..
        } = reject;
        format!(
            "its strike {} shows nothing of the table: {reason} ({detail})",
            index + 1
        )
    });
    for what in outcome.notes.iter().cloned().chain(lost) {
        tell(&format!("strike: log {}: {what}", log.display()));
    }
    Ok(outcome)
}

/// The strikes of logs in the order of time.
fn in_order(outcomes: Vec<LogOutcome>) -> Vec<Strike> {
    let (mut strikes, _) = ingest::assemble(outcomes);
    strikes.sort_by(|a, b| a.t_start.total_cmp(&b.t_start));
    strikes
}

/// The logs of a folder by their names, which count; none where the folder is not there yet.
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

fn read(place: &Path) -> Option<Kept> {
    serde_json::from_slice(&fs::read(place).ok()?).ok()
}

fn keep(place: &Path, kept: &Kept) -> Result<(), String> {
    let text = serde_json::to_string(kept).map_err(|error| error.to_string())?;
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
