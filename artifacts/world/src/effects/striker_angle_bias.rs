//! An arm that strikes beside the commanded direction: delivered angle = commanded + δ.

use super::{
    EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters, formula::delivering,
    wording,
};

/// Striker angle bias; parameter `bias` = δ, counter-clockwise.
pub const SPEC: EffectSpec = EffectSpec {
    name: "striker_angle_bias",
    parameters: Parameters::Listed(&[EffectParameter::new("bias", "rad", [-0.3, 0.3], 0.02)]),
    family: Family::LaunchAngle,
    origin: Origin::Arm,
    equivalent: &["camera_rotation", "off_centre_contact"],
    contains: &[],
    naming: Naming::Ordinary,
    source: "error of calibration between the arm's base and the table",
    starts: |_| FitStart::linear(("bias", 0.005)),
    build: |values, _| {
        let bias = values.get("bias");
        delivering(move |command, _, _| command.turned(bias))
    },
    statement: |values| {
        let bias = values.get("bias");
        format!(
            "the arm strikes {:.1}° to the {} of the commanded direction",
            bias.abs().to_degrees(),
            wording::side(bias)
        )
    },
};

#[cfg(test)]
mod tests {
    use crate::effects::tests::{Bench, START, assert_near};

    #[test]
    fn the_path_is_turned_by_it() {
        let bias = -0.03;
        let turned = Bench::with("striker_angle_bias", &[("bias", bias)]).strike(0.8, 0.2);
        let plain = Bench::plain().strike(0.8, 0.2);
        assert_near(
            turned.stop - START,
            (plain.stop - START).rotated(bias),
            1e-6,
        );
    }
}
