//! Friction that changes from strike to strike, by wear or warming: μ(n) = μ·(1 + rate·n'/100), n the strikes before.
//!
//! n' = n where it goes on, and (1 − exp(−(k·n)^p))/k where it comes to an end after some 1/k strikes: from the first one on where
//! p = 1, and from one level to another within some 3/(k·p) strikes where p is large.

use super::{
    Acts, Column, EffectParameter, EffectSpec, Experiment, Family, FitStart, Naming, Origin,
    Parameters, Values, formula::braking, wording,
};

/// Least factor on friction: however long a falling drift goes on, this share of friction is left.
const LEAST_FACTOR: f64 = 0.05;

/// A saturation per 100 strikes that is worth a word: below, the drift has hardly bent after 500 strikes.
const STATED: f64 = 0.1;
/// A shape from which on a drift is told as a change from one level to another.
const STATED_AS_LEVELS: f64 = 2.0;
/// How many times over a drift is taken to saturate during the strikes: starts of fits.
const SATURATIONS: [f64; 2] = [2.0, 6.0];
/// Where among the strikes half of a change from one level to another lies, as a share of them: starts of fits, so near to each other that
/// chance is asked of them wherever the change may lie.
const MIDDLES: [f64; 9] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];
/// Shape p at which such fits begin: a change within a sixth of the strikes before it.
const LEVELS: f64 = 12.0;

/// Friction drift; parameters `rate`: relative change of friction per 100 strikes, as it begins where `shape` is 1; `saturation` = 100·k,
/// per 100 strikes; and `shape` = p. Where it comes to an end it changes by rate/saturation in all.
pub const SPEC: EffectSpec = EffectSpec {
    name: "friction_drift",
    parameters: Parameters::Listed(&[
        EffectParameter::new("rate", "per 100 strikes", [-10.0, 20.0], 0.15),
        EffectParameter::new("saturation", "per 100 strikes", [0.0, 100.0], 1.0),
        SHAPE,
    ]),
    family: Family::FrictionByOrder,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    naming: Naming::Ordinary,
    source: "friction changes with the number of pushes (Yu et al. 2016), to first order",
    // Between sessions a change of level has a name of its own.
    starts: |experiment| starts(experiment, 0.02, experiment.sessions().len() < 2),
    build: |values, _| {
        let drift = Drift::of(values);
        braking(Acts::Strike, move |slide| {
            drift.factor(slide.conditions.order).max(LEAST_FACTOR)
        })
    },
    statement: |values| Drift::of(values).statement("friction"),
};

pub(super) const SHAPE: EffectParameter =
    EffectParameter::new("shape", "", [1.0, 100.0], 4.0).neutral_at(1.0);

/// A change with the number of strikes before.
#[derive(Clone, Copy, Debug)]
pub struct Drift {
    /// Relative change per strike.
    pub rate: f64,
    /// k, per strike.
    pub saturation: f64,
    /// p.
    pub shape: f64,
}

impl Drift {
    /// The drift of an effect's parameters.
    pub(super) fn of(values: &Values) -> Self {
        Self {
            rate: 0.01 * values.get("rate"),
            saturation: 0.01 * values.get("saturation"),
            shape: values.get("shape"),
        }
    }

    /// n' after n strikes (`before`).
    pub fn gone_on(&self, before: f64) -> f64 {
        if self.saturation > 0.0 {
            -(-(self.saturation * before).powf(self.shape)).exp_m1() / self.saturation
        } else {
            before
        }
    }

    /// Factor on what drifts, after `before` strikes.
    pub(super) fn factor(&self, before: f64) -> f64 {
        1.0 + self.rate * self.gone_on(before)
    }

    /// The drift in words, from the first value of what drifts.
    pub(super) fn statement(&self, of: &str) -> String {
        let goes = if self.rate < 0.0 { "falls" } else { "rises" };
        let is_level = self.saturation > 0.0 && self.shape >= STATED_AS_LEVELS;
        if !is_level && 100.0 * self.saturation < STATED {
            let rate = wording::percent(100.0 * self.rate);
            return format!("{of} {goes} by {rate} of its first value every 100 strikes");
        }
        // What would be in the end is not said of a change that would be as great as all.
        if !is_level && self.rate.abs() >= self.saturation {
            let by = wording::percent(self.rate * self.gone_on(100.0));
            return format!(
                "{of} {goes} by {by} within the first 100 strikes, and ever more slowly"
            );
        }
        let by = wording::percent(self.rate / self.saturation);
        let by_then = |share: f64| (-(1.0 - share).ln()).powf(1.0 / self.shape) / self.saturation;
        if !is_level {
            let most = by_then(2.0 / 3.0);
            return format!(
                "{of} {goes} by {by} in all, two thirds of that within {most:.0} strikes"
            );
        }
        let [first, last] = [0.1, 0.9].map(by_then);
        match last - first < 2.0 {
            true => format!("{of} {goes} by {by} at strike {last:.0}"),
            false => format!("{of} {goes} by {by} between strikes {first:.0} and {last:.0}"),
        }
    }
}

/// Starts of fits of a drift: one that goes on, ones that come to an end during the strikes, and, where asked, ones that lead from one level
/// to another.
pub(super) fn starts(experiment: &Experiment<'_>, rate: f64, has_levels: bool) -> Vec<FitStart> {
    let mut starts = FitStart::linear(("rate", rate));
    let hundreds = 0.01 * experiment.span().max(1.0);
    for saturation in SATURATIONS.map(|times| times / hundreds) {
        let column = Column::new(&[("saturation", saturation)], ("rate", rate));
        starts.push(FitStart::new(vec![column], &["rate", "saturation"]));
    }
    for middle in MIDDLES.into_iter().filter(|_| has_levels) {
        let saturation = std::f64::consts::LN_2.powf(1.0 / LEVELS) / (middle * hundreds);
        let form = [("saturation", saturation), ("shape", LEVELS)];
        let column = Column::new(&form, ("rate", rate * saturation));
        starts.push(FitStart::new(
            vec![column],
            &["rate", "saturation", "shape"],
        ));
    }
    starts
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
    fn a_drift_from_one_level_to_another_stops_by_its_formula() {
        let drift = [("rate", 0.4), ("saturation", 2.0), ("shape", 6.0)];
        for (order, changed) in [
            (10.0, 1.0 - (-0.2f64.powi(6)).exp()),
            (50.0, 1.0 - (-1.0f64).exp()),
            (80.0, 1.0),
        ] {
            let slid = Bench::with("friction_drift", &drift)
                .during("", order)
                .slide(0.9, 0.0);
            slid.assert_distance(slid.speed().powi(2) / (2.0 * DRY * (1.0 + 0.2 * changed)));
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
