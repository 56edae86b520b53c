//! A family of questions: the strongest answer of all, calibrated by what the same questions answer to permuted strikes.

use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;

/// A gap is real below this probability.
pub(crate) const REAL: f64 = 0.01;
/// Permutations, the same for all questions.
pub(crate) const PERMUTED: usize = 1999;

/// What a question answers of the data, then of each permutation.
pub(super) type Statistic = Vec<f64>;

/// The permutations of so many strikes, and as many flips of their signs.
pub(super) struct Shuffles {
    pub(super) orders: Vec<Vec<u32>>,
    pub(super) signs: DMatrix<f64>,
}

impl Shuffles {
    pub(super) fn new(strikes: usize, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut order: Vec<u32> = (0..strikes as u32).collect();
        let orders = (0..PERMUTED)
            .map(|_| {
                order.shuffle(&mut random);
                order.clone()
            })
            .collect();
        let signs = DMatrix::from_fn(strikes, PERMUTED, |_, _| {
            if random.random::<bool>() { 1.0 } else { -1.0 }
        });
        Self { orders, signs }
    }

    /// A column as it is, then in every order.
    pub(super) fn permuted(&self, values: &[f64]) -> DMatrix<f64> {
        let mut all = DMatrix::zeros(values.len(), 1 + PERMUTED);
        all.column_mut(0).copy_from_slice(values);
        for (k, order) in self.orders.iter().enumerate() {
            for (to, from) in all.column_mut(1 + k).iter_mut().zip(order) {
                *to = values[*from as usize];
            }
        }
        all
    }
}

/// A family, calibrated.
pub(super) struct Calibrated {
    /// For each question, the share of permutations in which any question is answered as strongly.
    pub(super) p_values: Vec<f64>,
    /// For each question, the mean of its statistic over the permutations.
    pub(super) by_chance: Vec<f64>,
}

/// Questions together. Each is put on one scale first, by the cube root of Wilson and Hilferty (1931) with its mean and variance over the
/// permutations; the strongest in each permutation then says what chance answers.
pub(super) fn calibrated(statistics: &[Statistic]) -> Calibrated {
    let mut greatest = vec![f64::NEG_INFINITY; PERMUTED];
    let mut own = Vec::new();
    let mut by_chance = Vec::new();
    for statistic in statistics {
        let n = PERMUTED as f64;
        let mean = statistic[1..].iter().sum::<f64>() / n;
        let variance = statistic[1..]
            .iter()
            .map(|t| (t - mean).powi(2))
            .sum::<f64>()
            / (n - 1.0);
        by_chance.push(mean);
        if mean.is_nan() || mean <= 0.0 || variance <= 0.0 {
            own.push(f64::NEG_INFINITY);
            continue;
        }
        let spread = variance / (9.0 * mean * mean);
        let scale = |t: f64| ((t.max(0.0) / mean).cbrt() - (1.0 - spread)) / spread.sqrt();
        for (greatest, t) in greatest.iter_mut().zip(&statistic[1..]) {
            *greatest = greatest.max(scale(*t));
        }
        own.push(scale(statistic[0]));
    }
    greatest.sort_by(f64::total_cmp);
    let p_value = |own: &f64| {
        let beyond = PERMUTED - greatest.partition_point(|t| t < own);
        (1 + beyond) as f64 / (1 + PERMUTED) as f64
    };
    Calibrated {
        p_values: own.iter().map(p_value).collect(),
        by_chance,
    }
}
