//! `manifest.json`: what a version holds and how it came to be.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use durable::sha256;
use serde::{Deserialize, Serialize};
use values::{Interval, Point, StopErrors};
use world::Varies;

use crate::Model;

/// What a version holds and how it came to be. It holds no time or place of its making: the same inputs, settings and
/// programs give the same bytes.
///
/// Its first key is its own hash, so that a changed digit shows without a key, too. Anybody can compute a hash: it shows damage,
/// not who wrote it. That is what a signature is for, a file of its own beside it; through the hashes here it covers all files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// SHA-256 of this file's bytes with zeros in the place of these 64 hex digits.
    pub sha256: String,
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
    /// How it came to be and how good it is; in the file, its keys are at the same level as those above.
    #[serde(flatten)]
    pub provenance: Provenance,
}

/// How a version came to be and how good it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// The model to use unless another is requested.
    pub default_model: Model,
    /// Stop errors on held-out strikes, by model.
    pub metrics: BTreeMap<Model, StopErrors>,
    /// Scatter of repeats of one command, in the same terms.
    pub noise_floor: Option<StopErrors>,
    /// What the training of a model's residual explains, by model; what is beyond, the executor refuses. Models without a residual
    /// are not among them, nor any in older versions.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub explained: BTreeMap<Model, TrainingExtent>,
    /// How the table varies beside each model: what recent strikes are judged by. None in older versions.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub varies: BTreeMap<Model, Varies>,
    /// The region of the strikes that it learnt from.
    pub trained_region: TrainedRegion,
    /// The strikes that it was computed from; none in older versions.
    #[serde(default)]
    pub strikes: Option<Logged>,
    /// Where its worlds come from, if they were not identified but moved; none otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moved: Option<Moved>,
    /// Whether effects that the data name were kept out of the world on request.
    #[serde(default)]
    pub without_effects: bool,
    /// Where everything random came from, by what it was drawn for.
    pub seeds: BTreeMap<String, u64>,
    /// The logs it was computed from.
    pub inputs: Vec<InputFile>,
    /// The stages that computed it, with their settings, in order.
    pub stages: Vec<StageRecord>,
}

/// The strikes that a version was computed from: where the order of later ones begins.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Logged {
    /// Number of strikes; also the order of the next one, for effects that drift.
    pub count: usize,
    /// Stamp of the last one's first motion, in seconds since the epoch of the logs' clock.
    pub last: f64,
}

/// An earlier version whose worlds were moved to where strikes have the table since it changed for good.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Moved {
    /// The earlier version.
    pub version: String,
    /// Strikes that show where the table is.
    pub strikes: usize,
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

/// What the training of a residual explains. Distances are shares of the path's length: a miss grows with it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingExtent {
    /// Strikes that it learnt from.
    pub strikes: usize,
    /// Least and greatest speed that it adds on them, in m/s.
    pub d_speed: Interval,
    /// Least and greatest angle that it adds on them, in rad.
    pub d_angle: Interval,
    /// Largest distance between a measured stop and the stop that the world without the residual gives to the command that was sent.
    pub displacement: f64,
    /// Mean distance between measured and predicted stop, each predicted by a residual that learnt from other commands.
    pub miss: f64,
    /// The distance that one in twenty of them exceeds.
    pub miss_p95: f64,
    /// Factor on the distance that the residual itself expects; one where it expects none.
    pub calibration: f64,
}

impl TrainingExtent {
    /// Each distance and factor with its name.
    pub(crate) fn shares(&self) -> [(&'static str, f64); 4] {
        [
            ("displacement", self.displacement),
            ("miss", self.miss),
            ("miss_p95", self.miss_p95),
            ("calibration", self.calibration),
        ]
    }
}

/// Bounds of what was learnt from, ends included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainedRegion {
    /// Length of the path, in m.
    pub distance: Interval,
    /// Bearing of the path, in rad: the shortest arc that holds all. Its low end lies in (−π, π], its high end beyond π
    /// where the arc passes it; see [`TrainedRegion::holds_bearing`].
    pub bearing: Interval,
    /// The stop's x, in m.
    pub stop_x: Interval,
    /// The stop's y, in m.
    pub stop_y: Interval,
    /// The start's x, in m; none in older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start_x: Option<Interval>,
    /// The start's y, in m; none in older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start_y: Option<Interval>,
}

