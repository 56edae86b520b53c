//! Which effects: forward by evidence, replaced and dropped again where that is better.
//!
//! An effect is added where its score is no chance, with the smooth dependences that a wrong form of the effects held would
//! leave standing beside the model, and where its fit brings more than chance and form do ([`forward`]). After each, the noise
//! is estimated anew, and every effect held is asked whether another fits better in its place ([`refine`]).

mod forward;
mod last_resort;
mod refine;

use std::collections::BTreeSet;

use rayon::prelude::*;
use world::WorldError;
use world::effects::{Naming, effect};

use crate::Thresholds;
use crate::fit::{Fitted, Goal};
use crate::screen::{Chance, Screened, Start};
use crate::strikes::PreparedStrikes;

pub(crate) use forward::{Limits, search};
pub(crate) use last_resort::{beside, with_last_resorts, with_replacements, with_special_cases};
pub(crate) use refine::{least_that_moves_little, with_details, with_rivals, with_wander, without};

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

/// Effects that do the same as this one by construction, or nearly so.
pub(super) fn alike(name: &str) -> &'static [&'static str] {
    effect(name).map_or(&[], |spec| spec.equivalent)
}

/// Gain in log-likelihood of an effect that frees so many values, less what it would gain by chance, and less what is asked
/// of an effect that contains a simpler one.
pub(super) fn evidence_of(
    name: &'static str,
    gain: f64,
    freed: usize,
    chance: f64,
    thresholds: &Thresholds,
) -> f64 {
    let further = if simpler(name).is_empty() {
        0.0
    } else {
        thresholds.contains * gain.max(0.0)
            + thresholds.contains_value * freed.saturating_sub(1) as f64
    };
    gain - chance - further
}

/// Effects that are one's special cases.
pub(super) fn simpler(name: &str) -> &'static [&'static str] {
    effect(name).map_or(&[], |spec| spec.contains)
}

/// Whether an effect has a value at each of many places.
pub(super) fn is_field(name: &str) -> bool {
    let spec = effect(name);
    spec.is_ok_and(|spec| matches!(spec.naming, Naming::LastResort | Naming::InPlace))
}

/// Greatest number of candidates fitted at each step, the best by their linear gains.
const FITTED: usize = 5;
/// Starts of each candidate, and further ones where none of these leads to a possible model.
const STARTS: usize = 2;

/// A candidate fitted beside a model.
#[derive(Clone, Debug)]
pub(crate) struct CandidateFit {
    pub(crate) fitted: Fitted,
    pub(crate) name: &'static str,
    /// Gain in log-likelihood less what the candidate would gain by chance.
    pub(crate) evidence: f64,
}

/// Which candidates are fitted.
#[derive(Clone, Copy)]
pub(super) struct FitCriteria<'r> {
    /// Names of candidates that are fitted in any case.
    pub(super) required: &'r [&'r str],
    /// Least linear gain of a candidate; none: a share of the best candidate's, which is fitted in any case.
    pub(super) least_gain: Option<f64>,
    /// Evidence that decides: how far below it a candidate stays is not computed.
    pub(super) least_evidence: f64,
}

impl Default for FitCriteria<'_> {
    fn default() -> Self {
        Self {
            required: &[],
            least_gain: None,
            least_evidence: f64::NEG_INFINITY,
        }
    }
}

/// The candidates worth a fit, each fitted beside a model from the best of its starts; the best first. A linear gain predicts that of the fit
/// to some per cent, so that those far behind stay there.
pub(super) fn fit_best(
    prepared: &PreparedStrikes<'_>,
    from: &Fitted,
    screened: &[Screened],
    chance: &Chance,
    criteria: FitCriteria<'_>,
) -> Result<Vec<CandidateFit>, WorldError> {
    fit_possible(
        prepared,
        from,
        screened,
        chance,
        criteria,
        &mut BTreeSet::new(),
    )
}

/// [`fit_best`] where some are known to lead to no possible model beside this one; those that now prove to are added to them.
pub(super) fn fit_possible(
    prepared: &PreparedStrikes<'_>,
    from: &Fitted,
    screened: &[Screened],
    chance: &Chance,
    criteria: FitCriteria<'_>,
    impossible: &mut BTreeSet<&'static str>,
) -> Result<Vec<CandidateFit>, WorldError> {
    let thresholds = prepared.thresholds;
    let beyond_chance = |s: &Screened| s.gain() - chance[s.name];
    let mut order: Vec<&Screened> = screened.iter().collect();
    order.sort_by(|a, b| beyond_chance(b).total_cmp(&beyond_chance(a)));
    let best = order.first().map_or(0.0, |best| best.gain());
    let least = criteria.least_gain.unwrap_or(thresholds.fitted * best);
    let fits: Vec<(&'static str, Option<CandidateFit>)> = order
        .into_par_iter()
        .enumerate()
        .filter(|(rank, s)| {
            let is_best = *rank == 0 && !criteria.least_evidence.is_finite();
            let is_near = is_best || *rank < FITTED && s.gain() >= least;
            (is_near || criteria.required.contains(&s.name)) && !impossible.contains(s.name)
        })
        .map(|(_, s)| {
            // Of its forms, the one that brings most for its values. A strength at the end of its range stands for something else.
            let mut possible: Option<Fitted> = None;
            let with = from.likelihood() + chance[s.name] + criteria.least_evidence;
            let goal = Goal::Compared { with };
            for (rank, start) in s.starts.iter().enumerate() {
                if rank >= STARTS && possible.is_some() {
                    break;
                }
                let found = fit(prepared, from, start, goal)?;
                let better = found.filter(|found| {
                    found.model.is_possible()
                        && possible
                            .as_ref()
                            .is_none_or(|best| worth(found) > worth(best))
                });
                possible = better.or(possible);
            }
            let fit = possible.map(|fitted| CandidateFit {
                evidence: evidence_of(
                    s.name,
                    fitted.likelihood() - from.likelihood(),
                    fitted.model.free.len() - from.model.free.len(),
                    chance[s.name],
                    thresholds,
                ),
                name: s.name,
                fitted,
            });
            Ok((s.name, fit))
        })
        .collect::<Result<_, WorldError>>()?;
    let none = fits.iter().filter(|(_, fit)| fit.is_none());
    impossible.extend(none.map(|(name, _)| *name));
    let mut fits: Vec<CandidateFit> = fits.into_iter().filter_map(|(_, fit)| fit).collect();
    fits.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    Ok(fits)
}

/// Log-likelihood less the number of free values (Akaike's criterion).
fn worth(fitted: &Fitted) -> f64 {
    fitted.likelihood() - fitted.model.free.len() as f64
}

/// Fits a candidate from a start; from where the model stands, if the start's step was too long or led to an impossible model.
fn fit(
    prepared: &PreparedStrikes<'_>,
    from: &Fitted,
    start: &Start,
    goal: Goal,
) -> Result<Option<Fitted>, WorldError> {
    let fitted = prepared.fit(&start.model, &start.components, &start.nuisances, goal)?;
    if fitted
        .as_ref()
        .is_some_and(|fitted| fitted.likelihood() > from.likelihood() && fitted.model.is_possible())
    {
        return Ok(fitted);
    }
    let own = from.model.values.len();
    let mut model = start.model.clone();
    model.values[..own].copy_from_slice(&from.model.values);
    prepared.fit_from(from, &model, goal)
}
