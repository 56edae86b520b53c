//! How much more evidence an effect must bring than a related, simpler one.

use world::effects::{Naming, effect};

use crate::Thresholds;

/// Effects that do the same as this one by construction, or nearly so.
pub(super) fn alike(name: &str) -> &'static [&'static str] {
    effect(name).map_or(&[], |spec| spec.equivalent)
}

/// Gain in log-likelihood of an effect that frees so many values, less what it would gain by chance, and less what is asked
/// of an effect that contains a simpler one.
pub(super) fn evidence_of(
    name: &'static str,
    gain: f64,
    freed: usize,
    chance: f64,
    thresholds: &Thresholds,
) -> f64 {
    let further = if simpler(name).is_empty() {
        0.0
    } else {
        thresholds.contains * gain.max(0.0)
            + thresholds.contains_value * freed.saturating_sub(1) as f64
    };
    gain - chance - further
}

/// Effects that are one's special cases.
pub(super) fn simpler(name: &str) -> &'static [&'static str] {
    effect(name).map_or(&[], |spec| spec.contains)
}

/// Whether an effect has a value at each of many places.
pub(super) fn is_field(name: &str) -> bool {
    let spec = effect(name);
    spec.is_ok_and(|spec| matches!(spec.naming, Naming::LastResort | Naming::InPlace))
}
