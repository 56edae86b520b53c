//! Candidates fitted beside a model.

use std::collections::BTreeSet;

use rayon::prelude::*;
use world::WorldError;

use super::penalty::evidence_of;
use crate::{
    fit::{Fitted, Goal},
    screen::{Chance, Screened, Start},
    strikes::PreparedStrikes,
};

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
