//! An arm that does not deliver the commanded speed: min(a + b·commanded, cap).
//!
//! An arm may come near its cap smoothly: u/(1 + (u/cap)^(1/s))^s, u = a + b·commanded, s its softness. That is min(u, cap)
//! for s = 0, and cap·tanh(u/cap) to 3 % for s = 0.37.

use values::Command;

use super::{
    Column, EffectParameter, EffectSpec, Experiment, Family, FitStart, Naming, Origin, Parameters,
    formula::delivering,
};

/// The greatest cap, in m/s, means none.
const NO_CAP: f64 = 5.0;
/// An offset in m/s that is worth a word.
const STATED: f64 = 0.0005;

/// Shares of the commanded speeds at which a cap is tried: a start a little beside it shows none of its sharp bend.
const CAPS: [f64; 8] = [0.3, 0.45, 0.58, 0.68, 0.76, 0.84, 0.9, 0.95];

/// Softness below which a cap is hard: it differs by less than rounding.
const HARD: f64 = 1e-9;
/// Softness of a tanh, to 3 %, from which fits start.
const SOFT: f64 = 0.37;
/// A softness from which on the statement mentions it.
const STATED_SOFTNESS: f64 = 0.1;
/// Caps over the fastest command at which a soft one is tried: it acts well below itself.
const SOFT_CAPS: [f64; 4] = [0.7, 1.0, 1.4, 2.0];

/// Striker speed error; parameters `offset` = a, `slope` = b, `cap`, `softness` = s. A cap above the speeds that were struck at changes
/// nothing, so a fit of it starts among them.
pub const SPEC: EffectSpec = EffectSpec {
    name: "striker_speed_error",
    parameters: Parameters::Listed(&[
        EffectParameter::new("offset", "m/s", [-0.5, 0.5], 0.04),
        EffectParameter::new("slope", "", [0.3, 2.0], 0.06).neutral_at(1.0),
        EffectParameter::new("cap", "m/s", [0.2, NO_CAP], 0.2).neutral_at(NO_CAP),
        EffectParameter::new("softness", "", [0.0, 1.0], 0.2),
    ]),
    family: Family::LaunchSpeed,
    origin: Origin::Arm,
    equivalent: &["speed_dependent_restitution"],
    contains: &[],
    naming: Naming::Ordinary,
    source: "gain, offset and saturation of a speed-controlled axis",
    starts: caps_and_offsets,
    build: |values, _| {
        let [offset, slope, cap, softness] =
            ["offset", "slope", "cap", "softness"].map(|name| values.get(name));
        delivering(move |command, _, _| Command {
            speed: capped(offset + slope * command.speed, cap, softness),
            ..command
        })
    },
    statement: |values| {
        let (slope, offset, cap) = (values.get("slope"), values.get("offset"), values.get("cap"));
        // A constant factor is restitution's by another name, and stays there unless it is set.
        let factor = if slope == 1.0 {
            "but for a constant factor that restitution holds, the arm delivers".into()
        } else {
            format!("the arm delivers {slope:.2} times")
        };
        let mut text = format!("{factor} the commanded speed");
        if offset.abs() >= STATED {
            let sign = if offset < 0.0 { "less" } else { "plus" };
            text += &format!(" {sign} {:.3} m/s", offset.abs());
        }
        if cap < NO_CAP {
            let and = if offset.abs() >= STATED {
                ", and"
            } else {
                ", but"
            };
            let how = if values.get("softness") < STATED_SOFTNESS {
                "at most"
            } else {
                "ever less than that as it comes near"
            };
            text += &format!("{and} {how} {cap:.2} m/s");
        }
        text
    },
};

fn capped(speed: f64, cap: f64, softness: f64) -> f64 {
    if cap >= NO_CAP || speed <= 0.0 || softness < HARD {
        return speed.min(cap);
    }
    // In logarithms, for the power may be any.
    let over = (speed / cap).ln() / softness;
    let softplus = over.max(0.0) + (-over.abs()).exp().ln_1p();
    speed * (-softness * softplus).exp()
}

/// The slope is restitution's by another name: a fit starts from a cap, an offset, or both.
fn caps_and_offsets(experiment: &Experiment<'_>) -> Vec<FitStart> {
    let offset = || Column::new(&[], ("offset", 0.01));
    let mut starts = vec![FitStart::new(vec![offset()], &["offset"])];
    for share in CAPS {
        let mut cap = Column::new(&[], ("cap", experiment.speed_at(share)));
        cap.is_kept = true;
        starts.push(FitStart::new(vec![cap.clone()], &["cap"]));
        let both = FitStart::new(vec![cap, offset()], &["cap", "offset"]);
        starts.push(both.combined_by(moved_cap));
    }
    for share in SOFT_CAPS {
        let cap = share * experiment.speed_at(1.0);
        let mut soft = Column::new(&[("softness", SOFT)], ("cap", cap));
        soft.is_kept = true;
        starts.push(FitStart::new(vec![soft], &["cap", "softness"]));
    }
    starts
}

/// A cap at a commanded speed and an offset: min(v, knee) + offset is min(v + offset, knee + offset).
fn moved_cap(start: &FitStart, coefficients: &[f64]) -> Vec<(String, f64)> {
    let offset = coefficients[1] * start.columns[1].strength.1;
    vec![("cap".into(), start.columns[0].strength.1 + offset)]
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::{Bench, assert_near};

    #[test]
    fn it_strikes_as_if_commanded_the_speed_of_its_formula() {
        let error = [("offset", 0.05), ("slope", 0.8), ("cap", 0.75)];
        for (commanded, delivered) in [(0.5, 0.45), (0.8, 0.69), (1.0, 0.75)] {
            let stop = Bench::with("striker_speed_error", &error)
                .strike(commanded, 0.2)
                .stop;
            assert_near(stop, Bench::plain().strike(delivered, 0.2).stop, 1e-6);
        }
    }
    #[test]
    fn a_soft_cap_is_nearly_a_tanh_and_a_hard_one_its_limit() {
        let delivered = |softness: f64, commanded: f64| super::capped(commanded, 1.5, softness);
        for i in 1..40 {
            let commanded = 0.1 * f64::from(i);
            let tanh = 1.5 * (commanded / 1.5).tanh();
            assert!(
                (delivered(super::SOFT, commanded) / tanh - 1.0).abs() < 0.03,
                "{commanded}"
            );
            assert!(
                (delivered(1e-4, commanded) - commanded.min(1.5)).abs() < 2e-4,
                "{commanded}"
            );
            assert_eq!(delivered(0.0, commanded), commanded.min(1.5));
        }
    }
}
