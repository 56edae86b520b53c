//! What changes with the order of strikes beside scatter that is independent, of variance 1: a wander, whose steps are independent, or what changes
//! smoothly, whose slope wanders. Between two strikes lie as many steps as their numbers are apart: what takes no part wears a table, too. A Kalman
//! filter says of each strike what those before it do not foresee.

use nalgebra::DVector;

use super::projection::Basis;

/// Variances of a change from before the first strike to the last that are tried, in units of the scatter's.
const RATIOS: [f64; 11] = [
    0.0, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0,
];
/// Log-likelihood that a value loses within its 95 % interval: half of χ²'s quantile at one degree of freedom.
const WITHIN: f64 = 1.92;

/// A change over strikes.
#[derive(Clone)]
pub(super) struct Wander {
    /// From the strike before to each, as a share of all.
    steps: Vec<f64>,
    is_smooth: bool,
}

impl Wander {
    /// A wander over strikes with these numbers, which rise.
    pub(super) fn new(numbers: &DVector<f64>) -> Self {
        let before = numbers.iter().take(1).map(|first| first - 1.0);
        let before = before.chain(numbers.iter().copied());
        let apart: Vec<f64> = before
            .zip(numbers)
            .map(|(before, number)| (number - before).max(0.0))
            .collect();
        let whole: f64 = apart.iter().sum();
        Self {
            steps: apart.into_iter().map(|apart| apart / whole).collect(),
            is_smooth: false,
        }
    }

    pub(super) fn strikes(&self) -> usize {
        self.steps.len()
    }

    /// A smooth change over these strikes.
    pub(super) fn smooth(&self) -> Self {
        Self {
            is_smooth: true,
            ..self.clone()
        }
    }

    /// The likelihood of columns that also depend on these others.
    pub(super) fn beside(&self, others: &[DVector<f64>]) -> WanderBeside<'_> {
        let each = RATIOS.into_iter().map(|ratio| {
            let mut restricted = 0.0;
            let mut basis = Basis::default();
            for other in others {
                let weighed = self.whitened(ratio, other);
                let norm = basis.off(weighed.clone()).norm();
                let held = basis.0.len();
                basis = basis.with([weighed]);
                if basis.0.len() > held {
                    restricted += 2.0 * norm.ln();
                }
            }
            let mut filter = Filter::new(self, ratio, 0.0);
            let each = self.steps.iter().map(|step| {
                filter.predict(*step);
                filter.learn(0.0);
                filter.variance.ln()
            });
            AtRatio {
                ratio,
                determinant: each.sum(),
                restricted,
                basis,
            }
        });
        WanderBeside {
            wander: self,
            each: each.collect(),
        }
    }

    /// A column of this change beside scatter of 1, from independent ones.
    pub(super) fn drawn(&self, ratio: f64, independent: &DVector<f64>) -> DVector<f64> {
        let mut filter = Filter::new(self, ratio, 0.0);
        let each = self.steps.iter().zip(independent).map(|(step, own)| {
            filter.predict(*step);
            let value = filter.level + own * filter.variance.sqrt();
            filter.learn(value);
            value
        });
        DVector::from_iterator(independent.len(), each)
    }

    /// A column of which strikes are independent, of variance 1: what those before each do not foresee of it.
    pub(super) fn whitened(&self, ratio: f64, column: &DVector<f64>) -> DVector<f64> {
        match ratio == 0.0 {
            true => column.clone(),
            false => self.filtered(Filter::new(self, ratio, 0.0), column),
        }
    }

    /// What strikes before each do not foresee of it, over its standard deviation, where nothing is known before the first.
    pub(super) fn innovations(&self, ratio: f64, column: &DVector<f64>) -> DVector<f64> {
        self.filtered(Filter::new(self, ratio, 1.0 + ratio), column)
    }

    fn filtered(&self, mut filter: Filter, column: &DVector<f64>) -> DVector<f64> {
        let each = self.steps.iter().zip(column).map(|(step, value)| {
            filter.predict(*step);
            filter.learn(*value)
        });
        DVector::from_iterator(column.len(), each)
    }
}

/// A Kalman filter: the level and its slope, and their covariance.
struct Filter {
    ratio: f64,
    is_smooth: bool,
    level: f64,
    slope: f64,
    /// Variances of the level and of the slope, and their covariance.
    of_level: f64,
    of_slope: f64,
    of_both: f64,
    /// Of the strike that is foreseen, its scatter included.
    variance: f64,
}

impl Filter {
    /// Before the first strike, where the level has this variance.
    fn new(of: &Wander, ratio: f64, of_level: f64) -> Self {
        Self {
            ratio,
            is_smooth: of.is_smooth,
            level: 0.0,
            slope: 0.0,
            of_level,
            of_slope: if of.is_smooth { ratio } else { 0.0 },
            of_both: 0.0,
            variance: 1.0,
        }
    }

    /// On to the next strike.
    fn predict(&mut self, step: f64) {
        let moved = self.ratio * step;
        if self.is_smooth {
            self.level += self.slope * step;
            self.of_level += step * (2.0 * self.of_both + step * (self.of_slope + moved / 3.0));
            self.of_both += step * (self.of_slope + 0.5 * moved);
            self.of_slope += moved;
        } else {
            self.of_level += moved;
        }
        self.variance = self.of_level + 1.0;
    }

