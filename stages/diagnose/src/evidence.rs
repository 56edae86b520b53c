//! Whether: is there a gap at all?
//!
//! One statistic over all candidates: the most that any of them gains beyond its own 99 % quantile under drawn residuals. Its distribution, the
//! choice among all statistics included, comes from the same replicates: drawn from the fitted world and its noise, and by flipping the signs of
//! whole strikes' scores.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use statrs::statistics::{Data, OrderStatistics};

use crate::{
    score::{DRAWN, FLIPPED, Replicates},
    screen::{Chance, Screened},
};

/// A gap is real below this probability by drawn residuals, if it is below the other by flipped signs.
pub(crate) const REAL: f64 = 0.01;
pub(crate) const CONFIRMED: f64 = 0.05;
/// Quantile of the drawn residuals that a statistic must exceed; what many gain together comes on top.
const QUANTILE: f64 = 0.99;

/// The replicates of a diagnosis.
pub(crate) fn replicates(seed: u64) -> Replicates {
    Replicates {
        drawn: DRAWN,
        flipped: FLIPPED,
        seed,
    }
}

/// The replicates of a diagnosis without drawn residuals: flipped signs alone.
pub(crate) fn flips(seed: u64) -> Replicates {
    Replicates {
        drawn: 0,
        ..replicates(seed)
    }
}

/// Gain in log-likelihood that each candidate reaches by chance, by name: the 99 % quantile of its drawn replicates plus the logarithm of the number
/// of candidates.
pub(crate) fn chance(screened: &[Screened]) -> Chance {
    let many = (screened.len().max(1) as f64).ln();
    screened
        .iter()
        .map(|s| (s.name, quantile(&s.by_chance) + many))
        .collect::<BTreeMap<_, _>>()
}

fn quantile(by_chance: &[f64]) -> f64 {
    let drawn = by_chance[..DRAWN.min(by_chance.len())].to_vec();
    if drawn.is_empty() {
        return 0.0;
    }
    Data::new(drawn).quantile(QUANTILE)
}

/// A candidate's best score: its gain in log-likelihood, and the gain in each replicate.
pub(crate) struct Statistic<'s> {
    pub(crate) name: &'s str,
    pub(crate) gain: f64,
    pub(crate) by_chance: &'s [f64],
}

impl<'s> Statistic<'s> {
    /// The statistics of all screened candidates.
    pub(crate) fn all(screened: &'s [Screened]) -> Vec<Self> {
        let candidates = screened.iter().map(|s| Self {
            name: s.name,
            gain: s.score,
            by_chance: &s.by_chance,
        });
        candidates.collect()
    }
}

/// How likely chance alone gains as much as something that was looked at.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PValue {
    /// By residuals drawn from the fitted world and its noise.
    pub(crate) drawn: f64,
    /// By flipping the signs of whole strikes' scores.
    pub(crate) flipped: f64,
}

impl PValue {
    /// Whether both probabilities are low enough that the gain is no chance.
    pub(crate) fn is_real(self) -> bool {
        self.is_real_as_drawn() && self.flipped < CONFIRMED
    }

    /// Whether the probability by drawn residuals is low enough that the gain is no chance.
    pub(crate) fn is_real_as_drawn(self) -> bool {
        self.drawn < REAL
    }
}

/// The joint test over all candidates: the largest excess of any statistic over its own quantile, against the largest in each replicate.
#[derive(Clone)]
pub(crate) struct Alarm {
    /// The 99 % quantile of each statistic under drawn residuals, by candidate.
    quantiles: BTreeMap<String, f64>,
    /// Each candidate's name, and its gain beyond its quantile.
    excess: Vec<(String, f64)>,
    /// The most over all statistics in each replicate.
    drawn: Vec<f64>,
    flipped: Vec<f64>,
}

