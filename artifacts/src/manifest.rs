//! `manifest.json`: what a version holds and how it came to be.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use values::{Interval, Point};

use crate::Model;

/// What a version holds and how it came to be. It holds no time, place or machine: the same inputs, settings and
/// programs give the same bytes.
///
/// A signature, where one is wanted, is a file of its own beside it: through the hashes here it covers all files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Version of the layout, [`SCHEMA_VERSION`](crate::SCHEMA_VERSION).
    pub schema: u32,
    /// Version of carom that wrote it.
    pub carom: String,
    /// Version of MuJoCo that its worlds were identified with.
    pub mujoco: String,
    /// SHA-256 of the rig's settings, comments and order aside: what set-up this version is for.
    pub rig: String,
    /// Every file of the version but this one, by name.
    pub files: BTreeMap<String, FileHash>,
    /// The model to use unless another is asked for.
    pub default_model: Model,
    /// Stop errors on held-out strikes, by model.
    pub metrics: BTreeMap<Model, Metrics>,
    /// What repeats of one command scatter by, in the same terms.
    pub noise_floor: Option<Metrics>,
    /// Where the strikes lie that it learnt from.
    pub trained_region: TrainedRegion,
    /// Where everything random came from, by what it was drawn for.
    pub seeds: BTreeMap<String, u64>,
    /// The logs it was computed from.
    pub inputs: Vec<InputFile>,
    /// The stages that computed it, with their settings, in order.
    pub stages: Vec<StageRecord>,
}

/// What a file must be.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileHash {
    /// SHA-256 of its content, 64 hex digits.
    pub sha256: String,
    /// Its length in bytes.
    pub size: u64,
}

/// A log that a version was computed from.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputFile {
    /// File name, without folder.
    pub name: String,
    /// SHA-256 of its content, 64 hex digits.
    pub sha256: String,
    /// Its length in bytes.
    pub size: u64,
}

/// How a stage was run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StageRecord {
    /// The stage's name.
    pub name: String,
    /// The stage's version.
    pub version: u32,
    /// Its settings.
    pub settings: serde_json::Value,
}

/// Stop errors of a model, in m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Metrics {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub sd: f64,
    /// Median.
    pub median: f64,
    /// 95th percentile.
    pub p95: f64,
    /// Number of strikes.
    pub n: usize,
    /// Strikes for which the model predicts no stop; they are in none of the numbers above.
    pub failed: usize,
}

/// Bounds of what was learnt from, ends included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainedRegion {
    /// Length of the path, in m.
    pub distance: Interval,
    /// Bearing of the path, in rad.
    pub bearing: Interval,
    /// The stop's x, in m.
    pub stop_x: Interval,
    /// The stop's y, in m.
    pub stop_y: Interval,
}

impl TrainedRegion {
    /// The bounds of strikes with these starts and stops, in m; none where there are no strikes.
    pub fn of(strikes: impl Iterator<Item = (Point, Point)> + Clone) -> Option<Self> {
        let paths = strikes.clone().map(|(initial, stop)| stop - initial);
        Some(Self {
            distance: bounds(paths.clone().map(Point::norm))?,
            bearing: bounds(paths.map(Point::bearing))?,
            stop_x: bounds(strikes.clone().map(|(_, stop)| stop.x))?,
            stop_y: bounds(strikes.map(|(_, stop)| stop.y))?,
        })
    }

    /// Each bound with its name.
    pub(crate) fn bounds(&self) -> [(&'static str, Interval); 4] {
        [
            ("trained_region.distance", self.distance),
            ("trained_region.bearing", self.bearing),
            ("trained_region.stop_x", self.stop_x),
            ("trained_region.stop_y", self.stop_y),
        ]
    }
}

fn bounds(numbers: impl Iterator<Item = f64>) -> Option<Interval> {
    numbers
        .map(|number| Interval {
            low: number,
            high: number,
        })
        .reduce(|all, one| Interval {
            low: all.low.min(one.low),
            high: all.high.max(one.high),
        })
}

impl Manifest {
    /// The text of `manifest.json`; the same value always gives the same bytes.
    pub fn to_json(&self) -> String {
        let mut text =
            serde_json::to_string_pretty(self).expect("a manifest is plain data with text keys");
        text.push('\n');
        text
    }
}
