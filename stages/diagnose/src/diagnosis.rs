//! What a diagnosis says: `diagnosis.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use values::Sentence;
use world::{AddedEffect, World};

use crate::words::{Cause, Dependence, Note, Purpose, StrayStrikes, Summary};

/// A diagnosis, as `diagnosis.json` holds it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Diagnosis {
    /// What was found.
    pub verdict: Verdict,
    /// One sentence for a person.
    pub summary: Sentence<Summary>,
    /// What stands behind a gap that no candidate explains, and what to do about it, where that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cause: Option<Sentence<Cause>>,
    /// Strikes that stop far from where the others do; none where there are no more than long tails have.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strays: Option<Sentence<StrayStrikes>>,
    /// Their ids.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stray_strikes: Vec<String>,
    /// Whether the latest strikes stop far from where those before do: the table, the object or the tip is another now.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_another_now: bool,
    /// Probability of a gap like this one, or a larger, if only launches, friction and camera scattered: the share of
    /// residuals drawn from the fitted noise that show as much, everything that was looked at counted. Never below
    /// 1/(1 + `replicates`), but where the arm's logged state shows a gap: then what its own test says, in both probabilities.
    pub p_value: f64,
    /// Probability of a gap like this one by chance, from flipping the signs of whole strikes' scores: it assumes no model of the noise.
    #[serde(default = "certain")]
    pub p_value_signs: f64,
    /// Number of residuals drawn from the fitted noise for `p_value`.
    #[serde(default)]
    pub replicates: usize,
    /// How repeats of one command differ, as estimated beside the effects named.
    #[serde(default)]
    pub noise: Noise,
    /// Strikes that were looked at, the held-out ones apart.
    pub strikes: usize,
    /// What the gap depends on, the strongest first; empty where there is no gap.
    pub r#where: Vec<GapDependence>,
    /// The effects named, in the order added.
    pub effects: Vec<NamedEffect>,
    /// Every candidate alone, the best first.
    pub ranking: Vec<Ranked>,
    /// How far the gap shrinks on held-out strikes, which took no part in the fit or the choice.
    pub gap: Gap,
    /// Strikes that would best separate the leading candidates.
    pub next_strikes: Vec<NextStrike>,
    /// For each candidate, the least size that these strikes would have shown.
    pub detectable: Vec<Detectable>,
    /// What was dropped, or is short of data.
    pub notes: Vec<Sentence<Note>>,
    /// How much of the gap smooth maps without physics would take; empty where there is no gap.
    #[serde(default)]
    pub maps: Vec<SmoothMap>,
}

impl Diagnosis {
    /// The probability that decided: of a gap of all candidates together, or, where there is one, of what it depends on.
    pub fn least_p_value(&self) -> f64 {
        let of_gap = self.r#where.iter().map(|found| found.p_value);
        of_gap.fold(self.p_value, f64::min)
    }
}

/// A smooth map of the launch over commands, or of friction over the table: what it would take of the gap, whatever its cause.
/// A launch map that takes most says to look at the arm, a friction map to look at the table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SmoothMap {
    /// `launch`, over the commanded speed (m/s) and angle (rad), or `friction`, over the table (m).
    pub name: String,
    /// Root mean square stop error in m without effects, of strikes that each fit leaves out.
    pub before: f64,
    /// Root mean square stop error in m with the map, of strikes that each fit leaves out.
    pub after: f64,
    /// Share of the squared stop error that it takes, 0 to 1.
    pub share: f64,
    /// The map, where strikes have been.
    pub points: Vec<MapPoint>,
}

/// One place of a smooth map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MapPoint {
    /// Commanded speed (m/s) and angle (rad), or x and y on the table (m).
    pub at: [f64; 2],
    /// Relative speed and angle (rad) of the launch beyond the command; or relative friction, and 0.
    pub change: [f64; 2],
}

fn certain() -> f64 {
    1.0
}

/// How repeats of one command differ: standard deviations, but for the correlation and the count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Standard deviation of the delivered speed, relative to the commanded.
    pub speed: f64,
    /// Standard deviation of the delivered angle, in rad.
    pub angle: f64,
    /// Standard deviation of friction from strike to strike, relative.
    pub friction: f64,
    /// Standard deviation of a centroid's coordinate, in m.
    pub camera: f64,
    /// Correlation of a centroid's error with that of the frame before.
    pub camera_correlation: f64,
    /// Standard deviation of a frame's stamp, in s.
    pub stamp_jitter: f64,
    /// Number of frames left out as outliers: far from where the rest of their strike puts them.
    pub frames_left_out: usize,
}

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// One effect or more explain the gap.
    Named,
    /// No gap beyond noise.
    Consistent,
    /// A gap that no candidate explains.
    Unexplained,
}

/// One covariate on which the gap depends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GapDependence {
    /// `speed`, `angle`, `position`, `order`, `session`, `phase`, …
    pub covariate: String,
    /// What the gap depends on, in a sentence.
    pub description: Sentence<Dependence>,
    /// Probability of such a dependence by chance, corrected for all dependences that were tested.
    pub p_value: f64,
    /// Square of how far this dependence moves stops, over the sum of the squares of all that are listed.
    pub share: f64,
}

