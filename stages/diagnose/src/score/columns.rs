//! Columns that a fitted model lacks, and what they say.

use nalgebra::{DMatrix, DVector};

/// A column of which less than this share is left beside the model's own differs from them by rounding.
const APART: f64 = 1e-6;

/// Whitened columns of each strike; none where it is not touched.
pub(crate) type StrikeColumns = Vec<Option<DMatrix<f64>>>;

/// Columns that stand beside the model's own, with coefficients of mean zero and this variance.
#[derive(Clone, Debug)]
pub(crate) struct RandomColumns {
    pub(crate) moved: StrikeColumns,
    pub(crate) variance: f64,
}

impl RandomColumns {
    pub(super) fn count(&self) -> usize {
        let first = self.moved.iter().flatten().next();
        first.map_or(0, DMatrix::ncols)
    }
}

/// What a few columns say together.
#[derive(Clone, Debug)]
pub(crate) struct Score {
    /// Gain in log-likelihood, S/2.
    pub(crate) gain: f64,
    /// Best coefficient of each column.
    pub(crate) coefficients: Vec<f64>,
    /// Standard error of the first column's coefficient.
    pub(crate) error: f64,
    /// The gain in each replicate: those drawn, then those flipped.
    pub(crate) by_chance: Vec<f64>,
}

/// Scores u and information V of columns, the model's own projected off.
pub(crate) struct ColumnScores {
    pub(crate) information: DMatrix<f64>,
    /// What each column's information would be alone.
    pub(crate) alone: Vec<f64>,
    /// One column for the residual, then one for each replicate.
    pub(crate) scores: DMatrix<f64>,
    /// How far each of the model's own values (columns) makes up for each of these (rows).
    pub(crate) made_up: DMatrix<f64>,
}

impl ColumnScores {
    /// The joint score, columns that are kept at a coefficient of 1; `None` where the model's own columns leave nothing of these.
    pub(crate) fn score(&self, is_kept: &[bool]) -> Option<Score> {
        let count = self.information.nrows();
        if (0..count).any(|i| self.information[(i, i)] < APART * self.alone[i]) {
            return None;
        }
        let errors = self.information.clone().cholesky()?.inverse();
        let at =
            |kept: bool| -> Vec<usize> { (0..count).filter(|i| is_kept[*i] == kept).collect() };
        let (kept, free) = (at(true), at(false));
        let between = |a: &[usize], b: &[usize]| self.information.select_rows(a).select_columns(b);
        let ones = DVector::repeat(kept.len(), 1.0);
        let all_or_nothing = -0.5 * ones.dot(&(between(&kept, &kept) * &ones));
        let moved = between(&free, &kept) * ones;
        let factor = between(&free, &free).cholesky()?;
        let gained = |k: usize| {
            let u = self.scores.column(k);
            let left = DVector::from_fn(free.len(), |i, _| u[free[i]] - moved[i]);
            let coefficients = factor.solve(&left);
            let by_kept: f64 = kept.iter().map(|i| u[*i]).sum();
            let gain = all_or_nothing + by_kept + 0.5 * left.dot(&coefficients);
            (gain, coefficients)
        };
        let (gain, found) = gained(0);
        let mut coefficients = vec![1.0; count];
        for (i, place) in free.iter().enumerate() {
            coefficients[*place] = found[i];
        }
        Some(Score {
            gain,
            error: errors[(0, 0)].max(0.0).sqrt(),
            coefficients,
            by_chance: (1..self.scores.ncols()).map(|k| gained(k).0).collect(),
        })
    }
}
