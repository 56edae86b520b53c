//! Drag that grows with the square of the speed: a = −k·|v|·v, as from air or from a deep film.

use super::{
    Acts, EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters,
    formula::forcing,
};

/// Greatest drag in m/s² at 1 m/s: a third of the speed is lost in 2 cm, which leaves no slide to be seen. A drag that drives the object on is
/// not looked for.
const MOST: f64 = 20.0;

/// Quadratic drag; parameter `coefficient` = k.
pub const SPEC: EffectSpec = EffectSpec {
    name: "quadratic_drag",
    parameters: Parameters::Listed(&[EffectParameter::new(
        "coefficient",
        "1/m",
        [-0.5, MOST],
        0.2,
    )]),
    family: Family::FrictionBySpeed,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    naming: Naming::Ordinary,
    source: "the drag equation: k = ρ·c_d·A/(2·m)",
    starts: |_| FitStart::linear_up_to(("coefficient", 0.05), MOST),
    build: |values, _| {
        let coefficient = values.get("coefficient");
        forcing(Acts::Slide, move |slide| {
            slide.velocity * (-coefficient * slide.velocity.norm())
        })
    },
    statement: |values| {
        format!(
            "drag grows with the square of the speed: {:.2} m/s² at 1 m/s",
            values.get("coefficient")
        )
    },
};

#[cfg(test)]
mod tests {
    use crate::effects::tests::{Bench, DRY};

    #[test]
    fn the_stop_follows_its_formula() {
        // v·dv/dx = −a − k·v² from v₀ to 0: d = ln(1 + k·v₀²/a)/(2·k).
        let k = 0.8;
        let slid = Bench::with("quadratic_drag", &[("coefficient", k)]).slide(0.9, 0.0);
        slid.assert_distance((1.0 + k * slid.speed().powi(2) / DRY).ln() / (2.0 * k));
    }
}
