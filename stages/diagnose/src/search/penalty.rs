//! What related effects must bring beyond each other.

/// Effects that do the same by construction, or nearly so.
pub(super) fn alike(name: &str) -> &'static [&'static str] {
    world::effects::effect(name).map_or(&[], |spec| spec.equivalent)
}

/// Share of what an effect gains that one which contains a simpler effect must bring beyond it: what is left by a form that is not
/// quite the simpler one's is no reason for the other.
const CONTAINS_SHARE: f64 = 0.02;
/// Evidence that each further value of such an effect must bring.
const CONTAINS_VALUE: f64 = 2.0;

/// Gain in log-likelihood of an effect that frees so many values, less what it would gain by chance, and less what is asked
/// of an effect that contains a simpler one.
pub(super) fn evidence_of(name: &'static str, gain: f64, freed: usize, chance: f64) -> f64 {
    let further = if simpler(name).is_empty() {
        0.0
    } else {
        CONTAINS_SHARE * gain.max(0.0) + CONTAINS_VALUE * freed.saturating_sub(1) as f64
    };
    gain - chance - further
}

/// Effects that are one's special cases.
pub(super) fn simpler(name: &str) -> &'static [&'static str] {
    world::effects::effect(name).map_or(&[], |spec| spec.contains)
}
