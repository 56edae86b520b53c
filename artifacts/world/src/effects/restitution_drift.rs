//! Restitution that changes from strike to strike, by a tip that wears: e(n) = e·(1 + rate·n'/100), n' of the strikes before as of
//! [`friction_drift`].

use super::{
    EffectParameter, EffectSpec, Family, Naming, Origin, Parameters,
    formula::restoring,
    friction_drift::{self, Drift},
};

/// Factors beyond which a line no longer describes a contact: none restores less than nothing.
const FACTORS: [f64; 2] = [0.0, 2.0];

/// Restitution drift; parameters as those of [`friction_drift`].
pub const SPEC: EffectSpec = EffectSpec {
    name: "restitution_drift",
    parameters: Parameters::Listed(&[
        EffectParameter::new("rate", "per 100 strikes", [-10.0, 20.0], 0.15),
        EffectParameter::new("saturation", "per 100 strikes", [0.0, 100.0], 1.0),
        friction_drift::SHAPE,
    ]),
    family: Family::RestitutionByOrder,
    origin: Origin::Contact,
    equivalent: &[],
    contains: &[],
    naming: Naming::Ordinary,
    source: "wear of a contact with the number of impacts, to first order",
    starts: |experiment| friction_drift::starts(experiment, 0.05, true),
    build: |values, _| {
        let drift = Drift::of(values);
        let [least, greatest] = FACTORS;
        restoring(move |_, conditions| drift.factor(conditions.order).clamp(least, greatest))
    },
    statement: |values| {
        let drifts = Drift::of(values).statement("restitution");
        format!(
            "{drifts}; an arm whose speed changes, or an object of another mass, shows the same"
        )
    },
};

#[cfg(test)]
mod tests {
    use crate::effects::tests::{Bench, assert_near};

    #[test]
    fn it_strikes_as_in_a_world_with_the_restitution_of_its_formula() {
        let saturated = |order: f64| 0.5 * (1.0 - 0.4 * (1.0 - (-0.02 * order).exp()));
        for (rate, saturation, order, restitution) in [
            (-0.4, 0.0, 0.0, 0.5),
            (-0.4, 0.0, 50.0, 0.4),
            (-0.4, 0.0, 100.0, 0.3),
            (-0.8, 2.0, 10.0, saturated(10.0)),
            (-0.8, 2.0, 300.0, saturated(300.0)),
        ] {
            let drift = [("rate", rate), ("saturation", saturation)];
            let stop = Bench::with("restitution_drift", &drift)
                .parameter("restitution", 0.5)
                .during("", order)
                .strike(0.9, 0.1)
                .stop;
            let plain = Bench::plain().parameter("restitution", restitution);
            assert_near(stop, plain.strike(0.9, 0.1).stop, 1e-6);
        }
    }
}
