//! `carom score`: how well a version predicts other strikes than it learnt from. A rig that has drifted shows here.

use std::collections::BTreeMap;

use evaluate::{Candidate, Evaluate, Evaluation, StopError};
use serde::{Deserialize, Serialize};
use stage::Run;
use statrs::distribution::{ContinuousCDF, Gamma};
use store::{Artifact, Logged, Metrics, Model, Store};
use values::Strike;

use crate::args::{Global, ScoreArgs};
use crate::commands::{Said, open, to_json};
use crate::error::Outcome;
use crate::inputs::find_logs;
use crate::noise::identified;
use crate::outputs::write_json;
use crate::publishing::store_error;
use crate::{Error, reading, summary};

/// What `score.json` holds: a key for each model, and `noise_floor`.
#[derive(Debug, Serialize)]
struct Score {
    /// Version that was scored.
    artifact: String,
    /// Strikes that were rejected.
    rejected: usize,
    /// Whether the default model does worse here than chance explains.
    drift: Option<Drift>,
    /// Why that cannot be told, where it cannot.
    drift_unknown: Option<String>,
    /// What repeats of one command scatter by, as published.
    noise_floor: Option<StopError>,
    /// Stop errors, by model.
    #[serde(flatten)]
    models: BTreeMap<String, Scored>,
}

/// One model's stop errors, in m.
#[derive(Debug, Serialize)]
struct Scored {
    #[serde(flatten)]
    errors: StopError,
    strikes: Vec<ScoredStrike>,
}

/// One strike, in m.
#[derive(Debug, Serialize)]
struct ScoredStrike {
    strike_id: String,
    error: Option<f64>,
}

/// The default model's mean stop error here against that on the strikes held out when the version was published.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drift {
    model: Model,
    /// Mean stop error when published, in m.
    published: f64,
    /// Mean stop error here, in m.
    here: f64,
    /// Their difference in units of its standard error, by the scatter when published.
    z: f64,
    /// Whether chance gives as much less often than [`CHANCE`].
    beyond_chance: bool,
}

/// Fewer held-out strikes when published tell no scatter to judge by.
const LEAST: usize = 8;
/// Chance is called drift once in so many scores.
const CHANCE: f64 = 1e-3;

/// Scores the logs, writes `score.json`.
pub fn score(args: &ScoreArgs, global: Global) -> Result<Said, Error> {
    let dir = &args.artifacts;
    let artifact = Store::open(dir)
        .load(args.version.as_deref())
        .map_err(store_error)?;
    let logs = find_logs(&args.logs)?;
    // The artifact may be a robot's copy: nothing but the score is left there.
    let scratch = tempfile::tempdir().map_err(Error::failed)?;
    let run = open(scratch.path(), global)?;
    let read = reading::read(&run, &artifact.rig, &logs, 0)?;
    let mut strikes = read.strikes.iter().collect::<Result<Vec<_>, _>>()?;
    if let Some(known) = artifact.manifest.provenance.strikes {
        go_on_from(known, &mut strikes);
    }
    let scored = strikes.len();
    let (evaluation, drift) = judge(&run, &artifact, strikes)?;
    let score = Score {
        artifact: artifact.version.clone(),
        rejected: read.rejects.len(),
        drift,
        drift_unknown: drift.is_none().then(|| unknown(&artifact)),
        noise_floor: evaluation.noise_floor,
        models: by_model(&evaluation),
    };
    write_json(&dir.join("score.json"), &score)?;

    let mut text = format!(
        "{} strikes, {} rejected, scored with {}\n\n{}",
        scored,
        read.rejects.len(),
        artifact.version,
        summary::evaluation_table(&evaluation)
    );
    for note in &read.notes {
        text += &format!("{note}\n");
    }
    let drift = drift.map(|drift| drift.sentence());
    for sentence in drift.iter().chain(&score.drift_unknown) {
        text += &format!("\n{sentence}\n");
    }
    Ok(Said {
        outcome: if read.rejects.is_empty() && read.damaged.is_empty() && read.left_out.is_empty() {
            Outcome::Done
        } else {
            Outcome::Rejected
        },
        json: to_json(&score)?,
        text,
    })
}

/// How well every model of a version predicts strikes, and whether that is worse than when it was published.
pub fn judge(
    run: &Run,
    artifact: &Artifact,
    strikes: Vec<Strike>,
) -> Result<(Evaluation, Option<Drift>), Error> {
    let used = artifact.effect.as_ref().unwrap_or(&artifact.sysid);
    let input = evaluate::Input {
        rig: artifact.rig.clone(),
        candidates: candidates(artifact),
        noise: identified(&artifact.rig, &used.world),
        strikes,
    };
    let mut evaluation = run.stage(&Evaluate { split: None }, &input)?;
    // What was estimated when the residual was there to take away what repeats.
    if let Some(published) = &artifact.manifest.provenance.noise_floor {
        evaluation.noise_floor = Some(of(published));
    }
    let model = artifact.manifest.provenance.default_model;
    let drift = evaluation.models.get(model.name()).and_then(|here| {
        let published = artifact.manifest.provenance.metrics.get(&model)?;
        (published.n >= LEAST).then(|| Drift::between(model, published, here))
    });
    Ok((evaluation, drift))
}

/// Why drift cannot be told with a version.
fn unknown(artifact: &Artifact) -> String {
    let provenance = &artifact.manifest.provenance;
    let published = provenance.metrics.get(&provenance.default_model);
    format!(
        "cannot tell drift: {} was published with {} held-out strikes, {LEAST} are needed",
        artifact.version,
        published.map_or(0, |published| published.n)
    )
}

