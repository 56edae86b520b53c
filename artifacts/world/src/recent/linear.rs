//! Plain arrays as vectors and matrices, and back: files hold arrays.

use nalgebra::{Matrix3, Vector3};

pub(super) type Vector = Vector3<f64>;
pub(super) type Matrix = Matrix3<f64>;
pub(super) type Rows = [[f64; 3]; 3];

pub(super) fn matrix(rows: Rows) -> Matrix {
    Matrix::from_fn(|row, column| rows[row][column])
}

pub(super) fn rows(matrix: &Matrix) -> Rows {
    std::array::from_fn(|row| std::array::from_fn(|column| matrix[(row, column)]))
}

/// A diagonal matrix of variances, by their standard deviations.
pub(super) fn variances(deviations: [f64; 3]) -> Matrix {
    Matrix::from_diagonal(&Vector::from(deviations.map(|sd| sd * sd)))
}

/// Logarithm of a normal density, but for its constant; that of no chance where the covariance is none.
pub(super) fn log_density(away: &Vector, covariance: &Matrix) -> f64 {
    let Some(cholesky) = covariance.cholesky() else {
        return f64::NEG_INFINITY;
    };
    let half_log_det: f64 = (0..3).map(|i| cholesky.l_dirty()[(i, i)].ln()).sum();
    -0.5 * away.dot(&cholesky.solve(away)) - half_log_det
}

/// x'·A⁻¹·x; infinite where A has no inverse.
pub(super) fn distance_squared(x: &Vector, covariance: &Matrix) -> f64 {
    let cholesky = covariance.cholesky();
    cholesky.map_or(f64::INFINITY, |cholesky| x.dot(&cholesky.solve(x)))
}
