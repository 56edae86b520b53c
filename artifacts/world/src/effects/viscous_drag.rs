//! Drag that grows with speed: a = −c·v, as from a film of fluid or of dust under the object.

use super::{
    Acts, EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters,
    formula::forcing,
};

/// Greatest rate in 1/s: a third of the speed is lost in a frame or two. A drag that drives the object on is not looked for.
const MOST: f64 = 20.0;

/// Viscous drag; parameter `rate` = c.
pub const SPEC: EffectSpec = EffectSpec {
    name: "viscous_drag",
    parameters: Parameters::Listed(&[EffectParameter::new("rate", "1/s", [-1.0, MOST], 0.3)]),
    family: Family::FrictionBySpeed,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    naming: Naming::Ordinary,
    source: "viscous term of the Stribeck friction model (Armstrong-Hélouvry et al. 1994)",
    starts: |_| FitStart::linear_up_to(("rate", 0.05), MOST),
    build: |values, _| {
        let rate = values.get("rate");
        forcing(Acts::Slide, move |slide| slide.velocity * -rate)
    },
    statement: |values| {
        format!(
            "drag grows with speed: {:.2} m/s² for every m/s of speed",
            values.get("rate")
        )
    },
};

#[cfg(test)]
mod tests {
    use crate::effects::tests::{Bench, DRY};

    #[test]
    fn the_stop_follows_its_formula() {
        // v' = −a − c·v from v₀ to 0: d = v₀/c − a/c²·ln(1 + c·v₀/a).
        let rate = 0.8;
        let slid = Bench::with("viscous_drag", &[("rate", rate)]).slide(0.9, 0.0);
        let speed = slid.speed();
        slid.assert_distance(speed / rate - DRY / (rate * rate) * (1.0 + rate * speed / DRY).ln());
    }
}