/// Strikes made after those that the version was computed from follow them in order, for effects that drift.
fn go_on_from(known: Logged, strikes: &mut [Strike]) {
    let later = strikes
        .iter_mut()
        .filter(|strike| strike.t_start > known.last);
    for (place, strike) in later.enumerate() {
        strike.conditions.order = (known.count + place) as f64;
    }
}

fn candidates(artifact: &Artifact) -> Vec<Candidate> {
    let candidate = |model: Model| {
        let (world, residual) = artifact.model(model)?;
        Some(Candidate {
            name: model.name().into(),
            world,
            residual: residual.cloned(),
        })
    };
    artifact
        .models()
        .into_iter()
        .filter_map(candidate)
        .collect()
}

fn by_model(evaluation: &Evaluation) -> BTreeMap<String, Scored> {
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
            };
            (model.clone(), scored)
        })
        .collect()
}

fn of(metrics: &Metrics) -> StopError {
    let Metrics {
        mean,
        sd,
        median,
        p95,
        n,
        failed,
    } = *metrics;
    StopError {
        mean,
        sd,
        median,
        p95,
        n,
        failed,
    }
}

impl Drift {
    /// By the scatter of single strikes when published: by that of the strikes here, a wild miss would be its own excuse. Means of
    /// a few errors, which are never negative, are skewed: they follow a gamma distribution.
    fn between(model: Model, published: &Metrics, here: &StopError) -> Self {
        let each = |n: usize| 1.0 / n.max(1) as f64;
        let variance = published.sd.powi(2) * (each(published.n) + each(here.n));
        let variance = variance.max(1e-18);
        let mean = published.mean;
        let chance =
            Gamma::new(mean * mean / variance, mean / variance).map(|gamma| gamma.sf(here.mean));
        Self {
            model,
            published: mean,
            here: here.mean,
            z: (here.mean - mean) / variance.sqrt(),
            beyond_chance: chance.unwrap_or(0.0) < CHANCE && here.mean > mean,
        }
    }

    /// For a person.
    pub fn sentence(&self) -> String {
        let verdict = if self.beyond_chance {
            "worse than chance explains: the rig has drifted, or these strikes lie where none was learnt from"
        } else {
            "no drift beyond chance"
        };
        format!(
            "{}: {:.2} cm here, {:.2} cm on the strikes held out when it was published (z = {:.1}): {verdict}",
            self.model,
            self.here * 100.0,
            self.published * 100.0,
            self.z
        )
    }
}

#[cfg(test)]
mod tests {
    use values::{Command, Conditions, Point, Split, Track};

    use super::*;

    #[test]
    fn later_strikes_go_on_in_the_order_of_those_that_the_version_knows() {
        let strike = |(order, t_start): (usize, f64)| Strike {
            id: String::new(),
            log: String::new(),
            index: 0,
            t_start,
            initial: Point::default(),
            stop: Point::default(),
            command: Command {
                speed: 1.0,
                angle: 0.0,
            },
            track: Track::default(),
            split: Split::Test,
            conditions: Conditions {
                session: String::new(),
                order: order as f64,
            },
            delivered: None,
        };
        let stamps = [7.0, 8.0, 9.0, 10.0];
        let mut strikes: Vec<Strike> = stamps.into_iter().enumerate().map(strike).collect();
        let known = Logged {
            count: 50,
            last: 8.0,
        };
        go_on_from(known, &mut strikes);
        let orders: Vec<f64> = strikes
            .iter()
            .map(|strike| strike.conditions.order)
            .collect();
        assert_eq!(orders, [0.0, 1.0, 50.0, 51.0]);
    }

    #[test]
    fn only_a_difference_beyond_chance_is_called_drift() {
        let published = Metrics {
            mean: 0.005,
            sd: 0.003,
            median: 0.004,
            p95: 0.01,
            n: 50,
            failed: 0,
        };
        let here = |mean| StopError {
            mean,
            sd: 0.003,
            median: mean,
            p95: 0.01,
            n: 50,
            failed: 0,
        };
        let drift = |mean| Drift::between(Model::Sysid, &published, &here(mean));
        assert!(!drift(0.0055).beyond_chance);
        assert!(!drift(0.001).beyond_chance, "better is no drift");
        assert!(drift(0.009).beyond_chance);
        assert!((drift(0.0056).z - 1.0).abs() < 1e-9);

        // One strike that misses wildly makes the scatter here, and is told all the same.
        let wild = StopError {
            mean: 0.030,
            sd: 0.080,
            n: 10,
            ..here(0.030)
        };
        assert!(Drift::between(Model::Sysid, &published, &wild).beyond_chance);
        let single = |mean| StopError {
            sd: 0.0,
            n: 1,
            ..here(mean)
        };
        // A normal distribution would call a single strike of 3.2 standard errors drift; of errors one in 200 is so large.
        let drift = |mean| Drift::between(Model::Sysid, &published, &single(mean));
        assert!(!drift(0.0147).beyond_chance && drift(0.0147).z > 3.1);
        assert!(drift(0.025).beyond_chance);
        let perfect = Metrics {
            mean: 0.0,
            sd: 0.0,
            ..published
        };
        assert!(Drift::between(Model::Sysid, &perfect, &single(0.01)).beyond_chance);
    }
}
