//! Friction that differs on the two sides of a line: two sheets, a seam, a coated half.
//!
//! Friction changes by the share of the object's base, taken as a circle, that lies beyond the line, so that it is smooth.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use values::Point;

use super::{
    Column, EffectParameter, EffectSpec, Experiment, Family, FitStart, Naming, Origin, Parameters,
    footprint::{Footprint, LEAD, SOFTNESS},
    formula::braking_within,
    parameters::direction,
    wording,
};

/// Directions across lines that are tried, in eighths of a turn, and lines of each: so many that a start lies within a base or
/// two of any seam.
const DIRECTIONS: [f64; 8] = [-1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0, 2.5];
const LINES: u32 = 14;

/// Where a curved line has the direction and offset that are stated, in m along it: that of this point on the table.
const ABOUT: Point = Point::new(0.5, 0.0);

/// A change of friction that bends a track beyond what the strike's own friction does by less than cameras see.
pub(super) const SMALL: f64 = 0.01;

/// Friction step; parameters `direction`: of the line's normal, from +x; `offset`: of the line from the origin along that
/// normal; `change`: the relative change of friction beyond it; details of its edge [`SOFTNESS`] and [`LEAD`], and its `curvature` (1/m, positive where it bends towards what lies beyond), about [`ABOUT`].
pub const SPEC: EffectSpec = EffectSpec {
    name: "friction_step",
    parameters: Parameters::Listed(&[
        direction(),
        EffectParameter::new("offset", "m", [-3.0, 3.0], 0.1).neutral_at(0.5),
        EffectParameter::new("change", "", [-0.9, 3.0], 0.2),
        SOFTNESS,
        LEAD,
        EffectParameter::new("curvature", "1/m", [-5.0, 5.0], 1.0).as_detail(),
    ]),
    family: Family::FrictionByPlace,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    naming: Naming::Ordinary,
    source: "two surfaces that meet; area of a segment of a circle",
    starts: lines,
    build: |values, rig| {
        let normal = Point::polar(1.0, values.get("direction"));
        let [offset, change, curvature] =
            ["offset", "change", "curvature"].map(|name| values.get(name));
        let base = Footprint::of(values, rig);
        // Distance in m beyond the line.
        let beyond = move |position: Point| {
            let along = normal.rotated(FRAC_PI_2).dot(position - ABOUT);
            let bends = 0.5 * curvature * along * along;
            let slope = curvature * along;
            (normal.dot(position) - offset - bends) / slope.hypot(1.0)
        };
        braking_within(
            move |slide| 1.0 + change * share_beyond(beyond(base.felt_at(slide)) / base.radius),
            move |at| base.smooth_within(beyond(at).abs()),
        )
    },
    statement: |values| {
        let direction = values.get("direction");
        let foot = Point::polar(values.get("offset"), direction);
        format!(
            "friction is {} beyond the line through ({:.2}, {:.2}) m, towards {} from +x",
            wording::higher(values.get("change")),
            foot.x,
            foot.y,
            wording::degrees(direction)
        )
    },
};

fn lines(experiment: &Experiment<'_>) -> Vec<FitStart> {
    let points = || {
        experiment.strikes.iter().flat_map(|strike| {
            let track = (0..strike.track.len()).map(|i| strike.track.point(i));
            track.chain([strike.initial])
        })
    };
    let mut starts = Vec::new();
    for direction in DIRECTIONS.map(|eighths| eighths * FRAC_PI_4) {
        let normal = Point::polar(1.0, direction);
        let (low, high) = points()
            .map(|point| normal.dot(point))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            });
        for line in 1..=LINES {
            let offset = low + (high - low) * f64::from(line) / f64::from(LINES + 1);
            let form = [("direction", direction), ("offset", offset)];
            let column = Column::new(&form, ("change", SMALL));
            starts.push(FitStart::new(
                vec![column],
                &["direction", "offset", "change"],
            ));
        }
    }
    starts
}

/// Share of a circle beyond a line, by how far its centre is beyond it, in radii.
fn share_beyond(centre: f64) -> f64 {
    let z = centre.clamp(-1.0, 1.0);
    1.0 - (z.acos() - z * (1.0 - z * z).sqrt()) / PI
}

#[cfg(test)]
mod tests {
    use super::share_beyond;
    use crate::effects::tests::{Bench, DRY};
    use values::Point;

    #[test]
    fn the_share_of_a_circle_beyond_a_line_is_its_area() {
        assert_eq!((share_beyond(-1.5), share_beyond(2.0)), (0.0, 1.0));
        assert!((share_beyond(0.0) - 0.5).abs() < 1e-12);
        // By counting.
        let (mut inside, mut all) = (0, 0);
        for i in -500..500 {
            for j in -500..500 {
                let (x, y) = (f64::from(i) / 500.0, f64::from(j) / 500.0);
                if x * x + y * y < 1.0 {
                    all += 1;
                    inside += i32::from(x > -0.4);
                }
            }
        }
        let counted = f64::from(inside) / f64::from(all);
        assert!((share_beyond(0.4) - counted).abs() < 2e-3, "{counted}");
    }

    #[test]
    fn the_stop_follows_its_formula() {
        let (direction, offset, change, base) = (0.5, 0.45, 0.6, 0.03);
        let step = [
            ("direction", direction),
            ("offset", offset),
            ("change", change),
        ];
        let slid = Bench::with("friction_step", &step).slide(0.95, 0.1);
        slid.assert_integrates(|position, velocity| {
            let beyond = Point::polar(1.0, direction).dot(position) - offset;
            let more = change * share_beyond(beyond / base);
            velocity * (-DRY * more / velocity.norm())
        });
    }

    #[test]
    fn a_curved_edge_is_that_of_a_large_disc() {
        let disc = [
            ("center_x", 0.9),
            ("center_y", 0.0),
            ("radius", 0.5),
            ("change", 0.6),
        ];
        let step = |curvature| {
            let step = [
                ("direction", 0.0),
                ("offset", 0.4),
                ("change", 0.6),
                ("curvature", curvature),
            ];
            Bench::with("friction_step", &step).slide(0.95, 0.4).stop
        };
        let on_disc = Bench::with("friction_patch", &disc).slide(0.95, 0.4).stop;
        let (curved, straight) = (step(2.0), step(0.0));
        assert!(curved.distance(on_disc) < 5e-4, "{curved:?} {on_disc:?}");
        assert!(straight.distance(on_disc) > 2e-3, "{straight:?}");
    }
}
