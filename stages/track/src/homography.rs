//! A homography between two planes, by least squares (Hartley and Zisserman 2004, section 4.1).

use nalgebra::{SMatrix, SVector};

/// The numbers [a, b, c, d, e, f, g, h] of the map from (x, y) to ((a·x + b·y + c) / (g·x + h·y + 1), (d·x + e·y + f) / (g·x + h·y + 1))
/// that fits these pairs of points best; none where they do not determine it. Points should be about one from their middle.
pub(crate) fn homography(
    pairs: impl IntoIterator<Item = ([f64; 2], [f64; 2])>,
) -> Option<[f64; 8]> {
    let (mut normal, mut right) = (SMatrix::<f64, 8, 8>::zeros(), SVector::<f64, 8>::zeros());
    for ([x, y], [u, v]) in pairs {
        let rows = [
            ([x, y, 1.0, 0.0, 0.0, 0.0, -u * x, -u * y], u),
            ([0.0, 0.0, 0.0, x, y, 1.0, -v * x, -v * y], v),
        ];
        for (row, at) in rows {
            let row = SVector::from(row);
            normal += row * row.transpose();
            right += at * row;
        }
    }
    let found = normal.lu().solve(&right)?;
    found
        .iter()
        .all(|part| part.is_finite())
        .then(|| found.into())
}
