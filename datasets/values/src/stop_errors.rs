//! Stop errors, summed up.

use serde::{Deserialize, Serialize};

/// Stop errors of a model over many strikes, in m.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StopErrors {
    /// Mean.
    pub mean: f64,
    /// Standard deviation (of a sample: n − 1); zero for a single strike.
    pub sd: f64,
    /// Median.
    pub median: f64,
    /// 95th percentile, linear between strikes.
    pub p95: f64,
    /// Number of strikes.
    pub n: usize,
    /// Strikes without a stop to compare; they are in none of the numbers above.
    #[serde(default)]
    pub failed: usize,
}

impl StopErrors {
    /// The statistics of these errors (m); none where there is no error.
    pub fn of(errors: impl Iterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = errors.collect();
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len();
        let last = n.checked_sub(1)?;
        let mean = sorted.iter().sum::<f64>() / n as f64;
        let squares: f64 = sorted.iter().map(|error| (error - mean).powi(2)).sum();
        let quantile = |share: f64| {
            let place = share * last as f64;
            let below = place.floor() as usize;
            let above = (below + 1).min(last);
            sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
        };
        Some(Self {
            mean,
            sd: (squares / last.max(1) as f64).sqrt(),
            median: quantile(0.5),
            p95: quantile(0.95),
            n,
            failed: 0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_summed_up() {
        let all = StopErrors::of([3.0, 1.0, 2.0, 4.0].into_iter()).expect("four");
        assert_eq!((all.mean, all.median, all.n), (2.5, 2.5, 4));
        assert!((all.sd - (5.0f64 / 3.0).sqrt()).abs() < 1e-12);
        assert!((all.p95 - 3.85).abs() < 1e-12);
        assert_eq!(StopErrors::of(std::iter::empty()), None);
        assert_eq!(StopErrors::of([7.0].into_iter()).map(|s| s.sd), Some(0.0));
    }
}