impl TrainedRegion {
    /// The bounds of strikes with these starts and stops, in m; none where there are no strikes.
    pub fn of(strikes: impl Iterator<Item = (Point, Point)> + Clone) -> Option<Self> {
        let paths = strikes.clone().map(|(initial, stop)| stop - initial);
        Some(Self {
            distance: bounds(paths.clone().map(Point::norm))?,
            bearing: arc(paths.map(Point::bearing).collect())?,
            stop_x: bounds(strikes.clone().map(|(_, stop)| stop.x))?,
            stop_y: bounds(strikes.clone().map(|(_, stop)| stop.y))?,
            start_x: bounds(strikes.clone().map(|(initial, _)| initial.x)),
            start_y: bounds(strikes.map(|(initial, _)| initial.y)),
        })
    }

    /// Whether a bearing in (−π, π] lies among those learnt from.
    pub fn holds_bearing(&self, bearing: f64) -> bool {
        [bearing, bearing + TAU]
            .into_iter()
            .any(|bearing| self.bearing.contains(bearing))
    }

    pub(crate) fn bounds(&self) -> impl Iterator<Item = (&'static str, Interval)> {
        [
            ("trained_region.distance", Some(self.distance)),
            ("trained_region.bearing", Some(self.bearing)),
            ("trained_region.stop_x", Some(self.stop_x)),
            ("trained_region.stop_y", Some(self.stop_y)),
            ("trained_region.start_x", self.start_x),
            ("trained_region.start_y", self.start_y),
        ]
        .into_iter()
        .filter_map(|(name, bound)| Some((name, bound?)))
    }
}

fn bounds(numbers: impl Iterator<Item = f64>) -> Option<Interval> {
    numbers
        .map(|number| Interval::new(number, number))
        .reduce(|all, one| Interval::new(all.low.min(one.low), all.high.max(one.high)))
}

/// The shortest arc that holds all bearings: what it leaves out is the widest gap between neighbours.
fn arc(mut bearings: Vec<f64>) -> Option<Interval> {
    bearings.sort_by(f64::total_cmp);
    let (first, last) = (*bearings.first()?, *bearings.last()?);
    let mut arc = Interval::new(first, last);
    let mut widest = first + TAU - last;
    for pair in bearings.windows(2) {
        if pair[1] - pair[0] > widest {
            widest = pair[1] - pair[0];
            arc = Interval::new(pair[1], pair[0] + TAU);
        }
    }
    Some(arc)
}

/// In the place of a manifest's own hash while it is computed.
const UNSEALED: &str = "0000000000000000000000000000000000000000000000000000000000000000";

impl Manifest {
    /// This manifest with its own hash.
    pub(crate) fn sealed(self) -> Self {
        let mut sealed = Self {
            sha256: UNSEALED.into(),
            ..self
        };
        sealed.sha256 = sha256(sealed.to_json().as_bytes());
        sealed
    }

    /// The hash that this manifest, read from these bytes, must hold.
    pub(crate) fn seal(&self, bytes: &[u8]) -> String {
        let text = String::from_utf8_lossy(bytes);
        sha256(text.replacen(&self.sha256, UNSEALED, 1).as_bytes())
    }

    /// The text of `manifest.json`; the same value always gives the same bytes.
    pub fn to_json(&self) -> String {
        let mut text =
            serde_json::to_string_pretty(self).expect("a manifest is plain data with text keys");
        text.push('\n');
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn region(bearings: &[f64]) -> TrainedRegion {
        let strike = |bearing| (Point::default(), Point::polar(0.3, bearing));
        let strikes: Vec<_> = bearings.iter().copied().map(strike).collect();
        TrainedRegion::of(strikes.into_iter()).expect("strikes")
    }

    #[test]
    fn bearings_about_the_negative_axis_are_one_short_arc() {
        let back = region(&[3.0, -3.1, 3.1, -2.9]);
        assert!((back.bearing.low - 3.0).abs() < 1e-12);
        assert!((back.bearing.high - (TAU - 2.9)).abs() < 1e-12);
        for (bearing, held) in [(3.0, true), (3.13, true), (-3.13, true), (-2.91, true)]
            .into_iter()
            .chain([(2.9, false), (-2.8, false), (0.0, false), (f64::NAN, false)])
        {
            assert_eq!(back.holds_bearing(bearing), held, "{bearing}");
        }
    }

    #[test]
    fn every_bearing_learnt_from_is_held() {
        for bearings in [
            vec![0.4],
            vec![-0.5, 0.1, 0.7],
            vec![2.5, -2.5],
            (0..63).map(|i| f64::from(i) * 0.1 - 3.1).collect(),
        ] {
            let region = region(&bearings);
            for bearing in bearings {
                let held = Point::polar(0.3, bearing).bearing();
                assert!(region.holds_bearing(held), "{bearing}");
            }
        }
        assert_eq!(
            region(&[-0.5, 0.7]).bearing.low,
            Point::polar(0.3, -0.5).bearing()
        );
    }
}
