//! What strikes say of one of their nuisances, in units of its standard deviation at the fitted scatter.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::ScoreTest;

/// One nuisance of all strikes.
pub(crate) struct Deviations {
    /// A row for each strike; the measured ones, then each replicate's: of variance 1 where nothing is missing.
    pub(crate) values: DMatrix<f64>,
    /// What the model's own values do to them, one standard error each, their errors independent.
    pub(crate) design: DMatrix<f64>,
    /// One over each strike's standard deviation.
    pub(crate) units: DVector<f64>,
}

impl ScoreTest<'_, '_> {
    /// How each strike's own nuisance differs from what the model says: gᵀΣ⁻¹(r − X·β), g the nuisance's column, over its standard
    /// deviation √(gᵀΣ⁻¹g).
    pub(crate) fn deviations(&self, nuisance: usize) -> Deviations {
        let flipped = self.signs.ncols();
        let (p, all) = (self.fitted.model.free.len(), self.inverse.nrows());
        let beta = &self.inverse * self.scores.column(0);
        let errors = self.inverse.view((0, 0), (p, p)).into_owned().cholesky();
        let rows: Vec<_> = self
            .strikes
            .par_iter()
            .map(|at| {
                let g = at.whitened.nuisances.column(nuisance);
                let projected = at.whitened.nuisances.tr_mul(&g);
                let taken = projected.dot(&(&at.posterior * &projected));
                let unit = (g.norm_squared() * at.precision - taken).max(1e-300).sqrt();
                let weighed = at.weighed.columns(0, all + 1).tr_mul(&g) / unit;
                let left = weighed[all] - beta.dot(&weighed.rows(0, all));
                (left, weighed.rows(0, p).into_owned(), unit)
            })
            .collect();
        let n = rows.len();
        let normals = self.normals(n, nuisance as u64);
        let drawn = normals.ncols();
        let mut values = DMatrix::zeros(n, 1 + drawn + flipped);
        values.columns_mut(1, drawn).copy_from(&normals);
        let mut design = DMatrix::zeros(n, p);
        for (i, (left, own, _)) in rows.iter().enumerate() {
            values[(i, 0)] = *left;
            for flip in 0..flipped {
                values[(i, 1 + drawn + flip)] = left * self.signs[(i, flip)];
            }
            design.row_mut(i).copy_from(&own.transpose());
        }
        Deviations {
            values,
            design: errors.map_or_else(|| design.clone(), |errors| &design * errors.l()),
            units: DVector::from_iterator(n, rows.iter().map(|(_, _, unit)| *unit)),
        }
    }
}
