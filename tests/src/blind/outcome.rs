//! What came of a set of the plain benchmark.

use serde::{Deserialize, Serialize};

use super::cases::Case;
use super::coverage::{Covered, covered};
use super::hide;
use super::set::{self, Answer, DiagnosedSet, Make};

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Outcome {
    pub case: Case,
    #[serde(flatten)]
    pub answer: Answer,
    /// Parameters that have a truth, and the intervals found.
    pub covered: Vec<Covered>,
}

/// Factors on the friction that a `start` case believes in.
const WRONG_START: [f64; 2] = [2.0, 0.5];

/// The friction that a user of this set believes in, where it is not the nominal one.
pub(super) fn believed_friction(case: &Case, friction: f64) -> Option<f64> {
    let factor = WRONG_START[(case.seed % 2) as usize];
    (case.variant == "start").then_some(friction * factor)
}

/// Makes a set and diagnoses it. `None` where the rig cannot make it, an error where identification or diagnosis gives one.
pub fn diagnosed(case: &Case) -> Option<Result<DiagnosedSet, String>> {
    let truth = hide::truth(case)?;
    let make = Make::random(&truth, case.strikes);
    set::diagnosed(make, believed_friction(case, truth.friction))
}

/// Makes a set, diagnoses it and keeps what grading needs.
pub fn run(case: &Case) -> Outcome {
    let (answer, covered) = match diagnosed(case) {
        None => (Answer::none("impossible".into()), Vec::new()),
        Some(Err(error)) => (Answer::none(format!("error: {error}")), Vec::new()),
        Some(Ok(done)) => (
            Answer::of(&done.found, done.seconds),
            covered(&case.hidden, case.variant == "textbook", &done),
        ),
    };
    Outcome {
        case: case.clone(),
        answer,
        covered,
    }
}
