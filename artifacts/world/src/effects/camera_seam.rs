//! A picture that is shifted beyond a line: two cameras that do not agree, a homography for each half, a border of light or print that
//! pulls a tracker. It is stated, and never named: it belongs to no table and no arm.
//!
//! seen = p + s·(1 + tanh(d/w))/2, d the distance of p beyond the line.

use std::f64::consts::FRAC_PI_4;

use values::Point;

use super::{
    Column, EffectParameter, EffectSpec, Experiment, Family, FitStart, Naming, Origin, Parameters,
    formula::seeing,
    parameters::{centre, direction},
    wording,
};

/// Directions across lines that are tried, in eighths of a turn, from the side where objects begin; distance of lines that are tried, in m.
const DIRECTIONS: std::ops::Range<i32> = -1..3;
const APART: f64 = 0.05;
/// Half width in m within which the picture shifts, where a fit begins.
const WIDTH: f64 = 0.02;

const fn shift(name: &'static str) -> EffectParameter {
    EffectParameter::new(name, "m", [-0.05, 0.05], 0.003)
}

/// Camera seam; parameters `direction`: of the line's normal, from +x; `offset`: of the line from a point, `center_x` and `center_y`, along that
/// normal; `width`: half of that within which the shift comes; `shift_x`, `shift_y`: by which what lies beyond is seen elsewhere.
pub const SPEC: EffectSpec = EffectSpec {
    name: "camera_seam",
    parameters: Parameters::Listed(&[
        centre("center_x", 0.5),
        centre("center_y", 0.0),
        direction(),
        EffectParameter::new("offset", "m", [-3.0, 3.0], 0.1),
        EffectParameter::new("width", "m", [0.01, 0.05], 0.01).neutral_at(WIDTH),
        shift("shift_x"),
        shift("shift_y"),
    ]),
    family: Family::SeenBySide,
    origin: Origin::Camera,
    equivalent: &[],
    contains: &[],
    naming: Naming::Never,
    source: "pictures of two cameras side by side, each with its own calibration",
    starts: lines,
    build: |values, _| {
        let (across, middle) = (
            Point::polar(1.0, values.get("direction")),
            values.line_foot(),
        );
        let shift = Point::new(values.get("shift_x"), values.get("shift_y"));
        let width = values.get("width");
        seeing(0.0, move |point| {
            let beyond = across.dot(point - middle) / width;
            point + shift * (0.5 * (1.0 + beyond.tanh()))
        })
    },
    statement: |values| {
        let middle = values.line_foot();
        let shift = Point::new(values.get("shift_x"), values.get("shift_y"));
        format!(
            "beyond a line through ({:.2}, {:.2}) m, across {} from +x, objects are seen shifted by {:.1} mm towards {}: two cameras or two \
             calibrations do not agree there, or a border of light or print pulls the tracker; look at images of the line, and calibrate again",
            middle.x,
            middle.y,
            wording::degrees(values.get("direction")),
            1e3 * shift.norm(),
            wording::degrees(shift.bearing())
        )
    },
};

fn lines(experiment: &Experiment<'_>) -> Vec<FitStart> {
    let [x, y] = experiment.extent();
    let middle = Point::new(0.5 * (x.0 + x.1), 0.5 * (y.0 + y.1));
    let corners = [x.0, x.1].map(|x| [y.0, y.1].map(|y| Point::new(x, y) - middle));
    let mut starts = Vec::new();
    for direction in DIRECTIONS.map(|eighths| f64::from(eighths) * FRAC_PI_4) {
        let normal = Point::polar(1.0, direction);
        let beyond = corners.as_flattened().iter().map(|c| normal.dot(*c));
        let most = (beyond.fold(0.0, f64::max) / APART).floor();
        let lines = (1..2 * most as i32).map(|line| APART * (f64::from(line) - most));
        starts.extend(lines.map(|offset| {
            let form = [
                ("center_x", middle.x),
                ("center_y", middle.y),
                ("direction", direction),
                ("offset", offset),
                ("width", WIDTH),
            ];
            let shifts = ["shift_x", "shift_y"].map(|name| Column::new(&form, (name, 1e-3)));
            let free = ["direction", "offset", "width", "shift_x", "shift_y"];
            FitStart::new(shifts.into(), &free)
        }));
    }
    starts
}

#[cfg(test)]
mod tests {
    use values::Point;

    use crate::effects::tests::{Bench, START, assert_near};

    #[test]
    fn what_lies_beyond_is_seen_shifted() {
        let seam = [
            ("center_x", START.x + 0.1),
            ("width", 0.01),
            ("shift_x", 0.004),
            ("shift_y", -0.003),
        ];
        let plain = Bench::plain().strike(0.9, 0.1);
        let seen = Bench::with("camera_seam", &seam).strike(0.9, 0.1);
        assert!(plain.stop.x > START.x + 0.15);
        assert_near(seen.at(0.0), plain.at(0.0), 1e-6);
        assert_near(seen.stop, plain.stop + Point::new(0.004, -0.003), 1e-4);
    }
}
