//! Which effects: forward by evidence, replaced and dropped again where that is better.
//!
//! An effect is added where its score is no chance, with the smooth dependences that a wrong form of the effects held would
//! leave standing beside the model, and where its fit brings more than chance and form do ([`forward`]). After each, the noise
//! is estimated anew, and every effect held is asked whether another fits better in its place ([`refine`]).

mod fits;
mod forward;
mod last_resort;
mod penalty;
mod refine;

pub(crate) use fits::CandidateFit;
pub(crate) use forward::{Limits, search};
pub(crate) use last_resort::{with_last_resorts, with_replacements, with_special_cases};
pub(crate) use refine::{least_that_moves_little, with_rivals, with_wander, without};

use crate::{fit::Fitted, screen::Screened, strikes::PreparedStrikes};

/// What a search ends with.
pub(crate) struct Selection<'a> {
    /// The strikes with the noise and frames of the model found.
    pub(crate) prepared: PreparedStrikes<'a>,
    /// The world without effects, under the same noise.
    pub(crate) null: Fitted,
    pub(crate) fitted: Fitted,
    /// For each of the model's effects, its evidence beside the others and its rivals.
    pub(crate) effects: Vec<SelectedEffect>,
}

impl Selection<'_> {
    /// The effects' names.
    fn names(&self) -> Vec<&'static str> {
        self.effects.iter().map(|effect| effect.name).collect()
    }

    /// This selection with `fitted` as its model; its effects are not assessed yet.
    fn holding(self, fitted: Fitted) -> Self {
        Self {
            fitted,
            effects: Vec::new(),
            ..self
        }
    }

    /// Gain in log-likelihood of all effects together.
    pub(crate) fn gain(&self) -> f64 {
        self.fitted.likelihood() - self.null.likelihood()
    }
}

/// An effect of a model, with the evidence for it and what could replace it.
#[derive(Clone, Debug)]
pub(crate) struct SelectedEffect {
    pub(crate) name: &'static str,
    pub(crate) evidence: f64,
    /// The model without it, where one can be fitted.
    pub(crate) fit_without: Option<Fitted>,
    /// The screening of all candidates in the model without it, where that was made.
    screened: Option<Vec<Screened>>,
    /// Effects that the data do not exclude in its place.
    pub(crate) equivalent: Vec<&'static str>,
    /// Models with another effect in its place, the best first.
    pub(crate) rivals: Vec<CandidateFit>,
}
