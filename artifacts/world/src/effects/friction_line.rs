//! A narrow line of other friction across the table: glue, tape, a scratch. It is stated, and never named: it can be taken away.
//!
//! μ(p) = μ·(1 + l·exp(−d²/(2·w²))/(w·√(2π))), d the distance of p from the line: a crossing at a right angle costs as much as l of way.

use std::f64::consts::{FRAC_PI_8, TAU};

use values::Point;

use super::{
    Column, EffectParameter, EffectSpec, Experiment, Family, FitStart, Naming, Origin, Parameters,
    Slide,
    formula::braking_within,
    parameters::{centre, direction},
};

/// Directions across lines that are tried, in eighths of a half turn.
const DIRECTIONS: std::ops::Range<i32> = -3..5;
/// Distance of lines that are tried, and their width, in m.
const APART: f64 = 0.03;
const WIDTH: f64 = 0.015;
/// Widths that hold nearly all of a line.
const SEEN_WIDTHS: f64 = 4.0;
/// Least factor on friction: however slippery the line, this share of friction is left.
const LEAST_FACTOR: f64 = 0.05;

/// Friction line; parameters `direction`: of the line's normal, from +x; `offset`: of the line from a point, `center_x` and `center_y`,
/// along that normal; `width`: standard deviation of its profile; `length`: of the way that costs as much as a crossing does.
pub const SPEC: EffectSpec = EffectSpec {
    name: "friction_line",
    parameters: Parameters::Listed(&[
        centre("center_x", 0.5),
        centre("center_y", 0.0),
        direction(),
        EffectParameter::new("offset", "m", [-3.0, 3.0], 0.1),
        EffectParameter::new("width", "m", [0.003, 0.03], 0.003).neutral_at(WIDTH),
        EffectParameter::new("length", "m", [-0.1, 0.5], 0.02),
    ]),
    family: Family::FrictionByPlace,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    naming: Naming::Never,
    source: "work of friction along a strip that is narrower than the object",
    starts: lines,
    build: |values, _| {
        let (width, length) = (values.get("width"), values.get("length"));
        let (across, middle) = (
            Point::polar(1.0, values.get("direction")),
            values.line_foot(),
        );
        // From the line, in widths.
        let apart = move |position: Point| across.dot(position - middle) / width;
        let factor = move |slide: &Slide<'_>| {
            let profile = (-0.5 * apart(slide.position).powi(2)).exp();
            (1.0 + length * profile / (width * TAU.sqrt())).max(LEAST_FACTOR)
        };
        braking_within(factor, move |at| width * (apart(at).abs() - 4.0).max(0.5))
    },
    statement: |values| {
        let (middle, length) = (values.line_foot(), values.get("length"));
        format!(
            "a line lies across the table through ({:.2}, {:.2}) m, towards {:.0}° from +x, {:.1} cm wide: a crossing costs as much as \
             {:.1} cm of way {}, as glue, tape, a scratch or a smooth strip would do; look at the table there, and log again once it is clean",
            middle.x,
            middle.y,
            (values.get("direction").to_degrees() + 90.0).rem_euclid(180.0),
            100.0 * SEEN_WIDTHS * values.get("width"),
            100.0 * length.abs(),
            if length < 0.0 { "less" } else { "more" }
        )
    },
};

fn lines(experiment: &Experiment<'_>) -> Vec<FitStart> {
    let [x, y] = experiment.extent();
    let middle = Point::new(0.5 * (x.0 + x.1), 0.5 * (y.0 + y.1));
    let points = || {
        let strikes = experiment.strikes.iter();
        strikes.flat_map(|strike| (0..strike.track.len()).map(|i| strike.track.point(i)))
    };
    let mut starts = Vec::new();
    for direction in DIRECTIONS.map(|eighths| f64::from(eighths) * FRAC_PI_8) {
        let normal = Point::polar(1.0, direction);
        let along = |offset: f64| ((offset / APART).round()) as i32;
        let offsets = points().map(|point| along(normal.dot(point - middle)));
        let (low, high) = offsets.fold((i32::MAX, i32::MIN), |(low, high), offset| {
            (low.min(offset), high.max(offset))
        });
        for offset in low..=high {
            let form = [
                ("center_x", middle.x),
                ("center_y", middle.y),
                ("direction", direction),
                ("offset", APART * f64::from(offset)),
                ("width", WIDTH),
            ];
            starts.push(FitStart::new(
                vec![Column::new(&form, ("length", 0.005))],
                &["direction", "offset", "width", "length"],
            ));
        }
    }
    starts
}

#[cfg(test)]
mod tests {
    use values::Point;

    use crate::effects::tests::{Bench, DRY};

    const LINE: [(&str, f64); 6] = [
        ("center_x", 0.3),
        ("center_y", 0.1),
        ("direction", 0.3),
        ("offset", 0.07),
        ("width", 0.006),
        ("length", 0.05),
    ];

    #[test]
    fn the_stop_follows_its_formula() {
        let slid = Bench::with("friction_line", &LINE).slide(0.95, 0.1);
        slid.assert_integrates(|position, velocity| {
            let from = position - Point::new(0.3, 0.1);
            let apart = (Point::polar(1.0, 0.3).dot(from) - 0.07) / 0.006;
            let more = 0.05 * (-0.5 * apart * apart).exp() / (0.006 * 2.506_628_274_6);
            velocity * (-DRY * more / velocity.norm())
        });
    }
}
