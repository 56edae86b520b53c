//! The tables of a trial.

use std::collections::BTreeMap;

use store::Model;

use super::table::{Line, table};
use crate::trial::{Outcome, Trial};

/// Both tables of a trial.
pub fn trial(trial: &Trial) -> String {
    let lines = |outcomes: &BTreeMap<String, Outcome>| {
        let models = Model::ALL.into_iter().map(Model::name).filter_map(|name| {
            let outcome = outcomes.get(name)?;
            let errors = outcome.errors.unwrap_or_default();
            Some(Line {
                name,
                numbers: [errors.mean, errors.sd, errors.median, errors.p95],
                n: errors.n,
                remark: remark(outcome),
            })
        });
        let floor = trial.noise_floor.map(|errors| Line {
            name: "noise_floor",
            numbers: [errors.mean, errors.sd, errors.median, errors.p95],
            n: errors.n,
            remark: "repeats of one command".into(),
        });
        table(models.chain(floor))
    };
    let random = trial.models.values().next();
    let struck = random.map_or(0, |outcome| outcome.strikes.len() + outcome.refusals.len());
    let session = trial.session.as_ref().map_or_else(String::new, |session| {
        format!(", in its last logged session {session}")
    });
    let new = trial.new_sessions.as_ref().map_or_else(String::new, |new| {
        format!(
            "\nThe same targets in {} new sessions, which the version has never seen\n{}",
            new.sessions,
            lines(&new.models)
        )
    });
    format!(
        "Version {} against {}{session}\n\nFigure 8: two starts, four targets each, repeated\n{}\n\
         Random targets: {struck} struck at, {} of {} drawn were refused by the default model\n{}{new}",
        trial.artifact,
        trial.robot,
        lines(&trial.figure_8),
        trial.drawn - struck,
        trial.drawn,
        lines(&trial.models),
    )
}

/// What the plans promised, and how many were refused.
fn remark(outcome: &Outcome) -> String {
    let expected = outcome
        .expected_miss
        .map(|expected| format!("{:.2} expected", 100.0 * expected));
    let refused = match outcome.refusals.len() {
        0 => None,
        refused => Some(format!("{refused} refused")),
    };
    let parts: Vec<String> = expected.into_iter().chain(refused).collect();
    parts.join(", ")
}
