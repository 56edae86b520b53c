//! Candidates fitted beside a model.

use std::collections::BTreeMap;

use rayon::prelude::*;
use world::WorldError;

use super::penalty::evidence_of;
use crate::{
    fit::{Fitted, ITERATIONS, TRIAL_ITERATIONS},
    screen::{Chance, Screened, Start},
    strikes::PreparedStrikes,
};

/// Candidates that are fitted at each step, the best by their scores, and starts of each.
const FITTED: usize = 5;
const STARTS: usize = 2;

/// A candidate fitted beside a model.
#[derive(Clone, Debug)]
pub(crate) struct CandidateFit {
    pub(crate) fitted: Fitted,
    pub(crate) name: &'static str,
    /// Gain in log-likelihood less what the candidate would gain by chance.
    pub(crate) evidence: f64,
}

impl CandidateFit {
    /// As Akaike would have it.
    fn penalised_evidence(&self) -> f64 {
        self.evidence - self.fitted.model.free.len() as f64
    }
}

/// Fits beside one model, by candidate and start: what was fitted once is not fitted again.
pub(super) type Tried = BTreeMap<(&'static str, usize), Option<CandidateFit>>;

/// Which candidates are fitted, and to the end, beside the best of them.
#[derive(Clone, Copy, Default)]
pub(super) struct FitCriteria<'r> {
    /// Those that are fitted in any case.
    pub(super) required: &'r [&'r str],
    /// Evidence of the effect in whose place candidates are tried: they must come near to it, as to the best of them. Zero where there is none.
    pub(super) incumbent_evidence: f64,
    /// Its gain by score, no more than its evidence.
    pub(super) incumbent_gain: f64,
}

/// The candidates worth a fit, each fitted beside a model; the best first.
pub(super) fn fit_best(
    prepared: &PreparedStrikes<'_>,
    from: &Fitted,
    screened: &[Screened],
    chance: &Chance,
    criteria: FitCriteria<'_>,
    tried: &mut Tried,
) -> Result<Vec<CandidateFit>, WorldError> {
    let thresholds = prepared.thresholds;
    let starts = promising(screened, chance, criteria, thresholds.fitted);
    let of = |name: &'static str, fitted: Fitted| CandidateFit {
        evidence: evidence_of(
            name,
            fitted.likelihood() - from.likelihood(),
            fitted.model.free.len() - from.model.free.len(),
            chance[name],
            thresholds,
        ),
        name,
        fitted,
    };
    let begun: Vec<_> = starts
        .par_iter()
        .filter(|(key, _)| !tried.contains_key(key))
        .map(|(key, start)| {
            let fitted = begin(prepared, from, start)?;
            Ok((*key, fitted.map(|fitted| of(key.0, fitted))))
        })
        .collect::<Result<_, WorldError>>()?;
    tried.extend(begun);
    let begun: Vec<_> = starts
        .iter()
        .filter_map(|(key, _)| Some((*key, tried[key].as_ref()?)))
        .collect();
    let best = begun
        .iter()
        .map(|(_, fit)| fit.evidence)
        .fold(criteria.incumbent_evidence, f64::max);
    let fits: Vec<_> = begun
        .into_par_iter()
        .map(|(key, begun)| {
            // Far behind after its first iterations, it is left there: a rival all the same, if a poor one.
            let is_behind = begun.evidence < thresholds.fitted_to_end * best;
            if is_behind && !criteria.required.contains(&begun.name) {
                return Ok((key, begun.clone()));
            }
            let fitted = prepared.further(begun.fitted.clone(), ITERATIONS - TRIAL_ITERATIONS)?;
            Ok((key, of(begun.name, fitted)))
        })
        .collect::<Result<_, WorldError>>()?;
    tried.extend(fits.iter().map(|(key, fit)| (*key, Some(fit.clone()))));
    Ok(best_of_each(fits.into_iter().map(|(_, fit)| fit)))
}

type Key = (&'static str, usize);

/// The starts that are worth a fit, at least this share of the best one's gain each.
fn promising<'s>(
    screened: &'s [Screened],
    chance: &Chance,
    criteria: FitCriteria<'_>,
    least: f64,
) -> Vec<(Key, &'s Start)> {
    let mut order: Vec<&Screened> = screened.iter().collect();
    order.sort_by(|a, b| (b.gain() - chance[b.name]).total_cmp(&(a.gain() - chance[a.name])));
    let best = order.first().map_or(0.0, |best| best.gain());
    let least = least * best.max(criteria.incumbent_gain);
    order
        .into_iter()
        .enumerate()
        .filter(|(rank, s)| {
            (*rank < FITTED && s.gain() >= least) || criteria.required.contains(&s.name)
        })
        .flat_map(|(_, s)| {
            let starts = s.starts.iter().take(STARTS).enumerate();
            starts.map(|(i, start)| ((s.name, i), start))
        })
        .collect()
}

/// The first iterations of a fit.
fn begin(
    prepared: &PreparedStrikes<'_>,
    from: &Fitted,
    start: &Start,
) -> Result<Option<Fitted>, WorldError> {
    let fitted = prepared.fit(
        &start.model,
        &start.components,
        &start.nuisances,
        TRIAL_ITERATIONS,
    )?;
    if fitted
        .as_ref()
        .is_some_and(|fitted| fitted.likelihood() > from.likelihood())
    {
        return Ok(fitted);
    }
    // A whole step was too long: from where the model stands.
    let own = from.model.values.len();
    let mut model = start.model.clone();
    model.values[..own].copy_from_slice(&from.model.values);
    prepared.fit(
        &model,
        &from.estimated.components,
        &from.nuisances,
        TRIAL_ITERATIONS,
    )
}

/// The best fit of each candidate, of those whose strength is within its range.
fn best_of_each(fits: impl Iterator<Item = CandidateFit>) -> Vec<CandidateFit> {
    let mut best: Vec<CandidateFit> = Vec::new();
    for fit in fits.filter(|fit| fit.fitted.model.is_possible()) {
        match best.iter_mut().find(|other| other.name == fit.name) {
            Some(other) if other.penalised_evidence() >= fit.penalised_evidence() => {}
            Some(other) => *other = fit,
            None => best.push(fit),
        }
    }
    best.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    best
}
