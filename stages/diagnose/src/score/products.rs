//! Products of columns with themselves and with what a strike holds, summed over strikes.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::{columns::StrikeColumns, strike::StrikeAtFit};
use crate::mixed::NUISANCES;

/// Products of one set of columns C, weighed by Σ⁻¹.
pub(super) struct StrikeProducts {
    /// CᵀΣ⁻¹C.
    pub(super) own: DMatrix<f64>,
    /// [X, r, drawn residuals]ᵀΣ⁻¹·C.
    pub(super) cross: DMatrix<f64>,
}

/// One strike's products of all sets of columns that change it, side by side.
struct OfStrike {
    /// Places of these sets.
    touching: Vec<usize>,
    /// Set by set, column by column.
    own: Vec<f64>,
    cross: DMatrix<f64>,
}

impl StrikeProducts {
    /// Products of each set (its number of columns beside it), summed over strikes in their order; `cross` with the first `width` columns of what a
    /// strike holds.
    pub(super) fn sums(
        strikes: &[StrikeAtFit<'_>],
        sets: &[(usize, &StrikeColumns)],
        width: usize,
    ) -> Vec<Self> {
        let mut sums: Vec<Self> = sets
            .iter()
            .map(|(count, _)| Self {
                own: DMatrix::zeros(*count, *count),
                cross: DMatrix::zeros(width, *count),
            })
            .collect();
        let by_strike: Vec<OfStrike> = strikes
            .par_iter()
            .enumerate()
            .map(|(i, at)| OfStrike::new(at, i, sets, width))
            .collect();
        for of_strike in by_strike {
            let (mut first, mut own) = (0, of_strike.own.iter());
            for place in of_strike.touching {
                let sum = &mut sums[place];
                let count = sum.own.ncols();
                sum.own
                    .iter_mut()
                    .zip(&mut own)
                    .for_each(|(sum, own)| *sum += own);
                sum.cross += of_strike.cross.view((NUISANCES, first), (width, count));
                first += count;
            }
        }
        sums
    }
}

impl OfStrike {
    fn new(
        at: &StrikeAtFit<'_>,
        strike: usize,
        sets: &[(usize, &StrikeColumns)],
        width: usize,
    ) -> Self {
        let (touching, columns): (Vec<usize>, Vec<&DMatrix<f64>>) = sets
            .iter()
            .enumerate()
            .filter_map(|(place, (_, moved))| Some((place, moved[strike].as_ref()?)))
            .unzip();
        let count = columns.iter().map(|c| c.ncols()).sum();
        let mut all = DMatrix::zeros(at.seen.ncols(), count);
        let mut first = 0;
        for c in &columns {
            all.columns_mut(first, c.ncols()).copy_from(c);
            first += c.ncols();
        }
        // By products of two matrices, which are blocked, where dot products are not.
        let cross = at.seen.rows(0, NUISANCES + width) * all;
        let by_nuisances = cross.rows(0, NUISANCES);
        let explained = &at.posterior * by_nuisances;
        let mut own = Vec::with_capacity(columns.iter().map(|c| c.ncols().pow(2)).sum());
        let mut first = 0;
        for c in columns {
            let gram = gram(c);
            for j in 0..c.ncols() {
                let explained = explained.column(first + j);
                own.extend((0..c.ncols()).map(|i| {
                    gram[(i, j)] * at.precision - by_nuisances.column(first + i).dot(&explained)
                }));
            }
            first += c.ncols();
        }
        Self {
            touching,
            own,
            cross,
        }
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
