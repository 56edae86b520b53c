//! Friction that is higher near rest: μ(v) = μ·(1 + Δ·exp(−(v/v_s)²)), μ being that at high speed.

use super::{
    Acts, Column, EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters,
    formula::braking, wording,
};

/// Greatest rise. Friction that falls towards rest is not looked for: that is drag.
const MOST: f64 = 3.0;
/// Speeds in m/s at which friction may begin to rise: a fit starts at each.
const SPEEDS: [f64; 5] = [0.1, 0.2, 0.35, 0.6, 1.0];

/// Speed-weakening friction; parameters `rise` = Δ, relative to the friction at high speed, and `speed` = v_s.
pub const SPEC: EffectSpec = EffectSpec {
    name: "speed_weakening_friction",
    parameters: Parameters::Listed(&[
        EffectParameter::new("rise", "", [-0.9, MOST], 0.25),
        EffectParameter::new("speed", "m/s", [0.05, 2.0], 0.2).neutral_at(0.3),
    ]),
    family: Family::FrictionBySpeed,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    naming: Naming::Ordinary,
    source: "Stribeck term of friction in its Gaussian form (Armstrong-Hélouvry et al. 1994)",
    starts: |_| {
        SPEEDS
            .iter()
            .map(|speed| {
                let column = Column::new(&[("speed", *speed)], ("rise", 0.05));
                FitStart::new(vec![column], &["rise", "speed"]).kept_in("rise", (0.0, MOST))
            })
            .collect()
    },
    build: |values, _| {
        let (rise, per_speed_squared) = (values.get("rise"), values.get("speed").powi(-2));
        braking(Acts::Slide, move |slide| {
            let square = slide.velocity.dot(slide.velocity);
            1.0 + rise * (-square * per_speed_squared).exp()
        })
    },
    statement: |values| {
        format!(
            "friction is {} near rest than at speed; half of that is gone at {:.2} m/s",
            wording::higher(values.get("rise")),
            values.get("speed") * std::f64::consts::LN_2.sqrt()
        )
    },
};

#[cfg(test)]
mod tests {
    use crate::effects::tests::{Bench, DRY};

    #[test]
    fn the_stop_follows_its_formula() {
        // v·dv/dx = −a·(1 + Δ·exp(−v²/S)), S = v_s²: d = S/(2·a)·ln((exp(v₀²/S) + Δ)/(1 + Δ)).
        let (rise, speed): (f64, f64) = (0.5, 0.6);
        let slid = Bench::with(
            "speed_weakening_friction",
            &[("rise", rise), ("speed", speed)],
        )
        .slide(0.9, 0.0);
        let square = speed * speed;
        let ratio = ((slid.speed().powi(2) / square).exp() + rise) / (1.0 + rise);
        slid.assert_distance(square / (2.0 * DRY) * ratio.ln());
    }
}
