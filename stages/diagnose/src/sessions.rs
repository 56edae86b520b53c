//! Sessions as they are reported: relative changes from their mean, each with its interval.
//!
//! A fit fixes one session and frees the others. The report treats all alike: c = (1 + r)/(1 + r̄) − 1, its
//! error by the first derivatives of that.

use std::collections::BTreeMap;

use nalgebra::DMatrix;
use world::{
    Estimate,
    effects::{Parameters, centred, effect},
};

/// Whether an effect has a value for each session.
pub(crate) fn is_by_session(name: &str) -> bool {
    effect(name).is_ok_and(|spec| matches!(spec.parameters, Parameters::BySession { .. }))
}

/// The parameters of an effect as they are reported; `free` are those that were fitted, by name, with their `covariance`, and 95 % lie
/// within so many standard errors.
pub(crate) fn centred_estimates(
    name: &str,
    parameters: BTreeMap<String, Estimate>,
    free: &[&str],
    covariance: &DMatrix<f64>,
    ninety_five: f64,
) -> BTreeMap<String, Estimate> {
    let range = effect(name).ok().and_then(|spec| match &spec.parameters {
        Parameters::BySession {
            is_relative: true,
            parameter,
        } => Some((parameter.low, parameter.high)),
        _ => None,
    });
    let Some((low, high)) = range else {
        return parameters;
    };
    let changes: BTreeMap<String, f64> = parameters
        .iter()
        .map(|(name, estimate)| (name.clone(), estimate.value))
        .collect();
    let count = changes.len() as f64;
    let mean = 1.0 + changes.values().sum::<f64>() / count;
    centred(&changes)
        .into_iter()
        .map(|(session, value)| {
            let slope = |other: &str| {
                let own = if other == session { 1.0 / mean } else { 0.0 };
                own - (1.0 + changes[&session]) / (count * mean * mean)
            };
            let mut variance = 0.0;
            for (i, a) in free.iter().enumerate() {
                for (j, b) in free.iter().enumerate() {
                    variance += slope(a) * slope(b) * covariance[(i, j)];
                }
            }
            let by = ninety_five * variance.max(0.0).sqrt();
            // From their mean, sessions that differ widely may lie further than the first one did from them.
            let bound = |v: f64| v.clamp(low, high);
            let estimate =
                Estimate::with_interval(bound(value), bound(value - by), bound(value + by));
            (session, estimate)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::NINETY_FIVE;

    #[test]
    fn no_session_is_the_reference_of_the_others() {
        let parameters: BTreeMap<String, Estimate> = [("a", 0.0), ("b", 0.2), ("c", 0.1)]
            .map(|(name, value)| (name.to_string(), Estimate::fixed(value)))
            .into();
        // Three sessions measured alike, each compared with the first: the differences share its error.
        let covariance = DMatrix::from_row_slice(2, 2, &[2e-4, 1e-4, 1e-4, 2e-4]);
        let centred_estimates = centred_estimates(
            "friction_by_session",
            parameters,
            &["b", "c"],
            &covariance,
            NINETY_FIVE,
        );
        let half = |name: &str| {
            let estimate = centred_estimates[name];
            0.5 * (estimate.high.expect("an end") - estimate.low.expect("an end"))
        };
        assert!(
            centred_estimates
                .values()
                .map(|e| e.value)
                .sum::<f64>()
                .abs()
                < 1e-12
        );
        // As if each had been measured to 1 %, and their mean taken off.
        let alone = NINETY_FIVE * 0.01 * (2.0f64 / 3.0).sqrt() / 1.1;
        for name in ["a", "b", "c"] {
            assert!(
                (half(name) / alone - 1.0).abs() < 0.12,
                "{name}: {}",
                half(name)
            );
        }
    }

    #[test]
    fn other_effects_are_reported_as_they_were_fitted() {
        let parameters: BTreeMap<String, Estimate> =
            [("rate".to_string(), Estimate::with_interval(0.3, 0.2, 0.4))].into();
        let covariance = DMatrix::identity(1, 1);
        let kept = centred_estimates(
            "viscous_drag",
            parameters.clone(),
            &["rate"],
            &covariance,
            NINETY_FIVE,
        );
        assert_eq!(kept, parameters);
    }
}
