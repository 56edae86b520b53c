//! Friction that differs along and across a grain: an elliptic limit curve, with its associated flow rule or less of it.
//!
//! With μ_a = μ·(1 − k/2) along and μ_c = μ·(1 + k/2) across the grain, a slide with velocity (v_a, v_c) is decelerated by
//! g·(μ_a²·v_a, μ_c²·v_c)/√(μ_a²·v_a² + μ_c²·v_c²). Against the velocity that is μ·g times a factor; the rest acts across
//! it and turns the slide towards the grain. That is friction of greatest power; friction that merely opposes the motion, as
//! strongly as its direction says, has no such part (Zmitrowicz 1989: sliding rules that are not associated). So a share of
//! the part across acts.

use std::f64::consts::FRAC_PI_4;

use values::{Point, Shape};

use super::{
    Acts, Column, Effect, EffectParameter, EffectSpec, Family, FitStart, Naming, Origin,
    Parameters, Slide, wording,
};

/// Anisotropic friction; parameters `contrast` = k, friction across less friction along over their mean, `direction`: that of the
/// grain from +x, and `flow`: the share of the associated flow rule's force across the motion, 1 to 0. A negative contrast is a grain
/// at a right angle, so that a fit can pass through zero.
pub const SPEC: EffectSpec = EffectSpec {
    name: "anisotropic_friction",
    parameters: Parameters::Listed(&[
        EffectParameter::new("contrast", "", [-1.5, 1.5], 0.1),
        EffectParameter::new(
            "direction",
            "rad",
            [-std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2],
            0.5,
        ),
        EffectParameter::new("flow", "", [0.0, 1.0], 0.25).neutral_at(1.0),
    ]),
    family: Family::FrictionByHeading,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    naming: Naming::Ordinary,
    source: "limit surface of sliding friction (Goyal, Ruina and Papadopoulos 1991); seen by Ma and Rodriguez 2018; without an associated flow rule Zmitrowicz 1989",
    starts: |_| {
        let grain = |flow, free: &[&str]| {
            let column = |direction| {
                let form = [("direction", direction), ("flow", flow)];
                Column::new(&form, ("contrast", 0.03))
            };
            let columns = vec![column(0.0), column(FRAC_PI_4)];
            FitStart::new(columns, free).combined_by(one_grain)
        };
        vec![
            grain(1.0, &["contrast", "direction"]),
            grain(0.0, &["contrast", "direction", "flow"]),
        ]
    },
    build: |values, rig| {
        let contrast = values.get("contrast");
        Box::new(AnisotropicFriction {
            grain: Point::polar(1.0, values.get("direction")),
            along: (1.0 - 0.5 * contrast).powi(2),
            across: (1.0 + 0.5 * contrast).powi(2),
            // The friction of a ball that rolls is not at its limit, and does not steer it.
            turning: match rig.object.shape() {
                Shape::Sphere => 0.0,
                Shape::Cylinder | Shape::Box => 2.0 * contrast * values.get("flow"),
            },
        })
    },
    statement: |values| {
        let contrast = values.get("contrast");
        let mut degrees = values.get("direction").to_degrees();
        if contrast < 0.0 {
            degrees += if degrees > 0.0 { -90.0 } else { 90.0 };
        }
        let flow = values.get("flow");
        let aside = if flow > MERELY_OPPOSES {
            String::new()
        } else {
            format!(
                ", and turns a slide towards the grain by {} of what friction of greatest power would",
                wording::percent(flow)
            )
        };
        format!(
            "friction across the grain exceeds that along it by {} of their mean; the grain runs at {degrees:.0}° from +x{aside}",
            wording::percent(contrast)
        )
    },
};

/// Share of the flow rule from which on a statement says no more of it.
const MERELY_OPPOSES: f64 = 0.99;

struct AnisotropicFriction {
    /// Unit vector along the grain.
    grain: Point,
    /// (μ_a/μ)² and (μ_c/μ)²
    along: f64,
    across: f64,
    /// Their difference, where it turns the slide.
    turning: f64,
}

impl AnisotropicFriction {
    /// Velocity along and across the grain in m/s; `None` at rest, where friction has no direction.
    fn split(&self, velocity: Point) -> Option<(f64, f64)> {
        let along = self.grain.dot(velocity);
        let across = self.grain.x * velocity.y - self.grain.y * velocity.x;
        (velocity != Point::default()).then_some((along, across))
    }
}

impl Effect for AnisotropicFriction {
    fn acts(&self) -> Acts {
        Acts::Slide
    }

    fn friction_factor(&self, slide: &Slide<'_>) -> f64 {
        self.split(slide.velocity).map_or(1.0, |(a, c)| {
            ((self.along * a * a + self.across * c * c) / (a * a + c * c)).sqrt()
        })
    }

    fn acceleration(&self, slide: &Slide<'_>) -> Point {
        self.split(slide.velocity)
            .map_or(Point::default(), |(a, c)| {
                let tangent = self.turning * a * c / (self.along * a * a + self.across * c * c);
                let left = Point::new(-slide.velocity.y, slide.velocity.x);
                left * (-slide.dry * tangent / slide.velocity.norm())
            })
    }
}

/// Grains along x and along the diagonal make one in between.
fn one_grain(start: &FitStart, coefficients: &[f64]) -> Vec<(String, f64)> {
    let strength = |i: usize| coefficients[i] * start.columns[i].strength.1;
    let (along, diagonal) = (strength(0), strength(1));
    vec![
        ("contrast".into(), along.hypot(diagonal)),
        ("direction".into(), 0.5 * diagonal.atan2(along)),
    ]
}

#[cfg(test)]
mod tests {
    use values::Point;

    use crate::effects::tests::{Bench, DRY, velocity};

    #[test]
    fn along_and_across_the_grain_the_stop_follows_its_formula() {
        for (direction, factor) in [(0.3, 0.9), (0.3 - std::f64::consts::FRAC_PI_2, 1.1)] {
            let grain = [("contrast", 0.2), ("direction", direction)];
            let slid = Bench::with("anisotropic_friction", &grain).slide(0.9, 0.3);
            slid.assert_distance(slid.speed().powi(2) / (2.0 * DRY * factor));
        }
    }

    #[test]
    fn without_its_flow_rule_it_brakes_and_does_not_turn() {
        let grain = [("contrast", 0.4), ("direction", 0.7), ("flow", 0.0)];
        let (angle, apart) = (0.2, 0.5f64);
        let slid = Bench::with("anisotropic_friction", &grain).slide(0.9, angle);
        let factor = (0.8 * apart.cos()).hypot(1.2 * apart.sin());
        slid.assert_distance(slid.speed().powi(2) / (2.0 * DRY * factor));
    }

    #[test]
    fn aslant_the_velocity_turns_by_its_flow_rule() {
        // d ln v_c / d ln v_a = (μ_c/μ_a)², whatever other effects scale the friction by.
        let contrast = 0.3;
        let (grain, other) = (
            [("contrast", contrast), ("direction", -0.4)],
            [("rise", 0.8)],
        );
        let simulated = Bench::with("anisotropic_friction", &grain)
            .and("speed_weakening_friction", &other)
            .strike(0.9, 0.3);
        let split = |t: f64| -> Point { velocity(&simulated, t).rotated(0.4) };
        let (early, late) = (split(0.02), split(0.35));
        let ratio = (late.y / early.y).ln() / (late.x / early.x).ln();
        let expected = ((1.0 + contrast / 2.0) / (1.0 - contrast / 2.0)).powi(2);
        assert!(
            (ratio / expected - 1.0).abs() < 5e-3,
            "{ratio} against {expected}"
        );
    }
}
