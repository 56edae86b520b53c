//! `carom score`: how well a version predicts the strikes of other logs.

use std::collections::BTreeMap;
use std::path::PathBuf;

use check::Severity;
use clap::Args;
use judge::{Evaluation, Misses, misses};
use serde::Serialize;
use store::Store;
use values::{StopErrors, Strike};

use crate::args::Global;
use crate::error::{Outcome, Output, to_json};
use crate::fetching::Fetch;
use crate::inputs::find_logs;
use crate::outputs::write_json;
use crate::publishing::store_error;
use crate::score::{Drift, drift_unknown, follow_known_strikes, judge};
use crate::steps::open;
use crate::{Error, reading, summary};

/// `carom score`.
#[derive(Args, Debug)]
pub struct ScoreArgs {
    /// MCAP files, or folders that are searched for them with all below.
    #[arg(required = true, value_name = "LOGS")]
    pub logs: Vec<PathBuf>,
    /// Folder of a run.
    #[arg(long, value_name = "DIR")]
    pub artifacts: PathBuf,
    /// Version to score [default: the latest].
    #[arg(long, value_name = "VERSION")]
    pub version: Option<String>,
}

/// What `score.json` holds: a key for each model, and `noise_floor`.
#[derive(Debug, Serialize)]
struct Score {
    /// Version that was scored.
    artifact: String,
    /// Strikes that were rejected.
    rejected: usize,
    /// Whether the table is where the version has it.
    drift: Option<Drift>,
    /// Why that cannot be judged, where it cannot.
    drift_unknown: Option<String>,
    /// What repeats of one command scatter by, as published.
    noise_floor: Option<StopErrors>,
    /// Stop errors, by model.
    #[serde(flatten)]
    models: BTreeMap<String, Scored>,
}

/// One model's stop errors, in m.
#[derive(Debug, Serialize)]
struct Scored {
    #[serde(flatten)]
    errors: StopErrors,
    strikes: Vec<ScoredStrike>,
    /// Its errors by session, speed, angle, start and distance.
    misses: Vec<Misses>,
}

/// One strike, in m.
#[derive(Debug, Serialize)]
struct ScoredStrike {
    strike_id: String,
    error: Option<f64>,
}

/// Scores the logs, writes `score.json`.
pub fn run(args: &ScoreArgs, global: Global) -> Result<Output, Error> {
    let dir = &args.artifacts;
    let artifact = Store::open(dir)
        .load(args.version.as_deref())
        .map_err(store_error)?;
    let logs = find_logs(
        &args.logs,
        &Fetch {
            rig: Some(&artifact.rig),
            run: None,
        },
    )?;
    // The artifact may be a robot's copy: nothing but the score is left there.
    let scratch = tempfile::tempdir().map_err(Error::failed)?;
    let run = open(scratch.path(), global)?;
    let read = reading::read(&run, &artifact.rig, &logs, 0)?;
    let mut strikes = read.strikes.iter().collect::<Result<Vec<_>, _>>()?;
    strikes.retain(Strike::has_stop);
    if let Some(known) = artifact.manifest.provenance.strikes {
        follow_known_strikes(known, &mut strikes);
    }
    let (evaluation, drift) = judge(&run, &artifact, &strikes)?;
    let score = Score {
        artifact: artifact.version.clone(),
        rejected: read.rejects.len(),
        drift_unknown: drift.is_none().then(drift_unknown),
        drift,
        noise_floor: evaluation.noise_floor,
        models: by_model(&evaluation, &strikes)?,
    };
    write_json(&dir.join("score.json"), &score)?;

    let mut text = format!(
        "{} strikes, {} rejected, scored with {}\n\n{}",
        strikes.len(),
        read.rejects.len(),
        artifact.version,
        summary::evaluation_table(&evaluation)
    );
    let used = artifact.manifest.provenance.default_model.name();
    if let Some(scored) = score.models.get(used) {
        text += &summary::misses_table(used, &scored.misses);
    }
    for note in &read.notes {
        text += &format!("{note}\n");
    }
    text += &summary::findings(&read.check, &artifact.rig, Severity::Doubtful);
    let drift = score.drift.as_ref().map(Drift::sentence);
    for sentence in drift.iter().chain(&score.drift_unknown) {
        text += &format!("\n{sentence}\n");
    }
    let is_refused =
        score.drift.as_ref().is_some_and(Drift::is_beyond_chance) || read.check.is_meaningless();
    let outcome = if is_refused {
        Outcome::Refused
    } else {
        read.outcome()
    };
    Ok(Output::ended(outcome, to_json(&score)?, text))
}

fn by_model(evaluation: &Evaluation, judges: &[Strike]) -> Result<BTreeMap<String, Scored>, Error> {
    let models = evaluation.models.iter();
    models
        .map(|(model, errors)| {
            let rows = evaluation.predictions.iter();
            let strikes = rows
                .filter(|row| row.model == *model)
                .map(|row| ScoredStrike {
                    strike_id: row.strike_id.clone(),
                    error: row.error,
                })
                .collect();
            let scored = Scored {
                errors: *errors,
                strikes,
                misses: misses(model, judges, &evaluation.predictions).map_err(Error::failed)?,
            };
            Ok((model.clone(), scored))
        })
        .collect()
}
