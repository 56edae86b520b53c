//! Bumps together: heights that are Gaussian with one common standard deviation, by marginal likelihood.

use nalgebra::{DVector, SymmetricEigen};

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
    /// The best common height, its gain, and the same in each replicate.
    pub(crate) fn new(scores: &ColumnScores, scale: f64) -> Self {
        let SymmetricEigen {
            eigenvalues,
            eigenvectors,
        } = SymmetricEigen::new(scores.information.clone());
        let projected = eigenvectors.tr_mul(&scores.scores);
        let seen: Vec<usize> = (0..eigenvalues.len())
            .filter(|i| eigenvalues[*i] > SEEN)
            .collect();
        let gain = |replicate: usize| {
            HEIGHTS
                .iter()
                .map(|height| {
                    let variance = (height * scale).powi(2);
                    let each = seen.iter().map(|i| {
                        let (l, u) = (eigenvalues[*i], projected[(*i, replicate)]);
                        let ratio = l * variance;
                        0.5 * (u * u / l * ratio / (1.0 + ratio) - ratio.ln_1p())
                    });
                    (each.sum::<f64>(), variance)
                })
                .fold(
                    (0.0, 0.0),
                    |best, tried| if tried.0 > best.0 { tried } else { best },
                )
        };
        let (best, variance) = gain(0);
        let mut heights = DVector::zeros(scores.alone.len());
        for i in &seen {
            let (l, u) = (eigenvalues[*i], projected[(*i, 0)]);
            heights += eigenvectors.column(*i) * (u * variance / (1.0 + l * variance));
        }
        Self {
            gain: best,
            variance,
            heights,
            by_chance: (1..projected.ncols()).map(|k| gain(k).0).collect(),
        }
    }
}
