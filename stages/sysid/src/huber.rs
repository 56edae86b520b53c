//! Less weight for strikes that lie far out (Huber 1964).

use crate::scatter::Evidence;

/// Distance, in medians over the strikes, beyond which a strike weighs less.
const OUTLYING: f64 = 4.0;

/// Weights by strike: one, less for strikes far beyond the median.
pub(crate) fn weights(evidence: &[Evidence<'_>]) -> Vec<f64> {
    let distances: Vec<f64> = evidence
        .iter()
        .map(|e| (e.distance() / e.residual.len() as f64).sqrt())
        .collect();
    let mut sorted = distances.clone();
    sorted.sort_by(f64::total_cmp);
    let limit = OUTLYING * sorted[sorted.len() / 2];
    distances
        .iter()
        .map(|d| if *d > limit { limit / d } else { 1.0 })
        .collect()
}

/// The objective that each step of the fit must decrease: the weighted sum of squared distances.
pub(crate) fn objective(evidence: &[Evidence<'_>], weights: &[f64]) -> f64 {
    evidence
        .iter()
        .zip(weights)
        .map(|(e, w)| w * e.distance())
        .sum()
}
