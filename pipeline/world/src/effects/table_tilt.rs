//! A table that is not level: a = g·(sin t_x, sin t_y).

use values::{Point, Rig};

use super::{Effect, EffectParameter, EffectSpec, Slide, Values};

const GRAVITY: f64 = 9.81;

const fn tilt(name: &'static str) -> EffectParameter {
    EffectParameter {
        name,
        unit: "rad",
        low: -0.1,
        high: 0.1,
        neutral: 0.0,
        scale: 0.005,
    }
}

/// Table tilt; parameters `tilt_x`, `tilt_y`: the slope down along +x and +y.
pub const SPEC: EffectSpec = EffectSpec {
    name: "table_tilt",
    parameters: &[tilt("tilt_x"), tilt("tilt_y")],
    source: "weight on an inclined plane",
    build: |values: &Values, _: &Rig| {
        Box::new(TableTilt {
            acceleration: Point::new(values.get("tilt_x").sin(), values.get("tilt_y").sin())
                * GRAVITY,
        })
    },
    statement: |values| {
        let down = Point::new(values.get("tilt_x"), values.get("tilt_y"));
        format!(
            "the table slopes down by {:.1} mm per metre towards {:.0}° from +x",
            1000.0 * down.norm(),
            down.bearing().to_degrees()
        )
    },
};

struct TableTilt {
    acceleration: Point,
}

impl Effect for TableTilt {
    fn acceleration(&self, _: &Slide<'_>) -> Point {
        self.acceleration
    }
}

#[cfg(test)]
mod tests {
    use super::GRAVITY;
    use crate::effects::tests::{assert_changes_track, slide_distance};

    #[test]
    fn it_changes_the_track() {
        assert_changes_track("table_tilt", &[("tilt_y", 0.005)]);
    }

    #[test]
    fn downhill_goes_further_by_its_formula() {
        let tilt: f64 = 0.01;
        let (distance, dry, release) = slide_distance("table_tilt", &[("tilt_x", tilt)], 0.9, 0.0);
        let expected = release * release / (2.0 * (dry - GRAVITY * tilt.sin()));
        assert!(
            (distance - expected).abs() < 3e-4,
            "{distance} against {expected}"
        );
    }
}
