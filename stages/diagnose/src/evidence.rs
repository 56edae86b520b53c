//! Whether: is there a gap at all?

use std::collections::BTreeMap;

use statrs::statistics::{Data, OrderStatistics};

use crate::{
    screen::{Chance, Screened},
    search::EXCLUDED,
    smooth::Dependence,
};

/// Residuals drawn from the fitted world without effects, to know what chance gains.
pub(crate) const REPLICATES: usize = 200;
/// A gap is real from this probability of chance on.
pub(crate) const REAL: f64 = 0.01;
/// Quantile of the replicates that a candidate must exceed; what many candidates gain together comes on top.
const QUANTILE: f64 = 0.99;

/// What each candidate gains by chance.
pub(crate) fn chance(screened: &[Screened]) -> Chance {
    let many = (screened.len().max(1) as f64).ln();
    screened
        .iter()
        .map(|s| {
            let quantile = Data::new(s.by_chance.clone()).quantile(QUANTILE);
            (s.name, quantile + many)
        })
        .collect::<BTreeMap<_, _>>()
}

/// Probability that chance gains as much as the best candidate does, over all candidates: by scores, or by the gain of a whole
/// step, which sees what a score at the scatter that an effect itself makes is blind to.
pub(crate) fn p_value(screened: &[Screened], chance: &Chance) -> f64 {
    let gained = screened
        .iter()
        .map(|s| s.gain() - chance[s.name])
        .fold(f64::NEG_INFINITY, f64::max);
    // What chance gains of a whole step is not drawn: so odds of a hundred to one come on top of its scores' quantile.
    let by_gain = REAL * (EXCLUDED - gained).exp();
    by_score(screened, chance).min(by_gain)
}

/// The rank among the replicates, and beyond them an exponential tail, which gains in log-likelihood have.
fn by_score(screened: &[Screened], chance: &Chance) -> f64 {
    let over = |gain: f64, s: &Screened| gain - chance[s.name];
    let best = screened
        .iter()
        .map(|s| over(s.score, s))
        .fold(f64::NEG_INFINITY, f64::max);
    let replicates: Vec<f64> = (0..REPLICATES)
        .map(|k| {
            screened
                .iter()
                .map(|s| over(s.by_chance[k], s))
                .fold(f64::NEG_INFINITY, f64::max)
        })
        .collect();
    let more = replicates.iter().filter(|r| **r >= best).count();
    let rank = (1.0 + more as f64) / (1.0 + REPLICATES as f64);
    if more > 0 {
        return rank;
    }
    let mut tail = Data::new(replicates);
    let (from, share) = (tail.quantile(0.9), 0.1);
    (share * (from - best).exp()).min(rank)
}

/// The least probability of chance over all covariates, corrected for their number.
pub(crate) fn least(dependences: &[Dependence]) -> f64 {
    let least = dependences.iter().map(|d| d.p_value).fold(1.0, f64::min);
    (least * dependences.len() as f64).min(1.0)
}

/// Gain in log-likelihood of the covariate that explains most beyond chance.
pub(crate) fn left(dependences: &[Dependence]) -> f64 {
    dependences
        .iter()
        .filter(|d| d.p_value * (dependences.len() as f64) < REAL)
        .map(|d| d.gain)
        .fold(0.0, f64::max)
}
