//! Columns that a fitted model lacks, and what they say.

use nalgebra::{Cholesky, DMatrix, DMatrixView, DVector, Dyn};

/// Share of a column left beside the model's own below which it differs from them by rounding alone.
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

/// Joint score of a few columns.
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
    form: QuadraticForm,
    /// Each strike's own score, a column each.
    pub(crate) by_strike: DMatrix<f64>,
}

impl Score {
    /// The gain in log-likelihood of other scores of the same columns, one set a column.
    pub(crate) fn gains(&self, scores: DMatrixView<'_, f64>) -> Vec<f64> {
        self.form.gains(scores)
    }
}

/// What scores u gain: uᵀ·1 − ½·1ᵀV·1 of the columns that are kept at a coefficient of 1, and ½·uᵀV⁻¹u of what that leaves of the others.
#[derive(Clone, Debug)]
struct QuadraticForm {
    kept: Vec<usize>,
    free: Vec<usize>,
    all_or_nothing: f64,
    moved: DVector<f64>,
    factor: Cholesky<f64, Dyn>,
}

impl QuadraticForm {
    fn new(information: &DMatrix<f64>, is_kept: &[bool]) -> Option<Self> {
        let at = |kept: bool| -> Vec<usize> {
            let all = 0..is_kept.len();
            all.filter(|i| is_kept[*i] == kept).collect()
        };
        let (kept, free) = (at(true), at(false));
        let between = |a: &[usize], b: &[usize]| information.select_rows(a).select_columns(b);
        let ones = DVector::repeat(kept.len(), 1.0);
        Some(Self {
            all_or_nothing: -0.5 * ones.dot(&(between(&kept, &kept) * &ones)),
            moved: between(&free, &kept) * ones,
            factor: between(&free, &free).cholesky()?,
            kept,
            free,
        })
    }

    /// Scores of the columns that are free, less what those that are kept take.
    fn left(&self, scores: DMatrixView<'_, f64>) -> DMatrix<f64> {
        let mut left = scores.select_rows(&self.free);
        for mut column in left.column_iter_mut() {
            column -= &self.moved;
        }
        left
    }

    /// Gain of each column of scores: ½·uᵀV⁻¹u is half the square of L⁻¹u.
    fn gains(&self, scores: DMatrixView<'_, f64>) -> Vec<f64> {
        let mut left = self.left(scores);
        self.factor.l_dirty().solve_lower_triangular_mut(&mut left);
        let gain = |k: usize| {
            let by_kept: f64 = self.kept.iter().map(|i| scores[(*i, k)]).sum();
            self.all_or_nothing + by_kept + 0.5 * left.column(k).norm_squared()
        };
        (0..scores.ncols()).map(gain).collect()
    }
}

/// Scores u and information V of columns, the model's own projected off.
pub(crate) struct ColumnScores {
    pub(crate) information: DMatrix<f64>,
    /// Information of each column alone, the model's own columns not projected off.
    pub(crate) alone: Vec<f64>,
    /// One column for the residual, then one for each replicate.
    pub(crate) scores: DMatrix<f64>,
    /// Each strike's own score, a column each.
    pub(super) by_strike: DMatrix<f64>,
}

impl ColumnScores {
    /// The joint score, columns that are kept at a coefficient of 1; `None` where the model's own columns leave nothing of these.
    pub(crate) fn score(self, is_kept: &[bool]) -> Option<Score> {
        let count = self.information.nrows();
        if (0..count).any(|i| self.information[(i, i)] < APART * self.alone[i]) {
            return None;
        }
        let errors = self.information.clone().cholesky()?.inverse();
        let form = QuadraticForm::new(&self.information, is_kept)?;
        let mut found = form.left(self.scores.columns(0, 1).as_view());
        form.factor.solve_mut(&mut found);
        let mut coefficients = vec![1.0; count];
        for (i, place) in form.free.iter().enumerate() {
            coefficients[*place] = found[i];
        }
        let mut gains = form.gains(self.scores.as_view());
        let by_chance = gains.split_off(1);
        Some(Score {
            gain: gains[0],
            error: errors[(0, 0)].max(0.0).sqrt(),
            coefficients,
            by_chance,
            form,
            by_strike: self.by_strike,
        })
    }
}
