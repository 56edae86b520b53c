//! Which effects: forward by evidence, replaced and dropped again where that is better.
//!
//! An effect is added where its score is no chance, with the smooth dependences that a wrong form of the effects held would
//! leave standing beside the model, and where its fit brings more than chance and form do ([`forward`]). After each, the noise
//! is estimated anew, and every effect held is asked whether another fits better in its place ([`refine`]).

mod fits;
mod forward;
mod refine;

pub(crate) use fits::{CandidateFit, EXCLUDED};
pub(crate) use forward::{Limits, search};
pub(crate) use refine::without;

use crate::{fit::Fitted, strikes::PreparedStrikes};

/// What a search ends with.
pub(crate) struct Selection<'a> {
    /// The strikes with the noise and frames of the model found.
    pub(crate) field: PreparedStrikes<'a>,
    /// The world without effects, under the same noise.
    pub(crate) null: Fitted,
    pub(crate) fitted: Fitted,
    /// For each of the model's effects, its evidence beside the others, and who could stand in its place.
    pub(crate) effects: Vec<SelectedEffect>,
}

impl Selection<'_> {
    /// The effect that stands least firmly, if others stand beside it and its evidence is less than `left`.
    pub(crate) fn weaker_than(&self, left: f64) -> Option<usize> {
        let (place, weakest) = self
            .effects
            .iter()
            .enumerate()
            .min_by(|a, b| a.1.evidence.total_cmp(&b.1.evidence))?;
        (self.effects.len() > 1 && weakest.evidence < left).then_some(place)
    }

    /// Gain in log-likelihood of all effects together.
    pub(crate) fn gain(&self) -> f64 {
        self.fitted.likelihood() - self.null.likelihood()
    }
}

/// An effect of a model, and how firmly it stands there.
#[derive(Clone, Debug)]
pub(crate) struct SelectedEffect {
    pub(crate) name: &'static str,
    pub(crate) evidence: f64,
    /// Effects that the data do not exclude in its place.
    pub(crate) equivalent: Vec<&'static str>,
    /// Models with another effect in its place, the best first.
    pub(crate) rivals: Vec<CandidateFit>,
}

/// Effects that do the same by construction, or nearly so.
fn alike(name: &str) -> &'static [&'static str] {
    world::effects::effect(name).map_or(&[], |spec| spec.equivalent)
}

/// Share of what an effect gains that one which contains a simpler effect must bring beyond it: what is left by a form that is not
/// quite the simpler one's is no reason for the other.
const CONTAINS_SHARE: f64 = 0.02;
/// Evidence that each further value of such an effect must bring.
const CONTAINS_VALUE: f64 = 2.0;

/// Gain in log-likelihood of an effect that frees so many values, less what it would gain by chance, and less what is asked
/// of an effect that contains a simpler one.
fn evidence_of(name: &'static str, gain: f64, freed: usize, chance: f64) -> f64 {
    let further = if simpler(name).is_empty() {
        0.0
    } else {
        CONTAINS_SHARE * gain.max(0.0) + CONTAINS_VALUE * freed.saturating_sub(1) as f64
    };
    gain - chance - further
}

/// Effects that are one's special cases.
fn simpler(name: &str) -> &'static [&'static str] {
    world::effects::effect(name).map_or(&[], |spec| spec.contains)
}
