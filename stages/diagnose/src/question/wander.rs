//! A wander over the order beside scatter that is independent: covariance I + λK, K = min(i, j)/n, whose eigenvectors are sines.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use super::projection::Basis;

/// Variances of the wander over n strikes that are tried, in units of the scatter's.
const RATIOS: [f64; 11] = [
    0.0, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0,
];
/// Log-likelihood that a value loses within its 95 % interval: half of χ²'s quantile at one degree of freedom.
const WITHIN: f64 = 1.92;

/// The wander of so many strikes.
pub(super) struct Wander {
    vectors: DMatrix<f64>,
    values: DVector<f64>,
}

impl Wander {
    pub(super) fn new(strikes: usize) -> Self {
        let n = strikes as f64;
        let rate = |k: usize| (2 * k + 1) as f64 * PI / (2.0 * n + 1.0);
        Self {
            vectors: DMatrix::from_fn(strikes, strikes, |i, k| {
                2.0 / (2.0 * n + 1.0).sqrt() * (rate(k) * (i + 1) as f64).sin()
            }),
            values: DVector::from_fn(strikes, |k, _| {
                1.0 / (4.0 * n * (0.5 * rate(k)).sin().powi(2))
            }),
        }
    }

    /// What changes smoothly with the order: the same sines, each as strong as a wander's squared. A wander is rough, its steps are independent.
    pub(super) fn smooth(&self) -> Self {
        Self {
            vectors: self.vectors.clone(),
            values: self.values.map(|k| k * k / self.values.len() as f64),
        }
    }

    /// The likelihood of columns that also depend on these others.
    pub(super) fn beside(&self, others: &[DVector<f64>]) -> WanderBeside<'_> {
        let others: Vec<DVector<f64>> = others.iter().map(|c| self.vectors.tr_mul(c)).collect();
        let each = RATIOS.into_iter().map(|ratio| {
            let root = self.values.map(|k| (1.0 + ratio * k).sqrt().recip());
            let mut restricted = 0.0;
            let mut basis = Basis::default();
            for other in &others {
                let weighed = other.component_mul(&root);
                let norm = basis.off(weighed.clone()).norm();
                let held = basis.0.len();
                basis = basis.with([weighed]);
                if basis.0.len() > held {
                    restricted += 2.0 * norm.ln();
                }
            }
            AtRatio {
                ratio,
                determinant: -2.0 * root.map(f64::ln).sum(),
                restricted,
                root,
                basis,
            }
        });
        WanderBeside {
            wander: self,
            each: each.collect(),
        }
    }

    /// A column of this wander beside scatter of 1, from independent ones.
    pub(super) fn drawn(&self, ratio: f64, independent: &DVector<f64>) -> DVector<f64> {
        let root = self.values.map(|k| (1.0 + ratio * k).sqrt());
        &self.vectors * independent.component_mul(&root)
    }

    /// A column times (I + λK)^−½: then strikes are independent.
    pub(super) fn whitened(&self, ratio: f64, column: &DVector<f64>) -> DVector<f64> {
        if ratio == 0.0 {
            return column.clone();
        }
        let root = self.values.map(|k| (1.0 + ratio * k).sqrt().recip());
        &self.vectors * self.vectors.tr_mul(column).component_mul(&root)
    }
}

/// What a Kalman filter of a wander with this ratio beside scatter of 1 does not foresee of each value, over its own standard deviation.
pub(super) fn innovations(values: &[f64], ratio: f64) -> Vec<f64> {
    let step = ratio / values.len() as f64;
    let (mut state, mut variance) = (0.0, 1.0 + ratio);
    let each = values.iter().map(|value| {
        variance += step;
        let innovation = value - state;
        let total = variance + 1.0;
        state += variance / total * innovation;
        variance /= total;
        innovation / total.sqrt()
    });
    each.collect()
}

/// A wander beside other columns, at each ratio.
pub(super) struct WanderBeside<'w> {
    wander: &'w Wander,
    each: Vec<AtRatio>,
}

struct AtRatio {
    ratio: f64,
    root: DVector<f64>,
    basis: Basis,
    /// ln det(I + λK), and of the other columns' information.
    determinant: f64,
    restricted: f64,
}

impl WanderBeside<'_> {
    /// −2 ln L at each ratio: of the whole likelihood, or the restricted one.
    fn deviances(&self, column: &DVector<f64>, is_restricted: bool) -> Vec<(f64, f64)> {
        let turned = self.wander.vectors.tr_mul(column);
        let n = column.len() as f64;
        let each = self.each.iter().map(|at| {
            let left = at.basis.off(turned.component_mul(&at.root)).norm_squared();
            let (freedom, further) = match is_restricted {
                true => (n - at.basis.0.len() as f64, at.restricted),
                false => (n, 0.0),
            };
            let deviance = freedom * (left / freedom).max(1e-300).ln() + at.determinant + further;
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
    use super::*;

    #[test]
    fn innovations_of_a_wander_are_independent() {
        use rand::SeedableRng;
        use rand_distr::{Distribution, StandardNormal};
        let n = 4000;
        let wander = Wander::new(n / 20);
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let (mut squares, mut products) = (0.0, 0.0);
        for _ in 0..20 {
            let independent = DVector::from_fn(n / 20, |_, _| StandardNormal.sample(&mut random));
            let drawn = wander.drawn(30.0, &independent);
            let found = innovations(drawn.as_slice(), 30.0);
            squares += found[1..].iter().map(|v| v * v).sum::<f64>();
            products += found[1..]
                .windows(2)
                .map(|pair| pair[0] * pair[1])
                .sum::<f64>();
        }
        assert!((squares / n as f64 - 1.0).abs() < 0.1, "{squares}");
        assert!((products / squares).abs() < 0.06, "{products}");
    }

    #[test]
    fn the_sines_are_the_eigenvectors_of_a_wander() {
        let n = 30;
        let wander = Wander::new(n);
        let restored =
            &wander.vectors * DMatrix::from_diagonal(&wander.values) * wander.vectors.transpose();
        for (i, j) in [(0, 0), (3, 20), (29, 29), (12, 11)] {
            let truth = (i.min(j) + 1) as f64 / n as f64;
            assert!((restored[(i, j)] - truth).abs() < 1e-9);
        }
    }
}
