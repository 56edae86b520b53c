//! Strikes that stop far from where the others do, though nothing that was logged tells which: a tip that grazed, or struck twice, a command of the
//! strike before, a hand.
//!
//! Stop errors are taken relative to the ways, along and across. A robust scatter would hold them where they are many, so the others' is
//! that of the shortest interval that holds half of all errors (Rousseeuw and Leroy 1988): nearly half may stray.

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

/// Strikes that stop far from where the others do.
#[derive(Clone, Debug, Default)]
pub struct Strays {
    /// Which of the strikes do.
    pub which: Vec<bool>,
    /// What the stops of the others scatter by, about the middle of their errors, in m.
    pub others: f64,
}

impl Strays {
    /// By the errors of the stops, along and across the way (m), and the lengths of the ways (m).
    pub fn of(errors: &[[f64; 2]], ways: &[f64]) -> Self {
        let mut which = vec![false; errors.len()];
        let mut squares = vec![0.0; errors.len()];
        let way = |i: usize| ways[i].max(SHORTEST);
        for side in 0..2 {
            let shares = errors.iter().enumerate().map(|(i, e)| e[side] / way(i));
            let shares: Vec<f64> = shares.collect();
            let Some([middle, scatter]) = of_the_nearest_half(&shares) else {
                continue;
            };
            for (i, share) in shares.iter().enumerate() {
                let away = share - middle;
                which[i] |= away.abs() > FAR * scatter;
                squares[i] += (away * way(i)).powi(2);
            }
        }
        let near = squares
            .iter()
            .zip(&which)
            .filter(|(_, is_stray)| !**is_stray);
        let near: Vec<f64> = near.map(|(square, _)| *square).collect();
        Self {
            others: (near.iter().sum::<f64>() / near.len().max(1) as f64).sqrt(),
            which,
        }
    }

    /// How many they are.
    pub fn count(&self) -> usize {
        self.which.iter().filter(|is_stray| **is_stray).count()
    }

    /// Whether they are more than long tails have.
    pub fn are_beyond_tails(&self) -> bool {
        self.count() >= FEW && self.count() as f64 >= TAILS * self.which.len() as f64
    }

    /// Whether so many of all strikes are a part of them, and no strays.
    pub fn is_a_part(count: usize, of: usize) -> bool {
        count as f64 >= PART * of as f64
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
    use super::*;

    /// Even quantiles of a distribution, in an order that has nothing to do with them.
    fn quantiles(count: usize, of: impl Fn(f64) -> f64) -> Vec<f64> {
        let place = |i: usize| ((i * 37 % count) as f64 + 0.5) / count as f64;
        (0..count).map(|i| of(place(i))).collect()
    }

    /// Of the logistic distribution, with a standard deviation of 1 %: its tails are longer than a normal one's.
    fn logistic(p: f64) -> f64 {
        0.01 * 3.0f64.sqrt() / std::f64::consts::PI * (p / (1.0 - p)).ln()
    }

    /// Strikes over 0.3 m whose stops are off along the way by these shares of it.
    fn strays(shares: &[f64]) -> Strays {
        let errors: Vec<[f64; 2]> = shares.iter().map(|share| [0.3 * share, 1e-4]).collect();
        Strays::of(&errors, &vec![0.3; shares.len()])
    }

    #[test]
    fn strikes_that_were_struck_twice_are_told_however_many_they_are() {
        for every in [3, 10, 30] {
            let mut shares = quantiles(120, logistic);
            shares.iter_mut().step_by(every).for_each(|s| *s += 0.2);
            let found = strays(&shares);
            let struck_twice: Vec<bool> = (0..120).map(|i| i % every == 0).collect();
            assert_eq!(found.which, struck_twice);
            assert!(found.are_beyond_tails());
            assert_eq!(Strays::is_a_part(found.count(), 120), every == 3);
            assert!((found.others / 0.003 - 1.0).abs() < 0.1, "{}", found.others);
        }
    }

    #[test]
    fn long_tails_are_no_part_and_a_few_strikes_tell_nothing() {
        assert!(!strays(&quantiles(101, logistic)).are_beyond_tails());
        let cauchy = |p: f64| 0.01 * (std::f64::consts::PI * (p - 0.5)).tan();
        let found = strays(&quantiles(101, cauchy));
        assert!(found.are_beyond_tails() && !Strays::is_a_part(found.count(), 101));
        assert!(!strays(&[0.0, 0.0, 0.5]).are_beyond_tails());
        assert_eq!(strays(&[]).count(), 0);
    }
}
