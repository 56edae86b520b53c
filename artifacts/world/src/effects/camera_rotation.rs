//! A camera that is turned about its own axis: centroids are seen rotated about the point it looks down on.

use values::Point;

use super::{
    Column, EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters,
    formula::seeing, parameters::centre, wording,
};

/// Camera rotation; parameter `angle`, by which what is seen is turned counter-clockwise, and `center_x`, `center_y` of
/// the point about which (the rig's camera where they are not given).
pub const SPEC: EffectSpec = EffectSpec {
    name: "camera_rotation",
    parameters: Parameters::Listed(&[
        EffectParameter::new("angle", "rad", [-0.3, 0.3], 0.015),
        centre("center_x", 0.45),
        centre("center_y", 0.0),
    ]),
    family: Family::LaunchAngle,
    origin: Origin::Camera,
    equivalent: &["striker_angle_bias", "off_centre_contact"],
    contains: &[],
    naming: Naming::Ordinary,
    source: "error of a camera's extrinsic calibration about its optical axis",
    starts: |experiment| {
        let column = Column::new(&experiment.camera_centre(), ("angle", 0.005));
        vec![FitStart::new(vec![column], &["angle"])]
    },
    build: |values, rig| {
        let centre = values.camera_centre(rig);
        let (sin, cos) = values.get("angle").sin_cos();
        seeing(sin.atan2(cos), move |point| {
            let Point { x, y } = point - centre;
            centre + Point::new(cos * x - sin * y, sin * x + cos * y)
        })
    },
    statement: |values| {
        let angle = values.get("angle");
        format!(
            "the camera sees the table turned by {:.2}° to the {} about its centre",
            angle.abs().to_degrees(),
            wording::side(angle)
        )
    },
};

#[cfg(test)]
mod tests {
    use crate::effects::tests::{Bench, START, assert_near};

    #[test]
    fn the_seen_path_is_turned_and_begins_where_it_was_seen() {
        let angle = 0.25;
        let seen = Bench::with("camera_rotation", &[("angle", angle)]).strike(0.8, 0.2);
        let plain = Bench::plain().strike(0.8, 0.2);
        assert_near(seen.at(0.0), START, 1e-9);
        assert_near(seen.stop - START, (plain.stop - START).rotated(angle), 1e-6);
    }
}
