//! What a diagnosis says: `diagnosis.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// The whole of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Diagnosis {
    /// What was found.
    pub verdict: Verdict,
    /// One sentence for a person.
    pub summary: String,
    /// Probability of a gap like this one, or a larger, if only launches and camera scattered.
    pub p_value: f64,
    /// Strikes that were looked at, the held-out ones apart.
    pub strikes: usize,
    /// What the gap depends on, the strongest first; empty where there is no gap.
    pub r#where: Vec<Where>,
    /// The effects named, in the order added.
    pub effects: Vec<Named>,
    /// Every candidate alone, the best first.
    pub ranking: Vec<Ranked>,
    /// How far the gap shrinks on strikes that took no part.
    pub gap: Gap,
    /// Strikes that would best separate the leading candidates.
    pub next_strikes: Vec<NextStrike>,
    /// For each candidate, the least size that these strikes would have shown.
    pub detectable: Vec<Detectable>,
    /// Sentences on what was dropped, or is short of data.
    pub notes: Vec<String>,
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
pub struct Where {
    /// `speed`, `angle`, `position`, `order`, `session`, `phase`, …
    pub covariate: String,
    /// In words.
    pub description: String,
    /// Corrected for the many looks.
    pub p_value: f64,
    /// Share of the gap's evidence that goes with it.
    pub share: f64,
}

/// An effect that was named.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Named {
    /// Name in the library.
    pub name: String,
    /// Its parameters.
    pub parameters: BTreeMap<String, Parameter>,
    /// One sentence that states the fitted values to a person.
    pub statement: String,
    /// Gain in log-likelihood that it brings beside the other effects named.
    pub evidence: f64,
    /// Candidates that these data cannot tell from it.
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
    /// How many.
    pub heldout_strikes: usize,
    /// In the world as identified, in `unit`.
    pub before: f64,
    /// With the effects named.
    pub after: f64,
    /// What repeats of a command would scatter by.
    pub noise_floor: f64,
    /// `m`.
    pub unit: String,
    /// `rms stop error`.
    pub measure: String,
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
    /// What it tells apart.
    pub why: String,
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

/// One strike's stop residual (measured less simulated, in m), for the pictures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Look {
    /// The strike.
    pub strike_id: String,
    /// Whether it took part in fit and choice.
    pub is_heldout: bool,
    /// Residual along and across the simulated path in the world as identified.
    pub before: [f64; 2],
    /// The same with the effects named; as before where none is.
    pub after: [f64; 2],
}
