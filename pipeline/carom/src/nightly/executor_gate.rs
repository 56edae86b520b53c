//! The second gate between a candidate and the robot: the executor's own library.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use store::Artifact;
use strike::{Planner, Reason};
use values::Strike;

/// At most so many strikes are planned anew.
const MOST_PLANS: usize = 200;

/// Whether the executor's own library loads the candidate and plans with it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExecutorGate {
    /// Whether it passes: at least half of the paths are planned, and no simulation diverges.
    pub passed: bool,
    /// Paths of logged strikes that it planned.
    pub planned: usize,
    pub refused: usize,
    /// The first refusal, or why there is no plan at all.
    pub first: Option<String>,
}

/// Plans the paths of the latest strikes, as they were struck.
pub fn plan_paths(candidate: &Artifact, strikes: &[Strike]) -> ExecutorGate {
    let model = candidate.manifest.provenance.default_model;
    let planner = match Planner::new(candidate, model) {
        Ok(planner) => planner,
        Err(error) => {
            return ExecutorGate {
                passed: false,
                planned: 0,
                refused: 0,
                first: Some(format!("failed to {error}")),
            };
        }
    };
    let answers: Vec<_> = strikes
        .par_iter()
        .rev()
        .take(MOST_PLANS)
        .map(|strike| planner.plan(strike.initial, strike.stop))
        .collect();
    let refusals: Vec<_> = answers
        .iter()
        .filter_map(|answer| answer.as_ref().err())
        .collect();
    let planned = answers.len() - refusals.len();
    let diverged = refusals
        .iter()
        .any(|refusal| refusal.refused == Reason::Diverged);
    ExecutorGate {
        passed: planned > 0 && planned >= refusals.len() && !diverged,
        planned,
        refused: refusals.len(),
        first: refusals.first().map(ToString::to_string),
    }
}

/// Root mean square of the misses (m) that a version's plans expect on the paths of these strikes; none where it plans none of them.
pub fn promised(version: &Artifact, strikes: &[Strike]) -> Option<f64> {
    let planner = Planner::new(version, version.manifest.provenance.default_model).ok()?;
    let squares: Vec<f64> = strikes
        .par_iter()
        .rev()
        .take(MOST_PLANS)
        .filter_map(|strike| {
            planner
                .plan(strike.initial, strike.stop)
                .ok()?
                .expected_miss
        })
        .map(|miss| miss * miss)
        .collect();
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    (!squares.is_empty()).then(|| mean.sqrt())
}

impl ExecutorGate {
    pub fn sentence(&self) -> String {
        let mut text = format!(
            "the executor loads it and plans {} of the latest {} paths",
            self.planned,
            self.planned + self.refused
        );
        if let (false, Some(first)) = (self.passed, &self.first) {
            text += &format!(": too few ({first})");
        }
        text
    }
}
