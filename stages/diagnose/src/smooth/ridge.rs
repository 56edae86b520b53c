//! Bumps together: heights that are Gaussian with one common standard deviation, by marginal likelihood.

use nalgebra::{DVector, SymmetricEigen};

use crate::score::ColumnScores;

/// Common heights tried, relative to the bumps' scale.
const HEIGHTS: [f64; 7] = [0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0];
/// Information below which the strikes see nothing of a direction.
const SEEN: f64 = 1e-9;

/// Heights of a set of bumps.
pub(crate) struct Ridge {
    /// Variance of the heights; 0 where none is better.
    pub(crate) variance: f64,
    /// Their best values.
    pub(crate) heights: DVector<f64>,
}

impl Ridge {
    /// The best common height, relative to these bumps' scale.
    pub(crate) fn new(scores: &ColumnScores, scale: f64) -> Self {
        let SymmetricEigen {
            eigenvalues,
            eigenvectors,
        } = SymmetricEigen::new(scores.information.clone());
        let projected = eigenvectors.tr_mul(&scores.scores.column(0));
        let seen: Vec<usize> = (0..eigenvalues.len())
            .filter(|i| eigenvalues[*i] > SEEN)
            .collect();
        // Gain in marginal likelihood over no bumps: squares that are taken, less what a common height costs.
        let gain = |variance: f64| -> f64 {
            let each = seen.iter().map(|i| {
                let ratio = eigenvalues[*i] * variance;
                let square = projected[*i].powi(2) / eigenvalues[*i];
                0.5 * (square * ratio / (1.0 + ratio) - ratio.ln_1p())
            });
            each.sum()
        };
        let tried = HEIGHTS.map(|height| (height * scale).powi(2));
        let (_, variance) = tried
            .into_iter()
            .map(|variance| (gain(variance), variance))
            .fold(
                (0.0, 0.0),
                |best, tried| if tried.0 > best.0 { tried } else { best },
            );
        let mut heights = DVector::zeros(scores.alone.len());
        for i in &seen {
            let (l, u) = (eigenvalues[*i], projected[*i]);
            heights += eigenvectors.column(*i) * (u * variance / (1.0 + l * variance));
        }
        Self { variance, heights }
    }
}
