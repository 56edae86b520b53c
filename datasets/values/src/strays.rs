//! Strikes that stop far from where the others do: a tip that grazed, or struck twice, a command of the strike before, a hand, a table that was
//! wiped.
//!
//! Stop errors are taken relative to the ways, along and across. A robust scatter would hold them where they are many, so the others' begins with
//! that of the shortest interval that holds half of all errors: nearly half may stray. Of few strikes it is too short by chance, so that of all that lie
//! within two and a half of it counts (reweighted, Rousseeuw and Leroy 1987).

/// How far out a strike must stop, in units of what the others scatter by: one normal error in two million is as far out, and one in a hundred of the
/// long tails (Student's t with 4 degrees of freedom) that real launches have.
const FAR: f64 = 5.0;
/// Least standard deviation of the others, relative to the way: no arm launches twice more alike. Where logs repeat each other exactly, whatever does not
/// would be as far out as that.
const LEAST: f64 = 0.003;
/// Half of the interval that holds half of a normal distribution, in standard deviations.
const HALF: f64 = 0.6745;
/// What the shortest interval is too short by where values are few, over their number (Rousseeuw and Leroy 1987).
const FINITE: f64 = 5.0;
/// How near values are to it that count, in standard deviations, and the standard deviation of the part of a normal distribution that is as near.
const NEAR: f64 = 2.5;
const OF_NEAR: f64 = 0.9546;
/// From how far out on they are in a tail. One that falls off as a normal, an exponential or a Student's distribution holds more there than beyond [`FAR`].
const TAIL: f64 = 3.0;
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
    /// How many of the others are in the tails.
    in_tails: usize,
}

impl Strays {
    /// By the errors of the stops, along and across the way (m), the lengths of the ways (m) and the standard deviation of a centroid (m).
    pub fn of(errors: &[[f64; 2]], ways: &[f64], camera: f64) -> Self {
        let mut farthest = vec![0.0f64; errors.len()];
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
                let scatter = scatter.max(LEAST).max(camera / way(i));
                farthest[i] = farthest[i].max(away.abs() / scatter);
                squares[i] += (away * way(i)).powi(2);
            }
        }
        let which: Vec<bool> = farthest.iter().map(|far| *far > FAR).collect();
        let near = squares
            .iter()
            .zip(&which)
            .filter(|(_, is_stray)| !**is_stray);
        let near: Vec<f64> = near.map(|(square, _)| *square).collect();
        Self {
            others: (near.iter().sum::<f64>() / near.len().max(1) as f64).sqrt(),
            in_tails: farthest
                .iter()
                .filter(|far| (TAIL..=FAR).contains(*far))
                .count(),
            which,
        }
    }

    /// How many they are.
    pub fn count(&self) -> usize {
        self.which.iter().filter(|is_stray| **is_stray).count()
    }

    /// Whether they are more than long tails have.
    pub fn are_beyond_tails(&self) -> bool {
        self.count() >= FEW.max(self.in_tails + 1)
            && self.count() as f64 >= TAILS * self.which.len() as f64
    }

    /// Whether so many of all strikes are a part of them, and no strays.
    pub fn is_a_part(count: usize, of: usize) -> bool {
        count as f64 >= PART * of as f64
    }
}

/// Probability by chance below which strays follow a covariate.
const FOLLOWS: f64 = 0.002;
/// Share of the strays that are most of them.
const MOST: f64 = 0.8;

impl Strays {
    /// Whether strays gather somewhere along a covariate (a value for each strike): Kuiper's test (1960), which sees the ends of a range and its middle
    /// alike. The range that holds most of them; none where they are spread as the others are.
    pub fn gathered(&self, covariate: &[f64]) -> Option<[f64; 2]> {
        let mut order: Vec<usize> = (0..self.which.len()).collect();
        order.sort_by(|a, b| covariate[*a].total_cmp(&covariate[*b]));
        let count = self.count();
        if count == 0 || count == order.len() {
            return None;
        }
        let each = [count, order.len() - count].map(|n| 1.0 / n as f64);
        let (mut ahead, mut most, mut least) = (0.0f64, 0.0f64, 0.0f64);
        for (k, i) in order.iter().enumerate() {
            ahead += if self.which[*i] { each[0] } else { -each[1] };
            // Equal values are one step.
            let next = order.get(k + 1).map(|next| covariate[*next]);
            if next != Some(covariate[*i]) {
                (most, least) = (most.max(ahead), least.min(ahead));
            }
        }
        if kuiper(most - least, count, order.len() - count) >= FOLLOWS {
            return None;
        }
        let at: Vec<f64> = order
            .iter()
            .filter(|i| self.which[**i])
            .map(|i| covariate[*i])
            .collect();
        let most = (MOST * count as f64).ceil() as usize;
        at.windows(most)
            .map(|held| [held[0], held[most - 1]])
            .min_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))
    }
}

