//! Judges models by their stop error on strikes that they had no part in (contract, section 4).
//!
//! The stop error is the distance between the measured stop and the stop that the model predicts for the command that
//! was sent: for a world, its forward simulation; with the residual, the path for which solve + residual would have
//! sent that command. `noise_floor` is the error that a perfect model would show, for repeats of one command scatter.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use stage::{Run, RunError};
use values::{Point, StopErrors};

use crate::{Candidate, HeldOut, JudgeError, Model, Noise, Predict, PredictionStatus, Repeat};

/// One model's prediction of one strike.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Prediction {
    /// The model.
    pub model: String,
    /// The strike.
    pub strike_id: String,
    /// Predicted stop, in m; none where the model predicts none.
    pub stop: Option<Point>,
    /// Distance from the measured stop, in m.
    pub error: Option<f64>,
    /// Number of simulations used.
    pub evaluations: u32,
    /// How the prediction ended.
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
    /// Stop errors of the same strikes, each predicted as if the models had never seen its session, about which a model that tells none apart misses by
    /// more (`Noise::sessions`); none where all strikes are of one session.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub new_sessions: Option<NewSessions>,
    /// Each model's prediction of each strike: models in their order, then strikes in theirs.
    pub predictions: Vec<Prediction>,
}

/// Stop errors in sessions that are held out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NewSessions {
    /// Number of sessions that the strikes are of.
    pub sessions: usize,
    /// Stop errors, by model. A model that predicts no strike is missing.
    pub models: BTreeMap<String, StopErrors>,
}

impl Evaluation {
    /// Stop errors in new sessions, where these differ.
    pub fn differing_sessions(&self) -> Option<&NewSessions> {
        let new = self.new_sessions.as_ref();
        new.filter(|new| new.models != self.models)
    }
}

/// Each model's predictions of the strikes, in their order, and their sums; the noise floor follows from `noise` through the last model's
/// world. What a strike said of a model is kept in the run.
pub fn evaluate(
    run: &Run,
    candidates: &[Candidate],
    strikes: &[HeldOut],
    noise: &Noise,
) -> Result<Evaluation, RunError<JudgeError>> {
    let mut predictions = Vec::new();
    let mut unseen = Vec::new();
    let names = sessions(strikes);
    for Candidate { name, model } in candidates {
        let predicted = run.items(&Predict, model, strikes)?;
        predictions.extend(
            strikes
                .iter()
                .zip(predicted)
                .map(|(strike, predicted)| Prediction {
                    model: name.clone(),
                    strike_id: strike.strike_id.clone(),
                    stop: predicted.stop,
                    error: predicted.stop.map(|stop| stop.distance(strike.stop)),
                    evaluations: predicted.evaluations,
                    status: predicted.status,
                }),
        );
        let errors = unseen_stop_errors(run, model, strikes)?;
        let times = match model.has_learnt_their_mean(&names) {
            true => noise.in_a_new_session(&errors, names.len()),
            false => 1.0,
        };
        let errors = errors.into_iter().map(|error| Some(times * error?));
        unseen.extend(errors.map(|error| (name.as_str(), error)));
    }
    let known = predictions
        .iter()
        .map(|row| (row.model.as_str(), row.error));
    let sessions = names.len();
    let new_sessions = match sessions {
        0 | 1 => None,
        _ => Some(NewSessions {
            sessions,
            models: summarise(unseen.into_iter()),
        }),
    };
    Ok(Evaluation {
        models: summarise(known),
        noise_floor: match candidates.last() {
            Some(last) => noise_floor(run, &last.model, strikes, noise)?,
            None => None,
        },
        new_sessions,
        predictions,
    })
}

