//! Restitution that falls with impact speed: e(v) = e·(1 − s·(v − v₀)), e being that at v₀.

use super::{
    EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters, formula::restoring,
    wording,
};

/// Impact speed in m/s at which restitution is the world's own: the middle of an arm's striking speeds, so that slope and
/// restitution are fitted apart.
const REFERENCE: f64 = 0.7;
/// Factors beyond which the straight line no longer describes a contact: none restores less than nothing.
const FACTORS: [f64; 2] = [0.0, 2.0];

/// Speed-dependent restitution; parameter `slope` = s: relative fall for every m/s.
pub const SPEC: EffectSpec = EffectSpec {
    name: "speed_dependent_restitution",
    // At 3, none is left at 1.03 m/s, and twice its own at 0.37: the ends of an arm's striking speeds.
    parameters: Parameters::Listed(&[EffectParameter::new("slope", "s/m", [-1.5, 3.0], 0.2)]),
    family: Family::RestitutionBySpeed,
    origin: Origin::Contact,
    equivalent: &["striker_speed_error"],
    contains: &[],
    naming: Naming::Ordinary,
    source: "e = 1 − α·v at low speeds (Hunt and Crossley 1975), about a reference speed",
    starts: |_| FitStart::linear(("slope", 0.05)),
    build: |values, _| {
        let slope = values.get("slope");
        let [least, greatest] = FACTORS;
        restoring(move |impact_speed, _| {
            (1.0 - slope * (impact_speed - REFERENCE)).clamp(least, greatest)
        })
    },
    statement: |values| {
        let slope = values.get("slope");
        format!(
            "restitution {} with impact speed: by {} of its value at {REFERENCE} m/s for every m/s",
            if slope < 0.0 { "rises" } else { "falls" },
            wording::percent(slope)
        )
    },
};

#[cfg(test)]
mod tests {
    use crate::effects::tests::{Bench, assert_near};

    #[test]
    fn it_strikes_as_with_the_restitution_of_its_formula() {
        let restitution = 0.5;
        for (speed, factor) in [(0.4, 1.15), (0.7, 1.0), (1.0, 0.85)] {
            let effect = Bench::with("speed_dependent_restitution", &[("slope", 0.5)])
                .parameter("restitution", restitution);
            let constant = Bench::plain().parameter("restitution", restitution * factor);
            assert_near(
                effect.strike(speed, 0.2).stop,
                constant.strike(speed, 0.2).stop,
                1e-6,
            );
        }
    }
}