/// Probability by chance of a range as great between two distribution functions of so many values (Press et al. 2007, section 14.3.4).
fn kuiper(range: f64, one: usize, other: usize) -> f64 {
    let n = (one * other) as f64 / (one + other).max(1) as f64;
    let lambda = (n.sqrt() + 0.155 + 0.24 / n.sqrt()) * range;
    // The series is 1 to 14 places there.
    if lambda.is_nan() || lambda < 0.4 {
        return 1.0;
    }
    let term = |j: f64| {
        let square = (j * lambda).powi(2);
        2.0 * (4.0 * square - 1.0) * (-2.0 * square).exp()
    };
    (1..=100).map(|j| term(f64::from(j))).sum()
}

/// Middle and standard deviation of the values near the shortest interval that holds half of them.
fn of_the_nearest_half(values: &[f64]) -> Option<[f64; 2]> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let half = values.len() / 2 + 1;
    let [low, high] = sorted
        .windows(half)
        .map(|held| [held[0], held[half - 1]])
        .min_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
    let middle = 0.5 * (low + high);
    let scatter = 0.5 * (high - low) / HALF * (1.0 + FINITE / values.len() as f64);
    sorted.retain(|value| (value - middle).abs() <= NEAR * scatter);
    let count = sorted.len() as f64;
    let mean = sorted.iter().sum::<f64>() / count;
    let squares: f64 = sorted.iter().map(|value| (value - mean).powi(2)).sum();
    Some([mean, (squares / count).sqrt() / OF_NEAR])
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
        Strays::of(&errors, &vec![0.3; shares.len()], 7e-4)
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
    fn beside_exact_repeats_what_a_camera_or_an_arm_scatters_by_is_no_stray() {
        let mut shares = vec![0.0; 120];
        shares.iter_mut().step_by(3).for_each(|s| *s += 0.01);
        assert_eq!(strays(&shares).count(), 0);
        shares.iter_mut().step_by(12).for_each(|s| *s += 0.2);
        assert_eq!(strays(&shares).count(), 10);
    }

    #[test]
    fn strays_that_gather_are_told_from_those_that_are_spread() {
        let order: Vec<f64> = (0..150).map(f64::from).collect();
        let gathered = |is_stray: &dyn Fn(usize) -> bool| {
            let strays = Strays {
                which: (0..150).map(is_stray).collect(),
                ..Strays::default()
            };
            strays.gathered(&order)
        };
        assert_eq!(gathered(&|i| i >= 140), Some([140.0, 147.0]));
        let range = gathered(&|i| (60..80).contains(&i) || i == 3).expect("gathered");
        assert!(range[0] >= 60.0 && range[1] < 80.0);
        assert_eq!(gathered(&|i| i % 9 == 0), None);
        assert_eq!(gathered(&|i| i * 37 % 150 < 12), None);
        assert_eq!(gathered(&|_| false), None);
    }

    #[test]
    fn the_probability_by_chance_is_that_of_tables() {
        // Upper 5 % and 1 % of Kuiper's statistic times the root of the number of values (Stephens 1970).
        for (statistic, level) in [(1.747, 0.05), (2.001, 0.01)] {
            let n = 10_000.0f64;
            let by_chance = kuiper(
                statistic / (n.sqrt() + 0.155 + 0.24 / n.sqrt()),
                20_000,
                20_000,
            );
            assert!((by_chance / level - 1.0).abs() < 0.02, "{by_chance}");
        }
    }

    #[test]
    fn long_tails_are_no_part_and_a_few_strikes_tell_nothing() {
        assert!(!strays(&quantiles(101, logistic)).are_beyond_tails());
        let laplace = |p: f64| 0.01 * (2.0 * p.min(1.0 - p)).ln().copysign(p - 0.5);
        let found = strays(&quantiles(101, laplace));
        assert!(!found.are_beyond_tails(), "{found:?}");
        let cauchy = |p: f64| 0.01 * (std::f64::consts::PI * (p - 0.5)).tan();
        let found = strays(&quantiles(101, cauchy));
        assert!(found.are_beyond_tails(), "{found:?}");
        assert!(!Strays::is_a_part(found.count(), 101));
        assert!(!strays(&[0.0, 0.0, 0.5]).are_beyond_tails());
        assert_eq!(strays(&[]).count(), 0);
    }
}
