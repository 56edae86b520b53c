//! Judges models by their stop error on logged strikes (contract, section 4).
//!
//! The stop error is the distance between the measured stop and the stop that the model predicts for the command that
//! was sent: for a world, its forward simulation; with the residual, the path for which solve + residual would have
//! sent that command. `noise_floor` is the error that a perfect model would show, for repeats of one command scatter.

mod error;
mod inverse;
mod items;
mod model;
mod noise;
mod predict;
mod predicted;
mod sessions;
mod statistics;

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use stage::{ItemStage, Progress, Stage};
use values::{Point, Rig, Split, StopErrors, Strike};

pub use error::EvaluateError;
pub use items::{Observe, Predict, Repeat};
pub use model::{Candidate, Model};
pub use noise::{Noise, Slopes};
pub use predict::{Judge, predict};
pub use predicted::{Predicted, PredictionStatus};
pub use sessions::{NewSessions, new_sessions, unseen};

/// The stage that judges models as a whole; for strikes that come night by night, [`Predict`] and [`Repeat`] keep what each
/// strike said.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Evaluate {
    /// Which strikes judge; none means all.
    pub split: Option<Split>,
}

impl Default for Evaluate {
    /// Held-out strikes.
    fn default() -> Self {
        Self {
            split: Some(Split::Test),
        }
    }
}

/// What the stage computes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Input {
    /// The set-up.
    pub rig: Rig,
    /// Logged strikes.
    pub strikes: Vec<Strike>,
    /// Models.
    pub candidates: Vec<Candidate>,
    /// How repeats scatter; the noise floor follows from it through the last candidate's world.
    pub noise: Noise,
}

/// One model's prediction of one strike.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Prediction {
    /// The model.
    pub model: String,
    /// The strike.
    pub strike_id: String,
    /// Predicted stop, in m.
    pub stop: Option<Point>,
    /// Distance from the measured stop, in m.
    pub error: Option<f64>,
    /// Simulations used.
    pub evaluations: u32,
    /// How it ended.
    pub status: PredictionStatus,
}

/// What `evaluation.json` holds: a key for each model and `noise_floor`, and each strike's prediction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// Stop errors, by model. A model that predicts no strike is missing.
    #[serde(flatten)]
    pub models: BTreeMap<String, StopErrors>,
    /// What a perfect model would show on the same strikes; none without strikes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_floor: Option<StopErrors>,
    /// The same strikes, each as if the models had never seen its session; none where all are of one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub new_sessions: Option<NewSessions>,
    /// Each model's prediction of each strike: models in their order, then strikes in theirs.
    pub predictions: Vec<Prediction>,
}

impl Evaluation {
    /// Stop errors in new sessions, where a model has parameters by session; else they repeat those in known ones.
    pub fn differing_sessions(&self) -> Option<&NewSessions> {
        let new = self.new_sessions.as_ref();
        new.filter(|new| new.models != self.models)
    }
}

impl Stage for Evaluate {
    const NAME: &'static str = "evaluate";
    const VERSION: u32 = 6;
    type Input = Input;
    type Output = Evaluation;
    type Error = EvaluateError;

    fn run(&self, input: &Input, progress: &Progress) -> Result<Evaluation, EvaluateError> {
        let mut names = BTreeSet::new();
        if let Some(twice) = input
            .candidates
            .iter()
            .find(|candidate| !names.insert(&candidate.name))
        {
            return Err(EvaluateError::Twice {
                model: twice.name.clone(),
            });
        }
        let judges = |strike: &&Strike| self.split.is_none_or(|split| strike.split == split);
        let judges: Vec<Judge> = input
            .strikes
            .iter()
            .filter(judges)
            .map(Judge::from)
            .collect();
        let all: Vec<&Judge> = judges.iter().collect();
        progress.items(judges.len() * (2 * input.candidates.len() + 1));

        let mut predicted = Vec::new();
        for candidate in &input.candidates {
            let model = Model::of(&input.rig, candidate);
            let answers = Predict.run_items(&model, &all, progress)?;
            predicted.push((candidate.name.clone(), answers));
        }
        let repeats = match input.candidates.last() {
            Some(last) => {
                let world = Model::of(&input.rig, last).world_alone();
                Repeat.run_items(&world, &all, progress)?
            }
            None => Vec::new(),
        };
        let mut in_new_sessions = Vec::new();
        for candidate in &input.candidates {
            let mut answers = Vec::new();
            for (model, judges) in unseen(&input.rig, candidate, &judges) {
                let predicted =
                    Predict.run_items(&model, &judges.iter().collect::<Vec<_>>(), progress)?;
                answers.extend(judges.into_iter().zip(predicted));
            }
            in_new_sessions.push((candidate.name.clone(), answers));
        }
        Ok(Evaluation {
            new_sessions: new_sessions(&in_new_sessions)?,
            ..evaluation(&judges, &predicted, &repeats, &input.noise)?
        })
    }
}

/// Sums up each model's predictions of the judges in sessions that the model knows, and what launches that scatter so do to each; all in the judges' order.
pub fn evaluation(
    judges: &[Judge],
    predicted: &[(String, Vec<Predicted>)],
    repeats: &[Option<Slopes>],
    noise: &Noise,
) -> Result<Evaluation, EvaluateError> {
    let mut predictions = Vec::new();
    for (model, answers) in predicted {
        for (judge, answer) in judges.iter().zip(answers) {
            predictions.push(Prediction {
                model: model.clone(),
                strike_id: judge.strike_id.clone(),
                stop: answer.stop,
                error: answer.stop.map(|stop| stop.distance(judge.stop)),
                evaluations: answer.evaluations,
                status: answer.status,
            });
        }
    }
    let models: Vec<&str> = predictions.iter().map(|row| row.model.as_str()).collect();
    let errors: Vec<Option<f64>> = predictions.iter().map(|row| row.error).collect();
    Ok(Evaluation {
        models: statistics::summarise(&models, &errors)?,
        noise_floor: noise_floor(repeats, noise)?,
        new_sessions: None,
        predictions,
    })
}

/// The stop error that scatter alone leaves on these strikes.
fn noise_floor(
    repeats: &[Option<Slopes>],
    noise: &Noise,
) -> Result<Option<StopErrors>, EvaluateError> {
    let known = repeats.iter().flatten();
    let distances: Vec<Option<f64>> = known
        .flat_map(|slopes| slopes.distances(noise))
        .map(Some)
        .collect();
    let summary = statistics::summarise(&vec!["noise_floor"; distances.len()], &distances)?;
    let failed = repeats.iter().filter(|scatter| scatter.is_none()).count();
    let floor = |of_samples: &StopErrors| StopErrors {
        n: repeats.len() - failed,
        failed,
        ..*of_samples
    };
    Ok(summary.get("noise_floor").map(floor))
}

#[cfg(test)]
mod tests;
