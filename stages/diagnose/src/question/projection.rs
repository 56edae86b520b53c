//! Linear algebra of a few columns over strikes: what is taken off, and what is asked beside it.

use nalgebra::{DMatrix, DVector};

/// A column that others leave less than this share of is none of its own.
const LEAST: f64 = 1e-6;

/// Orthonormal columns that span some others.
#[derive(Clone, Debug, Default)]
pub(super) struct Basis(pub(super) Vec<DVector<f64>>);

impl Basis {
    /// An orthonormal basis of the span of these columns; linearly dependent ones are left out.
    pub(super) fn new(columns: impl IntoIterator<Item = DVector<f64>>) -> Self {
        Self::default().with(columns)
    }

    /// This basis, extended by what each of these columns holds that it does not span yet.
    pub(super) fn with(mut self, columns: impl IntoIterator<Item = DVector<f64>>) -> Self {
        for column in columns {
            let whole = column.norm();
            // Twice, for the digits that the first pass loses.
            let left = self.off(self.off(column));
            let norm = left.norm();
            if norm > LEAST * whole && norm > 0.0 {
                self.0.push(left / norm);
            }
        }
        self
    }

    /// A column less its projection onto the basis.
    pub(super) fn off(&self, mut column: DVector<f64>) -> DVector<f64> {
        for own in &self.0 {
            let along = own.dot(&column);
            column.axpy(-along, own, 1.0);
        }
        column
    }

    /// Orthonormal columns of what is left of others.
    pub(super) fn beside(
        &self,
        columns: impl IntoIterator<Item = DVector<f64>>,
    ) -> Vec<DVector<f64>> {
        let held = self.0.len();
        let mut all = self.clone().with(columns);
        all.0.drain(..held);
        all.0
    }
}

/// Σ(qᵀe)² of each column e of a matrix.
pub(super) fn explained(questions: &[DVector<f64>], all: &DMatrix<f64>) -> Vec<f64> {
    if questions.is_empty() {
        return vec![0.0; all.ncols()];
    }
    // By a product of two matrices, which is blocked, where one by dot products is not.
    let products = DMatrix::from_columns(questions).transpose() * all;
    products.column_iter().map(|c| c.norm_squared()).collect()
}
