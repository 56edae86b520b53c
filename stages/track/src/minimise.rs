//! Least squares of few unknowns: Levenberg–Marquardt with differences for slopes.

use nalgebra::{DMatrix, DVector};

#[derive(Clone, Debug)]
pub(crate) struct LeastSquares {
    pub(crate) at: Vec<f64>,
    /// What is left of each equation.
    pub(crate) left: Vec<f64>,
    /// Covariance of the unknowns where the equations have a variance of 1.
    pub(crate) covariance: DMatrix<f64>,
}

impl LeastSquares {
    pub(crate) fn squares(&self) -> f64 {
        self.left.iter().map(|left| left * left).sum()
    }
}

/// Rounds at the most, and the share of the sum below which a round is the last.
const ROUNDS: usize = 200;
const DONE: f64 = 1e-12;
/// Step of a difference, of an unknown of order one.
const STEP: f64 = 1e-6;
/// The damping to begin with, what it changes by, and where it ends without hope.
const DAMPING: f64 = 1e-3;
const EASE: f64 = 10.0;
const HOPELESS: f64 = 1e12;
/// Unknowns whose equations are nearer to singular than this are not determined.
const SINGULAR: f64 = 1e-14;

/// Minimises the squares of what `left` gives from a start on; unknowns are of order one. None where `left` gives nothing at the
/// start, or the equations do not determine the unknowns.
pub(crate) fn minimise(
    start: &[f64],
    left: &dyn Fn(&[f64]) -> Option<Vec<f64>>,
) -> Option<LeastSquares> {
    let mut at = start.to_vec();
    let mut now = left(&at)?;
    let mut damping = DAMPING;
    let squares = |left: &[f64]| left.iter().map(|left| left * left).sum::<f64>();
    for _ in 0..ROUNDS {
        let slope = slope(&at, now.len(), left)?;
        let normal = slope.transpose() * &slope;
        let toward = slope.transpose() * DVector::from_column_slice(&now);
        let before = squares(&now);
        loop {
            let mut damped = normal.clone();
            for i in 0..at.len() {
                damped[(i, i)] += damping * normal[(i, i)].max(SINGULAR);
            }
            let step = damped.cholesky()?.solve(&toward);
            let next: Vec<f64> = at.iter().zip(step.iter()).map(|(a, s)| a - s).collect();
            let then = left(&next).filter(|then| squares(then) <= before);
            if let Some(then) = then {
                (at, now) = (next, then);
                damping = (damping / EASE).max(SINGULAR);
                break;
            }
            damping *= EASE;
            if damping > HOPELESS {
                break;
            }
        }
        if damping > HOPELESS || before - squares(&now) <= DONE * before {
            break;
        }
    }
    let slope = slope(&at, now.len(), left)?;
    let normal = slope.transpose() * &slope;
    let scales: Vec<f64> = (0..at.len()).map(|i| normal[(i, i)].sqrt()).collect();
    if scales.iter().any(|scale| scale.is_nan() || *scale <= 0.0) {
        return None;
    }
    // Scaled to ones on the diagonal, so that what is singular does not depend on units.
    let scaled = DMatrix::from_fn(at.len(), at.len(), |i, j| {
        normal[(i, j)] / (scales[i] * scales[j])
    });
    let least = scaled.clone().symmetric_eigenvalues().min();
    if least.is_nan() || least < SINGULAR {
        return None;
    }
    let inverse = scaled.cholesky()?.inverse();
    let covariance = DMatrix::from_fn(at.len(), at.len(), |i, j| {
        inverse[(i, j)] / (scales[i] * scales[j])
    });
    Some(LeastSquares {
        at,
        left: now,
        covariance,
    })
}

/// How each equation changes with each unknown.
pub(crate) fn slope(
    at: &[f64],
    equations: usize,
    left: &dyn Fn(&[f64]) -> Option<Vec<f64>>,
) -> Option<DMatrix<f64>> {
    let mut slope = DMatrix::zeros(equations, at.len());
    for unknown in 0..at.len() {
        let moved = |by: f64| {
            let mut at = at.to_vec();
            at[unknown] += by;
            left(&at)
        };
        let (more, less) = (moved(STEP)?, moved(-STEP)?);
        for (equation, (more, less)) in more.iter().zip(&less).enumerate() {
            slope[(equation, unknown)] = (more - less) / (2.0 * STEP);
        }
    }
    Some(slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_found_with_its_covariance() {
        let points: Vec<f64> = (0..20).map(|k| 0.1 * f64::from(k)).collect();
        let curve = |at: &[f64], x: f64| at[0] * (-at[1] * x).exp();
        let left = |at: &[f64]| {
            let off = points
                .iter()
                .map(|x| curve(at, *x) - curve(&[2.0, 1.5], *x));
            Some(off.collect())
        };
        let least = minimise(&[1.0, 0.5], &left).expect("determined");
        assert!((least.at[0] - 2.0).abs() < 1e-6, "{least:?}");
        assert!((least.at[1] - 1.5).abs() < 1e-6, "{least:?}");
        assert!(least.covariance[(0, 0)] > 0.0);
    }

    #[test]
    fn unknowns_that_only_their_sum_determines_are_refused() {
        let left = |at: &[f64]| Some(vec![at[0] + at[1] - 1.0, 2.0 * (at[0] + at[1]) - 2.0]);
        assert!(minimise(&[0.2, 0.1], &left).is_none());
    }
}