/// An effect that was named.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NamedEffect {
    /// Name in the library.
    pub name: String,
    /// Its parameters.
    pub parameters: BTreeMap<String, Parameter>,
    /// One sentence that states the fitted values to a person.
    pub statement: Sentence<AddedEffect>,
    /// Gain in log-likelihood that it brings beside the other effects named.
    pub evidence: f64,
    /// Candidates that these data cannot distinguish from it.
    pub equivalent: Vec<String>,
    /// What other candidates bring in its place, the best first.
    #[serde(default)]
    pub rivals: Vec<Ranked>,
}

/// A fitted parameter with its 95 % interval.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// The value.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Unit; empty for a ratio.
    pub unit: String,
}

/// A candidate and what it brings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ranked {
    /// Name in the library.
    pub name: String,
    /// Gain in log-likelihood over the world without it, less what it would gain by chance.
    pub evidence: f64,
}

/// How far the gap shrinks on strikes that took no part in the fit or the choice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gap {
    /// Number of held-out strikes.
    pub heldout_strikes: usize,
    /// Root mean square stop error in the world as identified, in `unit`.
    pub before: f64,
    /// Root mean square stop error in the world with the effects named, in `unit`.
    pub after: f64,
    /// (`after` − `before`)/`before`; 0 where nothing is named.
    #[serde(default)]
    pub change: f64,
    /// Half of the change's 95 % interval, by each strike's own change; none of fewer than two strikes.
    #[serde(default)]
    pub change_half_95: Option<f64>,
    /// Root mean square stop error that repeats of one command would show, in `unit`: no model gets below it.
    pub noise_floor: f64,
    /// 95 % interval of `noise_floor`.
    #[serde(default)]
    pub noise_floor_95: [f64; 2],
    /// Root mean square motion of stops, in `unit`, by a slow random drift (wander) of the table or the arm over the order of strikes.
    #[serde(default)]
    pub wander: f64,
    /// 95 % interval of `wander`.
    #[serde(default)]
    pub wander_95: [f64; 2],
    /// Root mean square difference of stops between sessions, in `unit`.
    #[serde(default)]
    pub sessions: f64,
    /// 95 % interval of `sessions`.
    #[serde(default)]
    pub sessions_95: [f64; 2],
    /// Unit of the errors: `m`.
    pub unit: String,
    /// The measure of the errors: `rms stop error`.
    pub measure: String,
}

impl Gap {
    /// Whether a motion of stops is more than repeats scatter by.
    pub(crate) fn is_beyond_repeats(&self, by: f64) -> bool {
        by > self.noise_floor
    }

    /// Whether stops change over the order of strikes, or between sessions, by more than repeats scatter.
    pub fn varies(&self) -> bool {
        self.is_beyond_repeats(self.wander.max(self.sessions))
    }
}

impl Gap {
    /// The change with half of its 95 % interval, such as `-86 ± 12 %` or `+1.5 ± 8.0 %`.
    pub fn change_in_words(&self) -> String {
        /// Per cent from which a change is written without decimals.
        const WHOLE: f64 = 9.95;
        let change = 100.0 * self.change;
        match self.change_half_95.map(|half| 100.0 * half) {
            Some(half) if half >= WHOLE => format!("{change:+.0} ± {half:.0} %"),
            Some(half) => format!("{change:+.1} ± {half:.1} %"),
            None => format!("{change:+.0} %"),
        }
    }
}

/// A strike worth making.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NextStrike {
    /// Initial position along x, in m.
    pub x0: f64,
    /// Initial position along y, in m.
    pub y0: f64,
    /// Commanded speed, in m/s.
    pub speed: f64,
    /// Commanded angle, in rad.
    pub angle: f64,
    /// What this strike would separate, or measure.
    pub why: Sentence<Purpose>,
}

/// The least size of an effect that these strikes would have shown.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Detectable {
    /// The candidate.
    pub name: String,
    /// Its parameter of strength.
    pub parameter: String,
    /// The least value that would be found in four cases of five.
    pub least: f64,
    /// The parameter's unit.
    pub unit: String,
}

/// What was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Diagnosed {
    /// For people and files.
    pub diagnosis: Diagnosis,
    /// The identified world with the effects named, its parameters fitted again; none where nothing was named.
    pub world: Option<World>,
    /// Where nothing is named and there is a gap: the world that predicts strikes which were left out of its fits better than the one without effects. It
    /// claims no name.
    pub carried: Option<World>,
    /// Each strike's residual, before and after.
    pub residuals: Vec<StopResidual>,
}

impl Diagnosed {
    /// The world with effects that serves predictions, named or not.
    pub fn used(&self) -> Option<&World> {
        self.world.as_ref().or(self.carried.as_ref())
    }
}

/// One strike's stop residual (measured less simulated, in m), for the pictures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StopResidual {
    /// The strike.
    pub strike_id: String,
    /// Whether it took part in fit and choice.
    pub is_heldout: bool,
    /// Residual along and across the simulated path in the world as identified.
    pub before: [f64; 2],
    /// Residual along and across the simulated path in the world with the effects named; equal to `before` where none is.
    pub after: [f64; 2],
}
