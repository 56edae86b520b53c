//! Whole sessions held out: what models say of strikes as if they had never seen the strike's session.
//!
//! What differs by session then has its mean over the other sessions. Everything else of a model learnt from training strikes of
//! that session as well; a log that no version has seen (`carom score`), or a trial in new sessions, has no part in anything.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use values::{Rig, StopErrors};

use crate::{Candidate, EvaluateError, Judge, Model, Predicted, statistics};

/// Stop errors in sessions that are held out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NewSessions {
    /// Sessions that the strikes are of.
    pub sessions: usize,
    /// Stop errors, by model. A model that predicts no strike is missing.
    pub models: BTreeMap<String, StopErrors>,
}

/// For each session of the judges, the model that has never seen it, and the session's judges.
pub fn unseen(rig: &Rig, candidate: &Candidate, judges: &[Judge]) -> Vec<(Model, Vec<Judge>)> {
    sessions(judges.iter())
        .into_iter()
        .map(|session| {
            let candidate = Candidate {
                world: candidate.world.clone().without_session(session),
                ..candidate.clone()
            };
            let is_of = |judge: &&Judge| judge.conditions.session == session;
            let judges = judges.iter().filter(is_of).cloned().collect();
            (Model::of(rig, &candidate), judges)
        })
        .collect()
}

fn sessions<'a>(judges: impl Iterator<Item = &'a Judge>) -> BTreeSet<&'a str> {
    judges
        .map(|judge| judge.conditions.session.as_str())
        .collect()
}

/// Sums up what each model that has never seen a strike's session says of it; none where all strikes are of one session.
pub fn new_sessions(
    predicted: &[(String, Vec<(Judge, Predicted)>)],
) -> Result<Option<NewSessions>, EvaluateError> {
    let judges = predicted.first().map_or(&[][..], |(_, answers)| answers);
    let sessions = sessions(judges.iter().map(|(judge, _)| judge));
    if sessions.len() < 2 {
        return Ok(None);
    }
    let rows = predicted.iter().flat_map(|(model, answers)| {
        answers.iter().map(move |(judge, answer)| {
            let error = answer.stop.map(|stop| stop.distance(judge.stop));
            (model.as_str(), error)
        })
    });
    let (models, errors): (Vec<&str>, Vec<Option<f64>>) = rows.unzip();
    Ok(Some(NewSessions {
        sessions: sessions.len(),
        models: statistics::summarise(&models, &errors)?,
    }))
}
