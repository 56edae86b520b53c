//! A camera whose picture is stretched or sheared: seen = c + (R + S)·(p − c), R a rotation, S symmetric with no trace, c the
//! point it looks down on.

use values::Point;

use super::{
    Column, EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters,
    formula::seeing, parameters::centre, wording,
};

const fn stretch(name: &'static str) -> EffectParameter {
    EffectParameter::new(name, "", [-0.3, 0.3], 0.01)
}

/// Camera stretch; parameters `along` = a and `diagonal` = b of S = [[a, b], [b, −a]], `turn`, the angle of R (rad), and `center_x`, `center_y` = c
/// (the rig's camera where they are not given).
pub const SPEC: EffectSpec = EffectSpec {
    name: "camera_stretch",
    parameters: Parameters::Listed(&[
        stretch("along"),
        stretch("diagonal"),
        EffectParameter {
            unit: "rad",
            ..stretch("turn")
        },
        centre("center_x", 0.45),
        centre("center_y", 0.0),
    ]),
    family: Family::SeenByHeading,
    origin: Origin::Camera,
    equivalent: &[],
    contains: &[],
    naming: Naming::Never,
    source: "the affine part of a plane's homography (Hartley and Zisserman 2004, section 2.4), scale apart",
    starts: |experiment| {
        // A stretch shows in launches by their angle, and how a box leaves the tip by its angle is the contact's own.
        if !experiment.rig.object.shape().is_round() {
            return Vec::new();
        }
        let form = experiment.camera_centre();
        let columns = ["along", "diagonal", "turn"].map(|name| Column::new(&form, (name, 0.005)));
        vec![FitStart::new(
            columns.into(),
            &["along", "diagonal", "turn"],
        )]
    },
    build: |values, rig| {
        let centre = values.camera_centre(rig);
        let [along, diagonal, turn] = ["along", "diagonal", "turn"].map(|name| values.get(name));
        seeing(turn, move |point| {
            let apart = point - centre;
            let more = Point::new(
                along * apart.x + diagonal * apart.y,
                diagonal * apart.x - along * apart.y,
            );
            centre + apart.rotated(turn) + more
        })
    },
    statement: |values| {
        let stretch = Point::new(values.get("along"), values.get("diagonal"));
        format!(
            "the camera shows lengths {} longer towards {} from +x than across it: its calibration is not that of this table (a homography of other \
             points, pixels that are not square, a readout that is not stated); calibrate it again, and measure a known length both ways",
            wording::percent((1.0 + stretch.norm()) / (1.0 - stretch.norm()) - 1.0),
            wording::degrees(0.5 * stretch.bearing())
        )
    },
};

#[cfg(test)]
mod tests {
    use values::Point;

    use crate::effects::tests::{Bench, START, assert_near};

    #[test]
    fn a_path_is_turned() {
        let seen = Bench::with("camera_stretch", &[("turn", 0.1)]).strike(0.8, 0.2);
        let path = Bench::plain().strike(0.8, 0.2).stop - START;
        assert_near(seen.stop - seen.at(0.0), path.rotated(0.1), 1e-6);
    }

    #[test]
    fn a_path_is_longer_one_way_and_shorter_across() {
        for (angle, form) in [(0.0, "along"), (45f64.to_radians(), "diagonal")] {
            let seen = Bench::with("camera_stretch", &[(form, 0.1)]);
            let plain = Bench::plain();
            for (turned, factor) in [(0.0, 1.1), (90f64.to_radians(), 0.9)] {
                let (seen, plain) = (
                    seen.strike(0.8, angle + turned),
                    plain.strike(0.8, angle + turned),
                );
                let path: Point = plain.stop - START;
                assert_near(seen.stop - seen.at(0.0), path * factor, 1e-6);
            }
        }
    }
}