impl Alarm {
    /// The test over these statistics, whose replicates are the drawn ones, then the flipped ones.
    pub(crate) fn new(statistics: &[Statistic<'_>]) -> Self {
        let each = statistics.iter();
        let quantiles = each
            .map(|s| (s.name.to_string(), quantile(s.by_chance)))
            .collect();
        let mut alarm = Self {
            quantiles,
            excess: Vec::new(),
            drawn: Vec::new(),
            flipped: Vec::new(),
        };
        let most = alarm.most(statistics);
        let (drawn, flipped) = most.split_at(DRAWN.min(most.len()));
        (alarm.drawn, alarm.flipped) = (drawn.to_vec(), flipped.to_vec());
        alarm.excess = alarm.beyond(statistics);
        alarm
    }

    /// The test of the same candidates beside another model, with `statistics` whose replicates are flipped alone. What drawn residuals gain depends
    /// on where fits may begin, not on the model, and is kept.
    pub(crate) fn beside(&self, statistics: &[Statistic<'_>]) -> Self {
        Self {
            excess: self.beyond(statistics),
            flipped: self.most(statistics),
            ..self.clone()
        }
    }

    fn quantile(&self, name: &str) -> f64 {
        self.quantiles.get(name).copied().unwrap_or(f64::INFINITY)
    }

    fn beyond(&self, statistics: &[Statistic<'_>]) -> Vec<(String, f64)> {
        let each = statistics.iter();
        each.map(|s| (s.name.to_string(), s.gain - self.quantile(s.name)))
            .collect()
    }

    /// The most over all statistics in each replicate.
    fn most(&self, statistics: &[Statistic<'_>]) -> Vec<f64> {
        let replicates = statistics.first().map_or(0, |s| s.by_chance.len());
        let most = |k: usize| {
            let each = statistics.iter();
            each.map(|s| s.by_chance[k] - self.quantile(s.name))
                .fold(f64::NEG_INFINITY, f64::max)
        };
        (0..replicates).map(most).collect()
    }

    fn of_excess(&self, excess: f64) -> PValue {
        let share = |replicates: &[f64]| {
            let more = replicates.iter().filter(|r| **r >= excess).count();
            (1 + more) as f64 / (1 + replicates.len()) as f64
        };
        PValue {
            drawn: share(&self.drawn),
            flipped: share(&self.flipped),
        }
    }

    /// Probability by chance of the largest gain of all: whether there is a gap.
    pub(crate) fn p_value(&self) -> PValue {
        let each = self.excess.iter().map(|(_, excess)| *excess);
        self.of_excess(each.fold(f64::NEG_INFINITY, f64::max))
    }

    /// Probability by chance of one candidate's gain, as one among all.
    pub(crate) fn p_value_of(&self, name: &str) -> PValue {
        let found = self.excess.iter().find(|(statistic, _)| statistic == name);
        self.of_excess(found.map_or(f64::NEG_INFINITY, |(_, excess)| *excess))
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Exp1};

    use super::*;

    fn gains(seed: u64) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        (0..DRAWN + FLIPPED)
            .map(|_| Exp1.sample(&mut random))
            .collect()
    }

    fn alarm(gain: f64) -> Alarm {
        let chance: Vec<Vec<f64>> = (0..20).map(gains).collect();
        let names: Vec<String> = (0..20).map(|i| format!("other {i}")).collect();
        let statistics: Vec<Statistic<'_>> = chance
            .iter()
            .enumerate()
            .map(|(i, by_chance)| Statistic {
                name: if i == 7 { "patch" } else { &names[i] },
                gain: if i == 7 { gain } else { 0.5 },
                by_chance,
            })
            .collect();
        Alarm::new(&statistics)
    }

    #[test]
    fn the_choice_among_many_statistics_counts() {
        // Alone, a gain of 5 has a probability of 0.7 %; the best of twenty has 13 %.
        let p = alarm(5.0).p_value();
        assert!((0.03..0.35).contains(&p.drawn), "{p:?}");
        assert!(!p.is_real());
        assert!(alarm(12.0).p_value().is_real());
    }

    #[test]
    fn no_p_value_is_less_than_the_replicates_can_show() {
        let p = alarm(500.0).p_value_of("patch");
        assert_eq!(p.drawn, 1.0 / (1 + DRAWN) as f64);
        assert_eq!(p.flipped, 1.0 / (1 + FLIPPED) as f64);
    }
}
