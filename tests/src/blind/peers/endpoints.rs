//! How often chance alone makes the gain of a sweep over end points: a parametric bootstrap of the fitted null.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use values::Point;

const DRAWS: usize = 299;

/// Residuals of the null and the directions in which candidates change them.
pub(super) struct Calibration {
    residual: DVector<f64>,
    /// Orthonormal basis of what the null absorbs.
    absorbed: DMatrix<f64>,
    /// Each candidate's number of parameters and the orthonormal basis of what it adds.
    candidates: Vec<(usize, DMatrix<f64>)>,
    /// From start to stop, for each strike, in m.
    paths: Vec<Point>,
}

/// Orthonormal basis of the columns' span: directions below a millionth of the largest are rounding.
fn basis(columns: &DMatrix<f64>) -> DMatrix<f64> {
    let svd = columns.clone().svd(true, false);
    let largest = svd.singular_values.max();
    let kept: Vec<_> = svd
        .u
        .iter()
        .flat_map(|u| u.column_iter())
        .zip(svd.singular_values.iter())
        .filter(|(_, value)| **value > 1e-6 * largest && largest > 0.0)
        .map(|(column, _)| column.into_owned())
        .collect();
    if kept.is_empty() {
        return DMatrix::zeros(columns.nrows(), 0);
    }
    DMatrix::from_columns(&kept)
}

impl Calibration {
    /// `residual` holds x and y of each strike's stop; the matrices' columns are derivatives of it.
    pub(super) fn new(
        residual: DVector<f64>,
        nuisances: DMatrix<f64>,
        candidates: &[(usize, DMatrix<f64>)],
        paths: Vec<Point>,
    ) -> Self {
        let absorbed = basis(&nuisances);
        let off = |columns: &DMatrix<f64>| columns - &absorbed * absorbed.tr_mul(columns);
        let candidates = candidates
            .iter()
            .map(|(freed, columns)| {
                // Directions in units of their own size, so that none counts as rounding for its unit.
                let mut columns = off(columns);
                for mut column in columns.column_iter_mut() {
                    let norm = column.norm();
                    if norm > 0.0 {
                        column /= norm;
                    }
                }
                (*freed, basis(&columns))
            })
            .collect();
        Self {
            residual: &residual - &absorbed * absorbed.tr_mul(&residual),
            absorbed,
            candidates,
            paths,
        }
    }

    /// The best candidate's gain in BIC, to first order.
    fn gain(&self, residual: &DVector<f64>) -> f64 {
        let (rows, square) = (residual.len() as f64, residual.norm_squared());
        let gain = |(freed, basis): &(usize, DMatrix<f64>)| {
            let explained = basis
                .tr_mul(residual)
                .norm_squared()
                .min(0.999_999 * square);
            -rows * (1.0 - explained / square).ln() - *freed as f64 * rows.ln()
        };
        self.candidates
            .iter()
            .map(gain)
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// Share of draws of the null whose best gain is as large. Launches scatter along and across the path in proportion to it.
    pub(super) fn p_value(&self, seed: u64) -> f64 {
        let axes: Vec<(Point, Point)> = self
            .paths
            .iter()
            .map(|path| (*path, path.rotated(std::f64::consts::FRAC_PI_2)))
            .collect();
        let spread = |axis: fn(&(Point, Point)) -> Point| {
            let squares = axes.iter().enumerate().map(|(i, axes)| {
                let axis = axis(axes);
                let at = Point::new(self.residual[2 * i], self.residual[2 * i + 1]);
                (at.dot(axis) / axis.dot(axis).max(1e-12)).powi(2)
            });
            (squares.sum::<f64>() / axes.len().max(1) as f64).sqrt()
        };
        let (along, across) = (spread(|axes| axes.0), spread(|axes| axes.1));
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let measured = self.gain(&self.residual);
        let mut as_large = 0;
        for _ in 0..DRAWS {
            let mut drawn = DVector::zeros(self.residual.len());
            for (i, (ahead, aside)) in axes.iter().enumerate() {
                let off = *ahead * (along * normal()) + *aside * (across * normal());
                (drawn[2 * i], drawn[2 * i + 1]) = (off.x, off.y);
            }
            drawn -= &self.absorbed * self.absorbed.tr_mul(&drawn);
            as_large += usize::from(self.gain(&drawn) >= measured);
        }
        (1 + as_large) as f64 / (1 + DRAWS) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Strikes in all directions; a candidate that shifts the stops along x for each metre of y.
    fn calibration(shift: f64, seed: u64) -> Calibration {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let paths: Vec<Point> = (0..60)
            .map(|i| Point::polar(0.3 + 0.003 * f64::from(i), 0.03 * f64::from(i) - 0.9))
            .collect();
        let shear = DVector::from_iterator(120, paths.iter().flat_map(|p| [p.y, 0.0]));
        let scale = DVector::from_iterator(120, paths.iter().flat_map(|p| [p.x, p.y]));
        let noise: Vec<f64> = paths
            .iter()
            .flat_map(|p| {
                let off = *p * (0.01 * normal()) + Point::new(-p.y, p.x) * (0.01 * normal());
                [off.x, off.y]
            })
            .collect();
        Calibration::new(
            DVector::from_vec(noise) + &shear * shift,
            DMatrix::from_columns(&[scale]),
            &[(1, DMatrix::from_columns(&[shear]))],
            paths,
        )
    }

    #[test]
    fn chance_alone_alarms_as_often_as_it_says_and_an_effect_always() {
        let alarms = (0..200).filter(|seed| calibration(0.0, *seed).p_value(1) < 0.05);
        assert!((2..=22).contains(&alarms.count()));
        assert!(calibration(0.05, 3).p_value(1) < 0.01);
    }
}
