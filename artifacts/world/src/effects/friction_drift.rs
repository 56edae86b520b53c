//! Friction that changes from strike to strike, by wear or warming: μ(n) = μ·(1 + rate·n/100), n the strikes before.

use values::Rig;

use super::{
    action::{Acts, Effect, Slide},
    spec::{EffectParameter, EffectSpec, Family, Parameters, Values},
    start::FitStart,
    wording,
};

/// However long a falling drift goes on, this share of friction is left.
const LEAST_FACTOR: f64 = 0.05;

/// Friction drift; parameter `rate`: relative change of friction per 100 strikes, from that of the first.
pub const SPEC: EffectSpec = EffectSpec {
    name: "friction_drift",
    parameters: Parameters::Listed(&[EffectParameter {
        name: "rate",
        unit: "per 100 strikes",
        low: -0.9,
        high: 3.0,
        neutral: 0.0,
        scale: 0.15,
    }]),
    family: Family::FrictionByOrder,
    equivalent: &[],
    contains: &[],
    is_last_resort: false,
    source: "friction changes with the number of pushes (Yu et al. 2016), to first order",
    starts: |_| FitStart::linear(("rate", 0.02)),
    build: |values: &Values, _: &Rig| {
        Box::new(FrictionDrift {
            per_strike: 0.01 * values.get("rate"),
        })
    },
    statement: |values| {
        let rate = values.get("rate");
        format!(
            "friction {} by {} of its first value every 100 strikes",
            if rate < 0.0 { "falls" } else { "rises" },
            wording::percent(rate)
        )
    },
};

struct FrictionDrift {
    per_strike: f64,
}

impl Effect for FrictionDrift {
    fn acts(&self) -> Acts {
        Acts::Strike
    }

    fn friction_factor(&self, slide: &Slide<'_>) -> f64 {
        (1.0 + self.per_strike * slide.conditions.order).max(LEAST_FACTOR)
    }
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::{Bench, DRY};

    #[test]
    fn it_changes_the_track() {
        Bench::with("friction_drift", &[("rate", 0.15)])
            .during("", 60.0)
            .assert_changes_track();
    }

    #[test]
    fn the_stop_follows_its_formula() {
        for (order, factor) in [(0.0, 1.0), (50.0, 1.2), (200.0, 1.8)] {
            let slid = Bench::with("friction_drift", &[("rate", 0.4)])
                .during("", order)
                .slide(0.9, 0.0);
            slid.assert_distance(slid.speed().powi(2) / (2.0 * DRY * factor));
        }
    }
}