/// A model's stop errors in m, in the order of the strikes; none where it predicts no stop.
pub fn stop_errors(
    run: &Run,
    model: &Model,
    strikes: &[HeldOut],
) -> Result<Vec<Option<f64>>, RunError<JudgeError>> {
    let predicted = run.items(&Predict, model, strikes)?;
    let error = |(strike, predicted): (&HeldOut, crate::Predicted)| {
        predicted.stop.map(|stop| stop.distance(strike.stop))
    };
    Ok(strikes.iter().zip(predicted).map(error).collect())
}

/// A model's stop errors in m, in the order of the strikes, each predicted as if the model had never seen its session: what differs by session then
/// has its mean over the other sessions. Everything else of a model learnt from training strikes of that session as well; a log that no version has
/// seen (`carom score`), or a trial in new sessions, has no part in anything.
pub fn unseen_stop_errors(
    run: &Run,
    model: &Model,
    strikes: &[HeldOut],
) -> Result<Vec<Option<f64>>, RunError<JudgeError>> {
    // Sessions that a model does not tell apart are asked of it together.
    let mut parts: Vec<(Model, Vec<usize>)> = Vec::new();
    for session in sessions(strikes) {
        let model = model.without_session(session);
        let is_of = |place: &usize| strikes[*place].conditions.session == session;
        let places = (0..strikes.len()).filter(is_of);
        match parts
            .iter_mut()
            .find(|(other, _)| other.world == model.world)
        {
            Some((_, others)) => others.extend(places),
            None => parts.push((model, places.collect())),
        }
    }
    let mut errors = vec![None; strikes.len()];
    for (model, places) in parts {
        let part: Vec<HeldOut> = places.iter().map(|place| strikes[*place].clone()).collect();
        for (place, error) in places.iter().zip(stop_errors(run, &model, &part)?) {
            errors[*place] = error;
        }
    }
    Ok(errors)
}

fn sessions(strikes: &[HeldOut]) -> BTreeSet<&str> {
    let sessions = strikes.iter();
    sessions
        .map(|strike| strike.conditions.session.as_str())
        .collect()
}

/// The stop errors that repeats of these strikes would show with a perfect model.
fn noise_floor(
    run: &Run,
    model: &Model,
    strikes: &[HeldOut],
    noise: &Noise,
) -> Result<Option<StopErrors>, RunError<JudgeError>> {
    let world = Model {
        residual: None,
        ..model.clone()
    };
    let slopes = run.items(&Repeat, &world, strikes)?;
    let known: Vec<_> = slopes.iter().flatten().collect();
    let floor = StopErrors::of(noise.distances(&known).into_iter());
    Ok(floor.map(|of_samples| StopErrors {
        n: known.len(),
        failed: slopes.len() - known.len(),
        ..of_samples
    }))
}

/// Sums up errors in m, none where there is no prediction. A model without any prediction has no statistics.
pub(crate) fn summarise<'m>(
    errors: impl Iterator<Item = (&'m str, Option<f64>)>,
) -> BTreeMap<String, StopErrors> {
    let mut of_models: BTreeMap<&str, (Vec<f64>, usize)> = BTreeMap::new();
    for (model, error) in errors {
        let (known, failed) = of_models.entry(model).or_default();
        match error {
            Some(error) => known.push(error),
            None => *failed += 1,
        }
    }
    let summed = of_models
        .into_iter()
        .filter_map(|(model, (known, failed))| {
            let errors = StopErrors::of(known.into_iter())?;
            Some((model.to_string(), StopErrors { failed, ..errors }))
        });
    summed.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_are_summed_up_apart() {
        let rows = [
            ("a", Some(1.0)),
            ("b", Some(7.0)),
            ("a", Some(2.0)),
            ("c", None),
            ("a", None),
        ];
        let all = summarise(rows.into_iter());
        assert_eq!((all["a"].mean, all["a"].n, all["a"].failed), (1.5, 2, 1));
        assert_eq!((all["b"].mean, all["b"].sd, all["b"].n), (7.0, 0.0, 1));
        assert!(
            !all.contains_key("c"),
            "a model without a prediction has no statistics"
        );
    }
}
