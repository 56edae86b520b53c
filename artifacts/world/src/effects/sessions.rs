//! Sessions as draws from a population: what differs from log to log has a mean and a scatter.
//!
//! A session that was never seen has the population's mean. No session is the reference of the others.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::parameters::Values;
use crate::Estimate;

/// The name under which a world may hold the value of sessions that it does not know, in place of the population's mean: no
/// log has it.
pub const UNKNOWN: &str = "";

/// Standard errors within which 95 % lie.
const NINETY_FIVE: f64 = 1.96;

/// A quantity that differs from session to session.
pub(super) struct BySession {
    known: BTreeMap<String, f64>,
    unknown: f64,
}

impl BySession {
    /// Values as given; a session that is not known has the mean.
    pub(super) fn new(values: &Values) -> Self {
        let (unknown, known) = split(values);
        let mean = mean(known.values().copied());
        Self {
            unknown: unknown.unwrap_or(mean),
            known,
        }
    }

    /// Values as relative changes from the mean over the sessions.
    pub(super) fn relative(values: &Values) -> Self {
        let (unknown, known) = split(values);
        Self {
            unknown: unknown.unwrap_or(0.0),
            known: centred(&known),
        }
    }

    pub(super) fn value(&self, session: &str) -> f64 {
        self.known.get(session).copied().unwrap_or(self.unknown)
    }

    /// Every session that is known, and its value.
    pub(super) fn known(&self) -> impl Iterator<Item = (&str, f64)> {
        self.known
            .iter()
            .map(|(name, value)| (name.as_str(), *value))
    }
}

fn split(values: &Values) -> (Option<f64>, BTreeMap<String, f64>) {
    let mut known: BTreeMap<String, f64> = values
        .iter()
        .map(|(name, value)| (name.to_string(), value))
        .collect();
    (known.remove(UNKNOWN), known)
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
    sum / f64::max(count, 1.0)
}

/// Relative changes taken from their mean: (1 + r)/(1 + mean) − 1.
pub fn centred(changes: &BTreeMap<String, f64>) -> BTreeMap<String, f64> {
    let about = 1.0 + mean(changes.values().copied());
    changes
        .iter()
        .map(|(name, change)| (name.clone(), (1.0 + change) / about - 1.0))
        .collect()
}

/// Sessions as draws: what is known of one that was never seen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Population {
    /// Mean over the sessions, in the parameter's unit.
    pub mean: f64,
    /// Standard deviation between sessions, the error of each one's estimate taken off.
    pub scatter: f64,
    /// Number of sessions that both were estimated from.
    pub sessions: u32,
}

impl Population {
    /// The population that these estimates are drawn from, by session; each one's error is taken from its interval.
    pub fn of(estimates: &BTreeMap<String, Estimate>) -> Self {
        let known = || estimates.iter().filter(|(name, _)| *name != UNKNOWN);
        let count = known().count() as f64;
        let mean = mean(known().map(|(_, e)| e.value));
        let between: f64 = known().map(|(_, e)| (e.value - mean).powi(2)).sum();
        let error = |e: &Estimate| match (e.low, e.high) {
            (Some(low), Some(high)) => ((high - low) / (2.0 * NINETY_FIVE)).powi(2),
            _ => 0.0,
        };
        let errors: f64 = known().map(|(_, e)| error(e)).sum();
        let variance = between / (count - 1.0).max(1.0) - errors / count.max(1.0);
        Self {
            mean,
            scatter: variance.max(0.0).sqrt(),
            sessions: count as u32,
        }
    }

    /// Standard deviation of the next session's value about the mean: the scatter, and what few sessions leave open of the
    /// mean itself.
    pub fn next(&self) -> f64 {
        self.scatter * (1.0 + 1.0 / f64::from(self.sessions.max(1))).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scatter_between_sessions_is_separated_from_the_error_of_each() {
        let estimates = |error: f64| -> BTreeMap<String, Estimate> {
            [("a", 0.1), ("b", -0.1), ("c", 0.0)]
                .map(|(name, v)| {
                    let by = NINETY_FIVE * error;
                    (name.to_string(), Estimate::with_interval(v, v - by, v + by))
                })
                .into()
        };
        let sure = Population::of(&estimates(0.0));
        assert!(sure.mean.abs() < 1e-12 && (sure.scatter - 0.1).abs() < 1e-12);
        assert!((sure.next() - 0.1 * (4.0f64 / 3.0).sqrt()).abs() < 1e-12);
        let unsure = Population::of(&estimates(0.06));
        assert!((unsure.scatter - 0.08).abs() < 1e-12, "{unsure:?}");
        assert_eq!(Population::of(&estimates(0.2)).scatter, 0.0);
    }

    #[test]
    fn centred_changes_have_no_mean_and_keep_their_ratios() {
        let changes = [("a".to_string(), 0.0), ("b".to_string(), 0.2)].into();
        let centred = centred(&changes);
        assert!((centred["a"] + centred["b"]).abs() < 1e-12);
        assert!(((1.0 + centred["b"]) / (1.0 + centred["a"]) - 1.2).abs() < 1e-12);
    }
}
