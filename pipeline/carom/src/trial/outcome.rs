//! What came of a trial: `trial.json`.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use values::{Point, StopErrors};

pub const FILE: &str = "trial.json";

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TargetStrike {
    /// Where the object rested, in m.
    pub from: Point,
    /// Where it was to stop, in m.
    pub to: Point,
    /// Commanded speed in m/s.
    pub speed: f64,
    /// Commanded angle in rad.
    pub angle: f64,
    /// Where the camera saw it stop, in m.
    pub stop: Point,
    /// Distance from target to stop, in m.
    pub error: f64,
    /// What the plan expected that to be, in m; none where the version does not state it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected_miss: Option<f64>,
}

/// A target that a model's planner refused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Refused {
    /// Where the object rested, in m.
    pub from: Point,
    /// Where it was to stop, in m.
    pub to: Point,
    /// Reason and detail.
    pub refused: String,
}

/// How a model did.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Stop errors; none where every target was refused.
    #[serde(flatten)]
    pub errors: Option<StopErrors>,
    /// Mean of what the plans expected, in m; none where a version does not state it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected_miss: Option<f64>,
    pub strikes: Vec<TargetStrike>,
    /// Every target refused, which no number above counts.
    pub refusals: Vec<Refused>,
}

impl Outcome {
    /// Sums up its strikes.
    pub fn summed_up(mut self) -> Self {
        self.errors = StopErrors::of(self.strikes.iter().map(|strike| strike.error));
        let expected = self.strikes.iter().map(|strike| strike.expected_miss);
        let expected: Option<Vec<f64>> = expected.collect();
        self.expected_miss = expected
            .and_then(|expected| StopErrors::of(expected.into_iter()))
            .map(|expected| expected.mean);
        self
    }
}

/// The random targets struck again in sessions that the version has never seen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NewSessions {
    pub sessions: usize,
    /// Each target struck once, in one of the sessions; by model.
    #[serde(flatten)]
    pub models: BTreeMap<String, Outcome>,
}

/// What `trial.json` holds: a key for each model (its random targets), `noise_floor`, `figure_8` and `new_sessions`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Version that struck.
    pub artifact: String,
    /// Which rig was struck.
    pub robot: String,
    /// Random targets drawn, those included that the reference model refused.
    pub drawn: usize,
    /// The paper's Figure 8: two starts, four targets each, struck several times; by model.
    pub figure_8: BTreeMap<String, Outcome>,
    /// Distances of repeats of one command from their mean: what no model can better.
    pub noise_floor: Option<StopErrors>,
    /// The session that all of this was struck in but `new_sessions`: the last one that was logged; none where the rig was not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub session: Option<String>,
    /// Strikes at random targets in new sessions; none where none was requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub new_sessions: Option<NewSessions>,
    /// Random targets, struck once; by model.
    #[serde(flatten)]
    pub models: BTreeMap<String, Outcome>,
}

/// An earlier trial in a run's folder; none where there is none or it is not readable.
pub fn kept(dir: &Path) -> Option<Trial> {
    let text = std::fs::read_to_string(dir.join(FILE)).ok()?;
    serde_json::from_str(&text).ok()
}
