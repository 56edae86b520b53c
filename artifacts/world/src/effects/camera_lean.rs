//! A camera that does not look straight down: seen = c + (p − c)/(1 + l·(p − c)), c the point it looks down on.

use values::{Point, Rig};

use super::{
    action::{Acts, Effect},
    parameters::{EffectParameter, Parameters, Values, centre},
    spec::{EffectSpec, Family},
    start::{Column, Experiment, FitStart},
};

/// Scale beyond which a picture shows no table: what lies there is as good as at the horizon.
const LEAST_SCALE: f64 = 0.2;

const fn lean(name: &'static str) -> EffectParameter {
    EffectParameter {
        name,
        unit: "1/m",
        low: -0.8,
        high: 0.8,
        neutral: 0.0,
        scale: 0.04,
    }
}

/// Camera lean; parameters `lean_x`, `lean_y` = l, and `center_x`, `center_y` = c (the rig's camera where they are not given).
pub const SPEC: EffectSpec = EffectSpec {
    name: "camera_lean",
    parameters: Parameters::Listed(&[
        lean("lean_x"),
        lean("lean_y"),
        centre("center_x", 0.45),
        centre("center_y", 0.0),
    ]),
    family: Family::SeenByPlace,
    equivalent: &[],
    contains: &[],
    is_last_resort: false,
    source: "perspective of a plane that is not parallel to the image (keystone): a camera at height h that leans by α has l = tan α/h",
    starts: |experiment: &Experiment<'_>| {
        let form = experiment.camera_centre();
        let names = ["lean_x", "lean_y"];
        let columns = names.map(|name| Column::new(&form, (name, 0.01)));
        vec![FitStart::new(columns.into(), &names)]
    },
    build: |values: &Values, rig: &Rig| {
        Box::new(CameraLean {
            centre: values.camera_centre(rig),
            lean: Point::new(values.get("lean_x"), values.get("lean_y")),
        })
    },
    statement: |values| {
        let lean = Point::new(values.get("lean_x"), values.get("lean_y"));
        format!(
            "the camera leans: it shows lengths {:.1} % smaller for every metre towards {:.0}° from +x",
            100.0 * lean.norm(),
            lean.bearing().to_degrees()
        )
    },
};

struct CameraLean {
    centre: Point,
    lean: Point,
}

impl Effect for CameraLean {
    fn acts(&self) -> Acts {
        Acts::Camera
    }

    fn observe(&self, point: Point) -> Point {
        let apart = point - self.centre;
        self.centre + apart * (1.0 + self.lean.dot(apart)).max(LEAST_SCALE).recip()
    }
}

#[cfg(test)]
mod tests {
    use values::Point;

    use crate::effects::tests::{Bench, START, assert_near};

    #[test]
    fn it_changes_the_track() {
        Bench::with("camera_lean", &[("lean_x", 0.05)]).assert_changes_track();
    }

    #[test]
    fn the_seen_stop_follows_its_formula_from_where_the_object_is() {
        let lean = Point::new(0.06, -0.04);
        let bench = Bench::with("camera_lean", &[("lean_x", lean.x), ("lean_y", lean.y)]);
        let centre = bench.rig.camera.centre;
        // Turned round: p − c = s/(1 − l·s), s what is seen from c.
        let seen = START - centre;
        let start = centre + seen * (1.0 - lean.dot(seen)).recip();
        let plain = Bench::plain().strike(0.8, 0.2);
        let stop = start + (plain.stop - START) - centre;
        let expected = centre + stop * (1.0 + lean.dot(stop)).recip();
        assert_near(bench.strike(0.8, 0.2).stop, expected, 1e-6);
    }

    #[test]
    fn the_centre_is_the_effects_own_where_it_is_given() {
        let given = |x| {
            let parameters = [("lean_x", 0.06), ("center_x", x), ("center_y", 0.0)];
            Bench::with("camera_lean", &parameters)
                .strike(0.8, 0.2)
                .stop
        };
        let own = Bench::with("camera_lean", &[("lean_x", 0.06)]);
        assert_near(
            given(own.rig.camera.centre.x),
            own.strike(0.8, 0.2).stop,
            1e-9,
        );
        assert!(given(0.2).distance(given(0.6)) > 1e-3);
    }
}
