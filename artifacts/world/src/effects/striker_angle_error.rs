//! An arm whose direction errs in proportion to the command: delivered angle = commanded·(1 + a) + δ + b·speed.

use super::{
    Column, EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters,
    formula::delivering, wording,
};

/// Slopes in rad per m/s, and gains, that are worth a word.
const STATED: f64 = 0.002;

/// Striker angle error; parameters `gain` = a, `bias` = δ, `slope` = b.
pub const SPEC: EffectSpec = EffectSpec {
    name: "striker_angle_error",
    parameters: Parameters::Listed(&[
        EffectParameter::new("gain", "", [-0.9, 3.0], 0.1),
        EffectParameter::new("bias", "rad", [-1.5, 1.5], 0.02),
        EffectParameter::new("slope", "rad·s/m", [-2.0, 2.0], 0.03),
    ]),
    family: Family::LaunchAngleByCommand,
    origin: Origin::Arm,
    equivalent: &[],
    contains: &["striker_angle_bias"],
    naming: Naming::Ordinary,
    source: "to first order in the command: a joint's gain, and a tip that yields sideways the more the faster it goes",
    starts: |_| {
        let column = |name| Column::new(&[], (name, 0.005));
        [
            &["gain", "bias"][..],
            &["slope", "bias"],
            &["gain", "slope", "bias"],
        ]
        .map(|names| {
            let columns = names.iter().map(|name| column(*name)).collect();
            FitStart::new(columns, names)
        })
        .into()
    },
    build: |values, _| {
        let [gain, bias, slope] = ["gain", "bias", "slope"].map(|name| values.get(name));
        delivering(move |command, _, _| {
            command.turned(gain * command.angle + bias + slope * command.speed)
        })
    },
    statement: |values| {
        let (gain, bias, slope) = (values.get("gain"), values.get("bias"), values.get("slope"));
        let mut text = String::from("the arm strikes at");
        if gain.abs() >= STATED {
            text += &format!(" {:.2} times", 1.0 + gain);
        }
        text += " the commanded angle";
        if bias.abs() >= STATED {
            let side = wording::side(bias);
            text += &format!(", {:.1}° to the {side}", bias.abs().to_degrees());
        }
        if slope.abs() >= STATED {
            let by = match bias.abs() >= STATED {
                // The bias is that of an arm at rest: the two say something together only.
                true if bias * slope < 0.0 => format!(" less {:.1}°", slope.abs().to_degrees()),
                true => format!(" and {:.1}°", slope.abs().to_degrees()),
                false => {
                    let side = wording::side(slope);
                    format!(", {:.1}° to the {side}", slope.abs().to_degrees())
                }
            };
            text += &format!("{by} for every m/s of speed");
        }
        text
    },
};

#[cfg(test)]
mod tests {
    use crate::effects::tests::{Bench, assert_near};

    #[test]
    fn it_strikes_as_if_commanded_the_angle_of_its_formula() {
        let error = [("gain", 0.5), ("bias", -0.03), ("slope", 0.1)];
        for (speed, commanded, delivered) in [(0.6, 0.2, 0.33), (0.9, -0.1, -0.09)] {
            let stop = Bench::with("striker_angle_error", &error)
                .strike(speed, commanded)
                .stop;
            assert_near(stop, Bench::plain().strike(speed, delivered).stop, 1e-6);
        }
    }
}
