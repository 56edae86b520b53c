//! Strikes that stop far from where the others do, though nothing that was logged tells which: a tip that grazed, or struck twice, a command of the
//! strike before, a hand.
//!
//! Stop errors are taken relative to the ways, along and across. A robust scatter would hold them where they are many, so the others' is
//! that of the shortest interval that holds half of all errors (Rousseeuw and Leroy 1988): as many as half may stray.

use std::collections::BTreeMap;

use values::Strike;

use crate::{
    diagnosis::StopResidual,
    words::{Cause, Dependence, Strays},
};

/// How far out a strike must stop, in units of what the others scatter by: one normal error in two million is as far out, and one in a hundred of the
/// long tails (Student's t with 4 degrees of freedom) that real launches have.
const FAR: f64 = 5.0;
/// Half of the interval that holds half of a normal distribution, in standard deviations.
const HALF: f64 = 0.6745;
/// Share of the strikes, and number, that long tails do not reach.
const TAILS: f64 = 0.03;
const FEW: usize = 3;
/// Share from which on they are a part of the strikes, which a distribution with one peak does not reach.
const PART: f64 = 0.2;
/// Shortest way on which an error is relative, in m.
const SHORTEST: f64 = 0.01;

impl Strays {
    /// By these errors of the stops, along and across the way, in m.
    pub(crate) fn of(
        strikes: &[Strike],
        residuals: &[StopResidual],
        error: fn(&StopResidual) -> [f64; 2],
    ) -> Self {
        let ways: BTreeMap<&str, f64> = strikes
            .iter()
            .map(|strike| (strike.id.as_str(), strike.path().norm()))
            .collect();
        let mut strays = vec![false; residuals.len()];
        let mut squares = vec![0.0; residuals.len()];
        for side in 0..2 {
            let way = |residual: &StopResidual| ways[residual.strike_id.as_str()].max(SHORTEST);
            let errors = residuals.iter().map(|r| error(r)[side] / way(r));
            let errors: Vec<f64> = errors.collect();
            let Some([middle, scatter]) = of_the_nearest_half(&errors) else {
                continue;
            };
            for (i, residual) in residuals.iter().enumerate() {
                let away = errors[i] - middle;
                strays[i] |= away.abs() > FAR * scatter;
                squares[i] += (away * way(residual)).powi(2);
            }
        }
        let near = squares.iter().zip(&strays).filter(|(_, strays)| !**strays);
        let near: Vec<f64> = near.map(|(square, _)| *square).collect();
        Self {
            count: residuals.len() - near.len(),
            of: residuals.len(),
            others: (near.iter().sum::<f64>() / near.len().max(1) as f64).sqrt(),
        }
    }

    /// Whether a dependence on what was logged moves stops by less than the strikes that do not stray scatter by, so that it is not what these stray by.
    pub(crate) fn are_beside(&self, cause: Option<&Cause>) -> bool {
        match cause {
            None => true,
            Some(Cause::Dependence(Dependence::OfStrikes { size, .. })) => *size < self.others,
            Some(_) => false,
        }
    }

    /// Whether they are more than long tails have.
    pub(crate) fn are_beyond_tails(&self) -> bool {
        self.count >= FEW && self.count as f64 >= TAILS * self.of as f64
    }

    /// Whether they are a part of the strikes, and no strays.
    pub(crate) fn are_a_part(&self) -> bool {
        self.are_beyond_tails() && self.count as f64 >= PART * self.of as f64
    }
}

/// Middle and standard deviation of the values as the shortest interval that holds half of them has them.
fn of_the_nearest_half(values: &[f64]) -> Option<[f64; 2]> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let half = values.len() / 2 + 1;
    let [low, high] = sorted
        .windows(half)
        .map(|held| [held[0], held[half - 1]])
        .min_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
    Some([0.5 * (low + high), 0.5 * (high - low) / HALF])
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal, StudentT};
    use values::{Command, Point};

    use super::*;
    use crate::gap;

    /// Strikes over 0.3 m whose stops are off by these shares of it.
    fn strays(shares: impl Iterator<Item = f64>) -> Strays {
        let (start, stop) = (Point::default(), Point::new(0.3, 0.0));
        let shares: Vec<f64> = shares.collect();
        let strikes: Vec<Strike> = (0..shares.len())
            .map(|i| Strike {
                id: i.to_string(),
                ..Strike::bare(Command::new(0.5, 0.0), start, stop)
            })
            .collect();
        let errors: Vec<_> = shares
            .iter()
            .map(|share| Some(Point::new(0.3 * share, 1e-4)))
            .collect();
        let residuals = gap::residuals(&strikes.iter().collect::<Vec<_>>(), &errors, &errors);
        Strays::of(&strikes, &residuals, |residual| residual.before)
    }

    #[test]
    fn strikes_that_were_struck_twice_are_told_however_many_they_are() {
        let normal = Normal::new(0.0, 0.01).expect("finite");
        for every in [3, 10, 30] {
            let mut random = ChaCha8Rng::seed_from_u64(every);
            let found = strays((0..120).map(|i| {
                let error = normal.sample(&mut random);
                error
                    + if (i as u64).is_multiple_of(every) {
                        0.2
                    } else {
                        0.0
                    }
            }));
            assert_eq!(found.count, 120usize.div_ceil(every as usize));
            assert!(found.are_beyond_tails());
            assert_eq!(found.are_a_part(), every == 3);
            assert!(
                (found.others / 0.003 - 1.0).abs() < 0.25,
                "{}",
                found.others
            );
        }
    }

    #[test]
    fn long_tails_are_no_part_and_a_few_strikes_tell_nothing() {
        let normal = Normal::new(0.0, 0.01).expect("finite");
        let tailed = StudentT::new(3.0).expect("positive");
        for seed in 0..50 {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let found = strays((0..100).map(|_| 0.01 * tailed.sample(&mut random)));
            assert!(!found.are_a_part());
            let found = strays((0..100).map(|_| normal.sample(&mut random)));
            assert!(!found.are_beyond_tails());
        }
        assert!(!strays([0.0, 0.0, 0.5].into_iter()).are_beyond_tails());
        assert_eq!(strays(std::iter::empty()).count, 0);
    }
}
