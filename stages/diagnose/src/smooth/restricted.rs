//! Smooth launch errors by the command, by restricted likelihood: a Gaussian process over speeds or angles beside scatter that is
//! estimated anew with it.
//!
//! An arm whose error waves with its command scatters, to one who does not look at the command. At that scatter the wave is no
//! surprise; compared are therefore two models, each at its own scatter. The ratio of their likelihoods depends on no scatter, and
//! its distribution is known from the replicates (exact restricted likelihood ratio tests; Crainiceanu and Ruppert 2004).

use std::f64::consts::FRAC_PI_2;

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rayon::prelude::*;
use values::Point;

use crate::{
    mixed::{ANGLE, SPEED},
    score::{Deviations, ScoreTest},
};

/// Lengths over which an error stays alike, as shares of the range of commands.
const LENGTHS: [f64; 4] = [0.05, 0.1, 0.2, 0.4];
/// Variances of the process that are tried, in units of the scatter's.
const RATIOS: [f64; 7] = [0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0];
/// Distance of the bumps that span a process, as a share of its length, and how many stand beyond each end.
const CLOSE: f64 = 0.5;
const BEYOND: usize = 3;
/// Variance of a direction below which the process does not reach it.
const NEGLIGIBLE: f64 = 1e-9;
/// Share of what is known of a direction of the model's values that must come from these deviations for it to count as fitted to them.
/// Others are known from elsewhere, such as friction from the way an object slows.
const FITTED: f64 = 0.5;

/// What a smooth launch error gains.
pub(crate) struct Restricted {
    /// In restricted log-likelihood.
    pub(crate) gain: f64,
    /// The same in each replicate.
    pub(crate) by_chance: Vec<f64>,
    /// The strike at which the error is greatest, and its relative speed or angle (rad) there.
    pub(crate) strike: usize,
    pub(crate) peak: Point,
}

/// The best smooth error of speed or angle over these commanded values, one for each strike.
pub(crate) fn restricted(test: &ScoreTest<'_, '_>, at: &[f64]) -> Option<Restricted> {
    let deviations: Vec<(Point, Deviations)> =
        [(Point::new(1.0, 0.0), SPEED), (Point::new(0.0, 1.0), ANGLE)]
            .map(|(direction, nuisance)| (direction, test.deviations(nuisance)))
            .into();
    let projected: Vec<(Point, Projected)> = deviations
        .iter()
        .filter_map(|(direction, deviations)| Some((*direction, Projected::new(deviations)?)))
        .collect();
    let tried: Vec<Restricted> = projected
        .iter()
        .flat_map(|projected| LENGTHS.map(|length| (projected, length)))
        .collect::<Vec<_>>()
        .into_par_iter()
        .filter_map(|((direction, projected), length)| projected.smooth(at, length, *direction))
        .collect();
    tried.into_iter().reduce(|best, other| {
        let by_chance = best
            .by_chance
            .iter()
            .zip(&other.by_chance)
            .map(|(a, b)| a.max(*b))
            .collect();
        let better = if other.gain > best.gain { other } else { best };
        Restricted {
            by_chance,
            ..better
        }
    })
}

/// Deviations with the model's own columns projected off.
struct Projected {
    values: DMatrix<f64>,
    /// Sum of squares of each.
    squares: Vec<f64>,
    /// Orthonormal columns that span the model's own.
    own: DMatrix<f64>,
    units: DVector<f64>,
}

impl Projected {
    fn new(deviations: &Deviations) -> Option<Self> {
        let decomposed = deviations.design.clone().svd(true, false);
        let determined: Vec<usize> = (0..decomposed.singular_values.len())
            .filter(|i| decomposed.singular_values[*i].powi(2) > FITTED)
            .collect();
        let own = decomposed.u?.select_columns(&determined);
        let values = &deviations.values - &own * own.tr_mul(&deviations.values);
        let each = values.column_iter();
        Some(Self {
            squares: each.map(|column| column.norm_squared()).collect(),
            values,
            own,
            units: deviations.units.clone(),
        })
    }

    /// The best process of one length.
    fn smooth(&self, at: &[f64], length: f64, direction: Point) -> Option<Restricted> {
        let n = at.len();
        let low = at.iter().copied().fold(f64::INFINITY, f64::min);
        let high = at.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let freedom = n
            .checked_sub(self.own.ncols())
            .filter(|freedom| *freedom > 1)? as f64;
        let near = length * (high - low);
        if near <= 0.0 {
            return None;
        }
        // The process is white noise smeared out: a few bumps that stand close together span it.
        let spacing = near * CLOSE;
        let count = ((high - low) / spacing).ceil() as usize + 2 * BEYOND + 1;
        let scale = (spacing / (near * FRAC_PI_2.sqrt())).sqrt();
        let bumps = DMatrix::from_fn(n, count, |i, k| {
            let middle = low + spacing * (k as f64 - BEYOND as f64);
            scale * (-((at[i] - middle) / near).powi(2)).exp()
        });
        let apart = &bumps - &self.own * self.own.tr_mul(&bumps);
        let SymmetricEigen {
            eigenvalues,
            eigenvectors,
        } = SymmetricEigen::new(apart.tr_mul(&apart));
        let seen: Vec<usize> = (0..count)
            .filter(|i| eigenvalues[*i] > NEGLIGIBLE)
            .collect();
        let mut directions = eigenvectors.select_columns(&seen);
        for (k, i) in seen.iter().enumerate() {
            directions
                .column_mut(k)
                .scale_mut(eigenvalues[*i].sqrt().recip());
        }
        let directions = apart * directions;
        let heights = directions.tr_mul(&self.values);
        let squares = heights.map(|height| height * height);
        // What each direction keeps of its square, and loses.
        let taken = DMatrix::from_fn(RATIOS.len(), seen.len(), |r, k| {
            let ratio = RATIOS[r] * eigenvalues[seen[k]];
            ratio / (1.0 + ratio)
        });
        let fallen = &taken * &squares;
        let penalties: Vec<f64> = taken
            .row_iter()
            .map(|row| -row.map(|taken| (-taken).ln_1p()).sum())
            .collect();
        let gain = |column: usize| {
            let whole = self.squares[column];
            (0..RATIOS.len())
                .map(|r| {
                    let ratio = (whole / (whole - fallen[(r, column)]).max(1e-300)).ln();
                    (0.5 * (freedom * ratio - penalties[r]), Some(r))
                })
                .fold(
                    (0.0, None),
                    |best, tried| if tried.0 > best.0 { tried } else { best },
                )
        };
        let (best, ratio) = gain(0);
        let curve = ratio.map_or_else(
            || DVector::zeros(n),
            |r| &directions * taken.row(r).transpose().component_mul(&heights.column(0)),
        );
        let error = |i: usize| curve[i] / self.units[i];
        let strike = (0..n).max_by(|a, b| error(*a).abs().total_cmp(&error(*b).abs()))?;
        Some(Restricted {
            gain: best,
            by_chance: (1..squares.ncols()).map(|k| gain(k).0).collect(),
            strike,
            peak: direction * error(strike),
        })
    }
}
