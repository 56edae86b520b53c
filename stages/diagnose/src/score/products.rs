//! Products of columns with themselves and with what a strike holds, summed over strikes.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::{columns::StrikeColumns, strike::StrikeAtFit};

/// Products of one set of columns C, weighed by Σ⁻¹.
pub(super) struct StrikeProducts {
    /// CᵀΣ⁻¹C.
    pub(super) own: DMatrix<f64>,
    /// CᵀΣ⁻¹·[X, r, drawn residuals].
    pub(super) cross: DMatrix<f64>,
}

impl StrikeProducts {
    /// Of each set, which has so many columns, over all strikes in their order, with the first `width` of what a strike holds.
    pub(super) fn sums(
        strikes: &[StrikeAtFit<'_>],
        sets: &[(usize, &StrikeColumns)],
        width: usize,
    ) -> Vec<Self> {
        let mut sums: Vec<Self> = sets
            .iter()
            .map(|(count, _)| Self {
                own: DMatrix::zeros(*count, *count),
                cross: DMatrix::zeros(*count, width),
            })
            .collect();
        let by_strike: Vec<_> = strikes
            .par_iter()
            .enumerate()
            .map(|(i, at)| Self::of_strike(at, i, sets, width))
            .collect();
        for of_strike in by_strike {
            for (place, Self { own, cross }) in of_strike {
                sums[place].own += own;
                sums[place].cross += cross;
            }
        }
        sums
    }

    /// Of the sets that touch a strike, each with its place.
    fn of_strike(
        at: &StrikeAtFit<'_>,
        strike: usize,
        sets: &[(usize, &StrikeColumns)],
        width: usize,
    ) -> Vec<(usize, Self)> {
        let touching: Vec<(usize, &DMatrix<f64>)> = sets
            .iter()
            .enumerate()
            .filter_map(|(place, (_, moved))| Some((place, moved[strike].as_ref()?)))
            .collect();
        let columns: usize = touching.iter().map(|(_, c)| c.ncols()).sum();
        let mut all = DMatrix::zeros(at.weighed.nrows(), columns);
        let mut first = 0;
        for (_, c) in &touching {
            all.columns_mut(first, c.ncols()).copy_from(c);
            first += c.ncols();
        }
        let cross = all.transpose() * at.weighed.columns(0, width);
        let mut first = 0;
        touching
            .into_iter()
            .map(|(place, c)| {
                let projected = at.whitened.nuisances.tr_mul(c);
                let own = gram(c) * at.precision - projected.tr_mul(&(&at.posterior * &projected));
                let cross = cross.rows(first, c.ncols()).into_owned();
                first += c.ncols();
                (place, Self { own, cross })
            })
            .collect()
    }
}

/// CᵀC: of many columns by a product of two matrices, which is blocked, where one by dot products is not.
fn gram(columns: &DMatrix<f64>) -> DMatrix<f64> {
    const MANY: usize = 8;
    match columns.ncols() > MANY {
        true => columns.transpose() * columns,
        false => columns.tr_mul(columns),
    }
}
