//! Judges models by their stop error on logged strikes (contract, section 4).
//!
//! The stop error is the distance between the measured stop and the stop that the model predicts for the command that
//! was sent: for a world, its forward simulation; with the residual, the path for which solve + residual would have
//! sent that command. `noise_floor` is the error that a perfect model would show, for repeats of one command scatter.

mod error;
mod inverse;
mod noise;
mod predict;
mod statistics;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};

use artifacts::network::Network;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use stage::{Progress, Stage};
use values::{Point, Rig, Split, Strike};
use world::{Simulator, World};

pub use error::EvaluateError;
pub use noise::Noise;
pub use predict::{Predicted, PredictionStatus, predict};
pub use statistics::StopError;

/// The stage.
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

/// A model to be judged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Its name, such as `sysid_residual`.
    pub name: String,
    /// Its world.
    pub world: World,
    /// What it adds to the world's solution.
    pub residual: Option<Network>,
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
    pub models: BTreeMap<String, StopError>,
    /// What a perfect model would show on the same strikes; none without strikes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_floor: Option<StopError>,
    /// Each model's prediction of each strike: models in their order, then strikes in theirs.
    pub predictions: Vec<Prediction>,
}

impl Stage for Evaluate {
    const NAME: &'static str = "evaluate";
    const VERSION: u32 = 1;
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
        let strikes: Vec<&Strike> = input.strikes.iter().filter(judges).collect();
        progress.items(strikes.len() * (input.candidates.len() + 1));

        let mut predictions = Vec::new();
        for candidate in &input.candidates {
            predictions.extend(predict_all(&input.rig, candidate, &strikes, progress)?);
        }
        let models: Vec<&str> = predictions.iter().map(|row| row.model.as_str()).collect();
        let errors: Vec<Option<f64>> = predictions.iter().map(|row| row.error).collect();
        Ok(Evaluation {
            models: statistics::summarise(&models, &errors)?,
            noise_floor: noise_floor(input, &strikes, progress)?,
            predictions,
        })
    }
}

fn simulator(rig: &Rig, candidate: &Candidate) -> Result<Simulator, EvaluateError> {
    Simulator::new(rig, &candidate.world).map_err(|source| EvaluateError::World {
        model: candidate.name.clone(),
        source,
    })
}

/// One model's predictions, in the strikes' order.
fn predict_all(
    rig: &Rig,
    candidate: &Candidate,
    strikes: &[&Strike],
    progress: &Progress,
) -> Result<Vec<Prediction>, EvaluateError> {
    let simulator = simulator(rig, candidate)?;
    let rows = strikes.par_iter().map_init(
        || simulator.worker(),
        |worker, strike| {
            let predicted = predict(worker, candidate.residual.as_ref(), strike);
            progress.inc(1);
            Prediction {
                model: candidate.name.clone(),
                strike_id: strike.id.clone(),
                stop: predicted.stop,
                error: predicted.stop.map(|stop| stop.distance(strike.stop)),
                evaluations: predicted.evaluations,
                status: predicted.status,
            }
        },
    );
    Ok(rows.collect())
}

/// The stop error that scatter alone leaves on these strikes.
fn noise_floor(
    input: &Input,
    strikes: &[&Strike],
    progress: &Progress,
) -> Result<Option<StopError>, EvaluateError> {
    let Some(last) = input.candidates.last() else {
        return Ok(None);
    };
    let simulator = simulator(&input.rig, last)?;
    let samples: Vec<Option<Vec<f64>>> = strikes
        .par_iter()
        .map_init(
            || simulator.worker(),
            |worker, strike| {
                progress.inc(1);
                noise::distances(worker, strike, &input.noise)
            },
        )
        .collect();
    let failed = samples.iter().filter(|sample| sample.is_none()).count();
    let distances: Vec<Option<f64>> = samples.into_iter().flatten().flatten().map(Some).collect();
    let summary = statistics::summarise(&vec!["noise_floor"; distances.len()], &distances)?;
    let floor = |of_samples: &StopError| StopError {
        n: strikes.len() - failed,
        failed,
        ..*of_samples
    };
    Ok(summary.get("noise_floor").map(floor))
}
