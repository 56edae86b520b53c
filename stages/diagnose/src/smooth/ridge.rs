//! Bumps together: heights that are Gaussian with one common standard deviation, by marginal likelihood.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::score::ColumnScores;

/// Common heights tried, relative to the bumps' scale.
const HEIGHTS: [f64; 7] = [0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0];
/// Information below which the strikes see nothing of a direction.
const SEEN: f64 = 1e-9;

/// What a set of bumps gains together.
pub(crate) struct Ridge {
    /// Gain in marginal likelihood over no bumps; 0 where none is better.
    pub(crate) gain: f64,
    /// Variance of the heights; 0 where none is better.
    pub(crate) variance: f64,
    /// Their best values.
    pub(crate) heights: DVector<f64>,
    /// The gain in each replicate.
    pub(crate) by_chance: Vec<f64>,
}

impl Ridge {
    /// The best common height, its gain, and the same in each replicate: drawn from what is known of the heights (`normals` has a row for
    /// each bump, a column for each replicate), then flipped.
    pub(crate) fn new(scores: &ColumnScores, scale: f64, normals: &DMatrix<f64>) -> Self {
        let SymmetricEigen {
            eigenvalues,
            eigenvectors,
        } = SymmetricEigen::new(scores.information.clone());
        let projected = eigenvectors.tr_mul(&scores.scores);
        let seen: Vec<usize> = (0..eigenvalues.len())
            .filter(|i| eigenvalues[*i] > SEEN)
            .collect();
        let variances = HEIGHTS.map(|height| (height * scale).powi(2));
        // Shares of squares that are taken, and what a common height costs.
        let taken: Vec<(Vec<f64>, f64)> = variances
            .iter()
            .map(|variance| {
                let ratio = |i: &usize| eigenvalues[*i] * variance;
                let shares = seen.iter().map(|i| 0.5 * ratio(i) / (1.0 + ratio(i)));
                let cost = seen.iter().map(|i| 0.5 * ratio(i).ln_1p()).sum();
                (shares.collect(), cost)
            })
            .collect();
        let gain = |squares: &[f64]| {
            taken
                .iter()
                .zip(variances)
                .map(|((shares, cost), variance)| {
                    let each = shares.iter().zip(squares);
                    (
                        each.map(|(share, square)| share * square).sum::<f64>() - cost,
                        variance,
                    )
                })
                .fold(
                    (0.0, 0.0),
                    |best, tried| if tried.0 > best.0 { tried } else { best },
                )
        };
        let of_score = |k: usize| -> Vec<f64> {
            let each = seen.iter();
            each.map(|i| projected[(*i, k)].powi(2) / eigenvalues[*i])
                .collect()
        };
        let drawn = normals.column_iter().map(|normals| {
            let squares: Vec<f64> = seen.iter().map(|i| normals[*i].powi(2)).collect();
            gain(&squares).0
        });
        let flipped = (1..projected.ncols()).map(|k| gain(&of_score(k)).0);
        let (best, variance) = gain(&of_score(0));
        let mut heights = DVector::zeros(scores.alone.len());
        for i in &seen {
            let (l, u) = (eigenvalues[*i], projected[(*i, 0)]);
            heights += eigenvectors.column(*i) * (u * variance / (1.0 + l * variance));
        }
        Self {
            gain: best,
            variance,
            heights,
            by_chance: drawn.chain(flipped).collect(),
        }
    }
}
