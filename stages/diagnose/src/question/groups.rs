//! Do strikes fall into two groups, though nothing that was logged tells which is which? Two objects, a camera that focuses at one of two
//! lengths, a tip that rests on one side or the other.
//!
//! The statistic is the excess mass of two modes over one (Müller and Sawitzki 1991): over all levels λ of a density, the most by which
//! two intervals hold more strikes beyond λ times their length than one does. It is compared with that of uniform values, whose is the
//! greatest of all distributions with one mode (Hartigan and Hartigan 1985): no noise model is believed.

use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use values::median;

use super::{projection::Basis, wander::Wander};

/// Levels at which densities are cut, over one by the range between quartiles: each this many times the one before.
const LEVELS: [f64; 2] = [0.02, 5.0];
const STEP: f64 = 1.2;
/// Draws of values with one mode, which end when so many show as much (Besag and Clifford 1991).
const DRAWN: usize = 3999;
const ENOUGH: usize = 10;

/// Two groups of values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Groups {
    /// Excess mass.
    excess: f64,
    /// The value between the two.
    between: f64,
}

impl Groups {
    /// The two groups that values fall into, if any.
    pub(super) fn of(values: &DVector<f64>) -> Option<Self> {
        let (excess, between) = excess_mass(values.as_slice().to_vec())?;
        Some(Self { excess, between })
    }

    /// Root mean square by which groups alone would make these values differ.
    pub(super) fn apart(&self, values: &DVector<f64>) -> f64 {
        let (low, high): (Vec<f64>, Vec<f64>) = values.iter().partition(|v| **v < self.between);
        let share = low.len() as f64 / values.len() as f64;
        let [low, high] = [low, high].map(|of| median(of).unwrap_or(0.0));
        (share * (1.0 - share)).sqrt() * (high - low)
    }

    /// Probability by chance of groups as distinct, where values wander over the order by this ratio beside others that were taken off.
    pub(super) fn p_value(&self, wander: &Wander, ratio: f64, beside: &Basis, seed: u64) -> f64 {
        let strikes = wander.strikes();
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut as_far = 0;
        for drawn in 1..=DRAWN {
            // Of variance 1.
            let uniform = DVector::from_fn(strikes, |_, _| {
                (random.random::<f64>() - 0.5) * 12.0_f64.sqrt()
            });
            let values = beside.off(wander.drawn(ratio, &uniform));
            as_far += usize::from(
                Self::of(&values).is_some_and(|by_chance| by_chance.excess >= self.excess),
            );
            if as_far == ENOUGH {
                return ENOUGH as f64 / drawn as f64;
            }
        }
        (1 + as_far) as f64 / (1 + DRAWN) as f64
    }
}

/// Excess mass of two modes over one, and the value between them; none of values that are all alike.
fn excess_mass(mut values: Vec<f64>) -> Option<(f64, f64)> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    let quartile = |k: usize| values.get(k * n / 4);
    let quartiles = quartile(3)? - quartile(1)?;
    if quartiles <= 0.0 {
        return None;
    }
    let [least, most] = LEVELS;
    let levels = std::iter::successors(Some(least), |level| Some(level * STEP));
    levels
        .take_while(|level| *level <= most)
        .map(|level| beyond_one(&values, level / quartiles))
        .max_by(|a, b| a.0.total_cmp(&b.0))
}

/// By how much two intervals of sorted values hold more beyond this density than one, and the value between the two.
fn beyond_one(values: &[f64], density: f64) -> (f64, f64) {
    let each = 1.0 / values.len() as f64;
    let (mut one, mut most_of_one) = (0.0_f64, 0.0_f64);
    // The best first interval up to here, with its end; the best second that goes up to here, with the value before it.
    let mut first = (0.0, values[0]);
    let (mut two, mut most_of_two) = ((f64::NEG_INFINITY, values[0]), (0.0, values[0]));
    let mut before = values[0];
    for value in values {
        let gap = density * (value - before);
        let begun = (first.0 + each, 0.5 * (first.1 + value));
        let gone_on = (two.0 - gap + each, two.1);
        two = if gone_on.0 >= begun.0 { gone_on } else { begun };
        if two.0 > most_of_two.0 {
            most_of_two = two;
        }
        one = (one - gap).max(0.0) + each;
        most_of_one = most_of_one.max(one);
        if one > first.0 {
            first = (one, *value);
        }
        before = *value;
    }
    (most_of_two.0 - most_of_one, most_of_two.1)
}

#[cfg(test)]
mod tests {
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    const STRIKES: usize = 100;

    /// Probabilities by chance, of columns that this draws, beside a wander of this ratio.
    fn p_values(ratio: f64, draw: impl Fn(usize, &mut ChaCha8Rng) -> f64) -> Vec<f64> {
        let numbers = DVector::from_fn(STRIKES, |i, _| i as f64);
        let wander = Wander::new(&numbers);
        let of = |seed| {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let values = DVector::from_fn(STRIKES, |i, _| draw(i, &mut random));
            let values = wander.drawn(ratio, &values);
            let groups = Groups::of(&values)?;
            Some(groups.p_value(&wander, ratio, &Basis::default(), seed))
        };
        (0..20).filter_map(of).collect()
    }

    fn normal(random: &mut ChaCha8Rng) -> f64 {
        StandardNormal.sample(random)
    }

    #[test]
    fn two_groups_are_found_though_none_is_known() {
        let two = |i: usize, random: &mut ChaCha8Rng| {
            normal(random) + if i.is_multiple_of(2) { 6.0 } else { 0.0 }
        };
        let found = p_values(0.0, two);
        let is_found = |p: &&f64| **p < 0.001;
        assert!(found.iter().filter(is_found).count() >= 18, "{found:?}");
    }

    #[test]
    fn what_has_one_mode_is_no_group_be_it_skewed_or_long_tailed_or_a_wander() {
        let skewed = |_: usize, random: &mut ChaCha8Rng| normal(random).exp();
        let tailed = |_: usize, random: &mut ChaCha8Rng| normal(random) / normal(random);
        let alone = |_: usize, random: &mut ChaCha8Rng| normal(random);
        let all = [
            p_values(0.0, skewed),
            p_values(0.0, tailed),
            p_values(0.0, alone),
            p_values(100.0, alone),
        ];
        for found in all {
            assert!(found.iter().all(|p| *p > 0.005), "{found:?}");
        }
    }

    #[test]
    fn groups_are_apart_by_what_lies_between_them() {
        let values = DVector::from_fn(40, |i, _| f64::from(i as u32 % 2) * 4.0 + 0.01 * i as f64);
        let groups = Groups::of(&values).expect("values that differ");
        assert!((groups.apart(&values) - 2.0).abs() < 0.1);
    }
}