    /// Takes in what is seen of the strike; what was not foreseen of it, over its standard deviation.
    fn learn(&mut self, value: f64) -> f64 {
        let unforeseen = (value - self.level) / self.variance;
        self.level += self.of_level * unforeseen;
        self.slope += self.of_both * unforeseen;
        self.of_slope -= self.of_both * self.of_both / self.variance;
        self.of_both /= self.variance;
        self.of_level /= self.variance;
        unforeseen * self.variance.sqrt()
    }
}

/// A change beside other columns, at each ratio.
pub(super) struct WanderBeside<'w> {
    wander: &'w Wander,
    each: Vec<AtRatio>,
}

struct AtRatio {
    ratio: f64,
    basis: Basis,
    /// ln det(I + λK), and of the other columns' information.
    determinant: f64,
    restricted: f64,
}

impl WanderBeside<'_> {
    /// −2 ln L at each ratio: of the whole likelihood, or the restricted one.
    fn deviances(&self, column: &DVector<f64>, is_restricted: bool) -> Vec<(f64, f64)> {
        let n = column.len() as f64;
        let each = self.each.iter().map(|at| {
            let left = at.basis.off(self.wander.whitened(at.ratio, column));
            let (freedom, further) = match is_restricted {
                true => (n - at.basis.0.len() as f64, at.restricted),
                false => (n, 0.0),
            };
            let square = (left.norm_squared() / freedom).max(1e-300);
            let deviance = freedom * square.ln() + at.determinant + further;
            (at.ratio, deviance)
        });
        each.collect()
    }

    /// The greatest ratio that a column does not exclude, by restricted likelihood.
    pub(super) fn greatest(&self, column: &DVector<f64>) -> f64 {
        let all = self.deviances(column, true);
        let best = all.iter().map(|(_, d)| *d).fold(f64::INFINITY, f64::min);
        let within = all.iter().filter(|(_, d)| *d < best + 2.0 * WITHIN);
        within.map(|(ratio, _)| *ratio).fold(0.0, f64::max)
    }

    /// The likeliest ratio, and −2 ln L there.
    pub(super) fn likeliest(&self, column: &DVector<f64>) -> (f64, f64) {
        let all = self.deviances(column, false).into_iter();
        all.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// Numbers of strikes of which some took no part.
    fn numbers(n: usize) -> DVector<f64> {
        DVector::from_fn(n, |i, _| (4 + i + 3 * (i / 5)) as f64)
    }

    fn units(n: usize) -> impl Iterator<Item = DVector<f64>> {
        (0..n).map(move |i| DVector::from_fn(n, |j, _| f64::from(i == j)))
    }

    /// Covariance of what is drawn, less the scatter's, over the ratio.
    fn covariance(wander: &Wander, n: usize, ratio: f64) -> DMatrix<f64> {
        let columns: Vec<_> = units(n).map(|unit| wander.drawn(ratio, &unit)).collect();
        let root = DMatrix::from_columns(&columns);
        (&root * root.transpose() - DMatrix::identity(n, n)) / ratio
    }

    #[test]
    fn a_wander_goes_on_while_strikes_take_no_part_and_a_smooth_change_is_its_integral() {
        let n = 30;
        let numbers = numbers(n);
        let wander = Wander::new(&numbers);
        let time = |i: usize| (numbers[i] - 3.0) / (numbers[n - 1] - 3.0);
        let (rough, smooth) = (
            covariance(&wander, n, 7.0),
            covariance(&wander.smooth(), n, 7.0),
        );
        for (i, j) in [(0, 0), (3, 20), (12, 11), (29, 29)] {
            let (s, t) = (time(i.min(j)), time(i.max(j)));
            assert!((rough[(i, j)] - s).abs() < 1e-9);
            // The slope begins with a variance of 1, and wanders.
            let integral = s * t + s * s * (3.0 * t - s) / 6.0;
            assert!((smooth[(i, j)] - integral).abs() < 1e-9);
        }
    }

    #[test]
    fn what_was_drawn_is_whitened_to_what_it_was_drawn_from_and_has_its_likelihood() {
        let n = 40;
        let rough = Wander::new(&numbers(n));
        for wander in [rough.smooth(), rough] {
            let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(3);
            let own = DVector::from_fn(n, |_, _| StandardNormal.sample(&mut random));
            let drawn = wander.drawn(30.0, &own);
            assert!((wander.whitened(30.0, &drawn) - own).amax() < 1e-9);
            let all = DMatrix::identity(n, n) + covariance(&wander, n, 30.0) * 30.0;
            let determinant = all.cholesky().expect("positive").ln_determinant();
            let beside = wander.beside(&[]);
            let at = beside.each.iter().find(|at| at.ratio == 30.0);
            assert!((at.expect("a ratio").determinant - determinant).abs() < 1e-6);
        }
    }

    #[test]
    fn the_likeliest_ratio_is_near_to_that_of_what_was_drawn() {
        let n = 200;
        let wander = Wander::new(&numbers(n));
        let beside = wander.beside(&[DVector::repeat(n, 1.0)]);
        let found = (0..20).map(|seed| {
            let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
            let own = DVector::from_fn(n, |_, _| StandardNormal.sample(&mut random));
            beside.likeliest(&wander.drawn(30.0, &own)).0
        });
        let near = found.filter(|ratio| (10.0..=100.0).contains(ratio)).count();
        assert!(near >= 17, "{near} of 20");
    }
}
