//! Friction that changes from strike to strike, by wear or warming: μ(n) = μ·(1 + rate·n'/100), n the strikes before.
//!
//! n' = n where it goes on, and (1 − exp(−k·n))/k where it comes to an end after some 1/k strikes.

use super::{
    Acts, Column, Effect, EffectParameter, EffectSpec, Experiment, Family, FitStart, Naming,
    Origin, Parameters, Slide, wording,
};

/// However long a falling drift goes on, this share of friction is left.
const LEAST_FACTOR: f64 = 0.05;

/// A saturation per 100 strikes that is worth a word: below, the drift has hardly bent after 500 strikes.
const STATED: f64 = 0.1;
/// How many times over a drift is taken to saturate during the strikes: starts of fits.
const SATURATIONS: [f64; 2] = [2.0, 6.0];

/// Friction drift; parameters `rate`: relative change of friction per 100 strikes, from that of the first, as it begins; and
/// `saturation` = 100·k, per 100 strikes.
pub const SPEC: EffectSpec = EffectSpec {
    name: "friction_drift",
    parameters: Parameters::Listed(&[
        EffectParameter::new("rate", "per 100 strikes", [-10.0, 20.0], 0.15),
        EffectParameter::new("saturation", "per 100 strikes", [0.0, 100.0], 1.0),
    ]),
    family: Family::FrictionByOrder,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    naming: Naming::Ordinary,
    source: "friction changes with the number of pushes (Yu et al. 2016), to first order",
    starts: |experiment| starts(experiment, 0.02),
    build: |values, _| {
        Box::new(FrictionDrift {
            per_strike: 0.01 * values.get("rate"),
            saturation: 0.01 * values.get("saturation"),
        })
    },
    statement: |values| statement("friction", values.get("rate"), values.get("saturation")),
};

/// n' of so many strikes before, `saturation` = k.
pub fn gone_on(before: f64, saturation: f64) -> f64 {
    let so_far = saturation * before;
    // (1 − exp(−x))/x, 1 where x is none.
    let bent = if so_far > 0.0 {
        -(-so_far).exp_m1() / so_far
    } else {
        1.0
    };
    before * bent
}

/// Starts of fits of a drift: one that goes on, and ones that come to an end during the strikes.
pub(super) fn starts(experiment: &Experiment<'_>, rate: f64) -> Vec<FitStart> {
    let mut starts = FitStart::linear(("rate", rate));
    let hundreds = 0.01 * experiment.span().max(1.0);
    for saturation in SATURATIONS.map(|times| times / hundreds) {
        let column = Column::new(&[("saturation", saturation)], ("rate", rate));
        starts.push(FitStart::new(vec![column], &["rate", "saturation"]));
    }
    starts
}

/// A drift in words, from its first value.
pub(super) fn statement(of: &str, rate: f64, saturation: f64) -> String {
    let goes = if rate < 0.0 { "falls" } else { "rises" };
    match saturation >= STATED {
        true => format!(
            "{of} {goes} by {} in all, two thirds of that within {:.0} strikes",
            wording::percent(rate / saturation),
            100.0 / saturation
        ),
        false => format!(
            "{of} {goes} by {} of its first value every 100 strikes",
            wording::percent(rate)
        ),
    }
}

struct FrictionDrift {
    per_strike: f64,
    saturation: f64,
}

impl Effect for FrictionDrift {
    fn acts(&self) -> Acts {
        Acts::Strike
    }

    fn friction_factor(&self, slide: &Slide<'_>) -> f64 {
        let gone_on = gone_on(slide.conditions.order, self.saturation);
        (1.0 + self.per_strike * gone_on).max(LEAST_FACTOR)
    }
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::{Bench, DRY};

    #[test]
    fn the_stop_follows_its_formula() {
        for (order, factor) in [(0.0, 1.0), (50.0, 1.2), (200.0, 1.8)] {
            let slid = Bench::with("friction_drift", &[("rate", 0.4)])
                .during("", order)
                .slide(0.9, 0.0);
            slid.assert_distance(slid.speed().powi(2) / (2.0 * DRY * factor));
        }
    }
    #[test]
    fn a_drift_that_saturates_stops_by_its_formula() {
        let drift = [("rate", 0.4), ("saturation", 2.0)];
        for order in [30.0f64, 400.0] {
            let factor = 1.0 + 0.2 * (1.0 - (-0.02 * order).exp());
            let slid = Bench::with("friction_drift", &drift)
                .during("", order)
                .slide(0.9, 0.0);
            slid.assert_distance(slid.speed().powi(2) / (2.0 * DRY * factor));
        }
    }
}
