//! Restitution that changes from strike to strike, by a tip that wears: e(n) = e·(1 + rate·n/100), n the strikes before.

use values::Conditions;

use super::{
    Acts, Effect, EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters,
    wording,
};

/// Factors beyond which a line no longer describes a contact: none restores less than nothing.
const FACTORS: [f64; 2] = [0.0, 2.0];

/// Restitution drift; parameter `rate`: relative change of restitution per 100 strikes, from that of the first.
pub const SPEC: EffectSpec = EffectSpec {
    name: "restitution_drift",
    parameters: Parameters::Listed(&[EffectParameter::new(
        "rate",
        "per 100 strikes",
        [-0.9, 3.0],
        0.15,
    )]),
    family: Family::RestitutionByOrder,
    origin: Origin::Contact,
    equivalent: &[],
    contains: &[],
    naming: Naming::Ordinary,
    source: "wear of a contact with the number of impacts, to first order",
    starts: |_| FitStart::linear(("rate", 0.05)),
    build: |values, _| {
        Box::new(RestitutionDrift {
            per_strike: 0.01 * values.get("rate"),
        })
    },
    statement: |values| {
        let rate = values.get("rate");
        format!(
            "restitution {} by {} of its first value every 100 strikes",
            if rate < 0.0 { "falls" } else { "rises" },
            wording::percent(rate)
        )
    },
};

struct RestitutionDrift {
    per_strike: f64,
}

impl Effect for RestitutionDrift {
    fn acts(&self) -> Acts {
        Acts::Launch
    }

    fn restitution_factor(&self, _: f64, conditions: &Conditions) -> f64 {
        let [least, greatest] = FACTORS;
        (1.0 + self.per_strike * conditions.order).clamp(least, greatest)
    }
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::{Bench, assert_near};

    #[test]
    fn it_strikes_as_in_a_world_with_the_restitution_of_its_formula() {
        for (order, restitution) in [(0.0, 0.5), (50.0, 0.4), (100.0, 0.3)] {
            let stop = Bench::with("restitution_drift", &[("rate", -0.4)])
                .parameter("restitution", 0.5)
                .during("", order)
                .strike(0.9, 0.1)
                .stop;
            let plain = Bench::plain().parameter("restitution", restitution);
            assert_near(stop, plain.strike(0.9, 0.1).stop, 1e-6);
        }
    }
}
