//! A force across the velocity: a = ω·(−v_y, v_x). The library states such a force and never names it: this file is all that an effect takes.

use values::{Point, Rig};
use world::effects::{
    Acts, Effect, EffectParameter, EffectSpec, Experiment, Family, FitStart, Naming, Origin,
    Parameters, Slide, Values,
};

/// Turning force; parameter `rate` = ω.
pub const SPEC: EffectSpec = EffectSpec {
    name: "turning_force",
    parameters: Parameters::Listed(&[EffectParameter::new("rate", "1/s", [-2.0, 2.0], 0.1)]),
    family: Family::FrictionByHeading,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    naming: Naming::Ordinary,
    source: "as on a body that spins, or on a charge in a magnetic field",
    starts: |_: &Experiment<'_>| FitStart::linear(("rate", 0.02)),
    build: |values: &Values, _: &Rig| {
        Box::new(TurningForce {
            rate: values.get("rate"),
        })
    },
    statement: |values| {
        let rate = values.get("rate");
        format!("a force across the velocity turns the slide: {rate:.2} m/s² for every m/s")
    },
};

struct TurningForce {
    rate: f64,
}

impl Effect for TurningForce {
    fn acts(&self) -> Acts {
        Acts::Slide
    }

    fn acceleration(&self, slide: &Slide<'_>) -> Point {
        Point::new(-slide.velocity.y, slide.velocity.x) * self.rate
    }
}
