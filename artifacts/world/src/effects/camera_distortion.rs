//! A lens that bends the picture: seen = c + (p − c)·(1 + k₁·r²), r the distance from the point c it looks down on.

use values::Point;

use super::{
    Acts, Column, Effect, EffectParameter, EffectSpec, Family, FitStart, Naming, Origin,
    Parameters, parameters::centre, wording,
};

/// Distance in m from the camera's centre at which the distortion is stated.
const STATED_AT: f64 = 0.5;

/// Camera distortion; parameter `k1` = k₁, in metres of the table, and `center_x`, `center_y` = c (the rig's
/// camera where they are not given).
pub const SPEC: EffectSpec = EffectSpec {
    name: "camera_distortion",
    parameters: Parameters::Listed(&[
        EffectParameter::new("k1", "1/m²", [-1.0, 1.5], 0.05),
        centre("center_x", 0.45),
        centre("center_y", 0.0),
    ]),
    family: Family::SeenByPlace,
    origin: Origin::Camera,
    equivalent: &[],
    contains: &[],
    naming: Naming::Ordinary,
    source: "first radial term of lens distortion (Brown 1971)",
    starts: |experiment| {
        let column = Column::new(&experiment.camera_centre(), ("k1", 0.02));
        vec![FitStart::new(vec![column], &["k1"])]
    },
    build: |values, rig| {
        Box::new(CameraDistortion {
            centre: values.camera_centre(rig),
            k1: values.get("k1"),
        })
    },
    statement: |values| {
        let share = values.get("k1") * STATED_AT * STATED_AT;
        format!(
            "the lens shows what is {STATED_AT} m from the camera's centre {} too {} it",
            wording::percent(share),
            if share < 0.0 { "near to" } else { "far from" }
        )
    },
};

struct CameraDistortion {
    centre: Point,
    k1: f64,
}

impl Effect for CameraDistortion {
    fn acts(&self) -> Acts {
        Acts::Camera
    }

    fn observe(&self, point: Point) -> Point {
        let apart = point - self.centre;
        self.centre + apart * (1.0 + self.k1 * apart.dot(apart))
    }
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::{Bench, START, assert_near};

    #[test]
    fn the_seen_stop_follows_its_formula_from_where_the_object_is() {
        for k1 in [-0.3, 0.3] {
            let bench = Bench::with("camera_distortion", &[("k1", k1)]);
            let centre = bench.rig.camera.centre;
            // The radius of the true start solves r·(1 + k₁·r²) = what is seen.
            let seen = START - centre;
            let (mut low, mut high) = (0.0, 2.0 * seen.norm());
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if middle * (1.0 + k1 * middle * middle) < seen.norm() {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            let start = centre + seen * (low / seen.norm());
            let plain = Bench::plain().strike(0.8, 0.2);
            let stop = start + (plain.stop - START) - centre;
            let expected = centre + stop * (1.0 + k1 * stop.norm().powi(2));
            assert_near(bench.strike(0.8, 0.2).stop, expected, 1e-6);
        }
    }
}
