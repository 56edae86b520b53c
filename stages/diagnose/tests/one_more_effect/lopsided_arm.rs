//! An arm that is faster to one side: delivered speed = commanded·(1 + k·angle). Its logged state is fitted by its start.

use values::{Command, Conditions, Point};
use world::effects::{
    Acts, Effect, EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters,
};

/// Lopsided arm; parameter `slope` = k.
pub const SPEC: EffectSpec = EffectSpec {
    name: "lopsided_arm",
    parameters: Parameters::Listed(&[EffectParameter::new("slope", "1/rad", [-0.9, 0.9], 0.1)]),
    family: Family::LaunchSpeed,
    origin: Origin::Arm,
    equivalent: &[],
    contains: &[],
    naming: Naming::Ordinary,
    source: "a speed through a Jacobian that is wrong to first order in the direction",
    starts: |_| FitStart::linear(("slope", 0.02)),
    build: |values, _| {
        Box::new(LopsidedArm {
            slope: values.get("slope"),
        })
    },
    statement: |values| {
        let slope = values.get("slope");
        format!("the arm's speed grows by a share of {slope:.2} for every rad to the left")
    },
};

struct LopsidedArm {
    slope: f64,
}

impl Effect for LopsidedArm {
    fn acts(&self) -> Acts {
        Acts::Launch
    }

    fn deliver(&self, command: Command, _: Point, _: &Conditions) -> Command {
        Command {
            speed: command.speed * (1.0 + self.slope * command.angle),
            ..command
        }
    }
}
