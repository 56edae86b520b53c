//! A disc on the table with another friction: a stain, a worn spot, a sheet of tape.
//!
//! Friction changes by the share of the object's base that lies on the disc, both taken as circles, so that it is smooth. Real patches are longer one way
//! and fade out at their edge: details, without which the strength of a patch would be surely wrong.

use std::f64::consts::PI;

use values::Point;

use super::{
    Column, EffectParameter, EffectSpec, Experiment, Family, FitStart, Naming, Origin, Parameters,
    Slide, Values,
    footprint::{Footprint, LEAD, SOFTNESS},
    formula::braking_within,
    friction_step::SMALL,
    parameters::middle,
    wording,
};

/// Width in m of the cells on which patches are tried, and their radii.
const CELL: f64 = 0.05;
const RADII: [f64; 3] = [0.04, 0.08, 0.14];
/// Frames that such a cell must hold to be tried.
const FRAMES: usize = 12;
/// Distance in m of the middles of wide patches, all over the extent of the tracks, for strikes may meet nothing but their edge; and their radii.
const LARGE_CELL: f64 = 0.15;
const LARGE_RADII: [f64; 2] = [0.25, 0.45];

/// Elongation from which a patch is told as an ellipse.
const OBLONG: f64 = 0.1;

/// Friction patch; parameters `center_x`, `center_y`, `radius` of the disc, and the relative `change` of friction on it. Details: [`SOFTNESS`] and [`LEAD`]
/// of its edge (the radius is that of a sharp disc which takes as much from all slides together), and the logarithms by which it is longer along x (`elongation`) and along the diagonal between x and y (`skew`) than a disc of its area.
pub const SPEC: EffectSpec = EffectSpec {
    name: "friction_patch",
    parameters: Parameters::Listed(&[
        middle("center_x", 0.5),
        middle("center_y", 0.0),
        EffectParameter::new("radius", "m", [0.01, 0.5], 0.05).neutral_at(0.1),
        // A fiftieth of the table's friction: no surface has less, and with none an object would never stop there.
        EffectParameter::new("change", "", [-0.98, 3.0], 0.3),
        SOFTNESS,
        LEAD,
        EffectParameter::new("elongation", "", [-1.0, 1.0], 0.25).as_detail(),
        EffectParameter::new("skew", "", [-1.0, 1.0], 0.25).as_detail(),
    ]),
    family: Family::FrictionByPlace,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    naming: Naming::Ordinary,
    source: "friction varies over a table (Yu et al. 2016; Ma and Rodriguez 2018); area common to two circles",
    starts: patches,
    build: |values, rig| {
        let (centre, radius, change) =
            (values.centre(), values.get("radius"), values.get("change"));
        let base = Footprint::of(values, rig);
        // Takes what lies about the centre to a disc of the same area, by rows; and how much it shortens at the most.
        let to_disc = stretch(longer(values) * -1.0);
        let shortest = (-longer(values).norm()).exp();
        let apart = move |at: Point| product(to_disc, at - centre);
        let factor = move |slide: &Slide<'_>| {
            let apart = apart(base.felt_at(slide));
            1.0 + change * covered(base.radius, radius, apart.dot(apart))
        };
        braking_within(factor, move |at| {
            shortest * base.smooth_within(apart(at).norm() - radius)
        })
    },
    statement: |values| {
        let (longer, radius) = (longer(values), values.get("radius"));
        let shape = if longer.norm() < OBLONG {
            format!("a disc of {:.1} cm radius", 100.0 * radius)
        } else {
            let [long, short] = [1.0, -1.0].map(|sign| radius * (sign * longer.norm()).exp());
            format!(
                "an ellipse of {:.1} by {:.1} cm (half axes; the longer one at {} from +x)",
                100.0 * long,
                100.0 * short,
                wording::degrees(0.5 * longer.bearing())
            )
        };
        format!(
            "friction is {} inside {shape} around ({:.2}, {:.2}) m",
            wording::higher(values.get("change")),
            values.get("center_x"),
            values.get("center_y")
        )
    },
};

/// Logarithms by which a patch is longer along x and along the diagonal.
fn longer(values: &Values) -> Point {
    Point::new(values.get("elongation"), values.get("skew"))
}

/// exp(L) by rows, L = [[a, b], [b, −a]] with (a, b) = `longer`.
fn stretch(longer: Point) -> [Point; 2] {
    let size = longer.norm();
    let mean = size.cosh();
    let by = if size == 0.0 { 0.0 } else { size.sinh() / size };
    let (along, diagonal) = (by * longer.x, by * longer.y);
    [
        Point::new(mean + along, diagonal),
        Point::new(diagonal, mean - along),
    ]
}

fn product([first, second]: [Point; 2], by: Point) -> Point {
    Point::new(first.dot(by), second.dot(by))
}

/// The edge of a patch with these values on the table, a closed line (m).
pub fn patch_edge(values: &Values) -> Vec<Point> {
    let centre = values.centre();
    let directions = (0..=60).map(|k| 2.0 * PI * f64::from(k) / 60.0);
    let stretch = stretch(longer(values));
    directions
        .map(|direction| Point::polar(values.get("radius"), direction))
        .map(|on_disc| centre + product(stretch, on_disc))
        .collect()
}

/// Share of a circle of radius `base` that lies in one of radius `disc`, their centres `square` apart, squared.
fn covered(base: f64, disc: f64, square: f64) -> f64 {
    if square >= (base + disc).powi(2) {
        return 0.0;
    }
    if square <= (base - disc).powi(2) {
        return (disc / base).powi(2).min(1.0);
    }
    let distance = square.sqrt();
    let (base_square, disc_square) = (base * base, disc * disc);
    // Half angles that the common chord spans at either centre, each a segment of its circle.
    let base_cos = (square + base_square - disc_square) / (2.0 * distance * base);
    let disc_cos = (square + disc_square - base_square) / (2.0 * distance * disc);
    let segment = |cos: f64| {
        let cos = cos.clamp(-1.0, 1.0);
        cos.acos() - cos * (1.0 - cos * cos).sqrt()
    };
    (base_square * segment(base_cos) + disc_square * segment(disc_cos)) / (PI * base_square)
}

fn patches(experiment: &Experiment<'_>) -> Vec<FitStart> {
    let reach = experiment.rig.object.solid.reach();
    let about =
        FitStart::new(Vec::new(), &["center_x", "center_y", "radius", "change"]).about(experiment);
    let start = |centre: Point, radius: f64| {
        let form = [
            ("center_x", centre.x),
            ("center_y", centre.y),
            ("radius", radius),
        ];
        let mut column = Column::new(&form, ("change", SMALL));
        column.region = Some((centre, radius + reach));
        FitStart {
            columns: vec![column],
            ..about.clone()
        }
    };
    let small = experiment.cells(CELL, FRAMES).into_iter();
    let small = small.flat_map(|centre| RADII.map(|radius| start(centre, radius)));
    let [x, y] = experiment.extent().map(|(low, high)| {
        let count = ((high - low) / LARGE_CELL).ceil().max(1.0);
        (0..=count as u32).map(move |k| low + (high - low) * f64::from(k) / count)
    });
    let large = x.flat_map(|x| y.clone().map(move |y| Point::new(x, y)));
    let large = large.flat_map(|centre| LARGE_RADII.map(|radius| start(centre, radius)));
    small.chain(large).collect()
}

#[cfg(test)]
mod tests {
    use values::Point;

    use std::f64::consts::PI;

    use super::{covered, patch_edge};
    use crate::GRAVITY;
    use crate::effects::{
        AddedEffect,
        tests::{Bench, DRY},
        values,
    };

    #[test]
    fn a_slide_that_leaves_the_patch_stops_by_its_formula() {
        // Energy: ∫ a·(1 + change·share) dx = v₀²/2 over the path, the share taken by counting.
        let (centre, radius, change, base) = (Point::new(0.3, 0.1), 0.12, 0.5, 0.03);
        let slid = Bench::with(
            "friction_patch",
            &[
                ("center_x", centre.x),
                ("center_y", centre.y),
                ("radius", radius),
                ("change", change),
            ],
        )
        .slide(0.9, 0.0);
        let (step, mut energy, mut x) = (1e-4, 0.5 * slid.speed().powi(2), slid.from.x);
        while energy > 0.0 {
            let share = counted(base, radius, centre.distance(Point::new(x, slid.from.y)));
            energy -= step * DRY * (1.0 + change * share);
            x += step;
        }
        slid.assert_distance(x - slid.from.x);
    }

    #[test]
    fn a_patch_that_is_felt_ahead_brakes_as_one_that_lies_nearer() {
        let at = |center_x: f64, lead: f64| {
            let patch = [
                ("center_x", center_x),
                ("center_y", 0.0),
                ("radius", 0.1),
                ("change", 0.8),
                ("lead", lead),
            ];
            Bench::with("friction_patch", &patch).slide(0.95, 0.0).stop
        };
        // The demo's cylinder is 4 cm high; μ·h of it.
        let ahead = DRY / GRAVITY * 0.02;
        let (felt_ahead, nearer) = (at(0.45, 1.0), at(0.45 - ahead, 0.0));
        assert!(
            felt_ahead.distance(nearer) < 1e-5,
            "{felt_ahead:?} {nearer:?}"
        );
        assert!(felt_ahead.distance(at(0.45, 0.0)) > 1e-4);
    }

    /// Share of the base within the disc, by strips.
    fn counted(base: f64, disc: f64, distance: f64) -> f64 {
        let strips = 400;
        let width = 2.0 * base / f64::from(strips);
        let area: f64 = (0..strips)
            .map(|i| {
                let x = -base + (f64::from(i) + 0.5) * width;
                let of_base = base * base - x * x;
                let of_disc = disc * disc - (x - distance).powi(2);
                2.0 * width * of_base.min(of_disc).max(0.0).sqrt()
            })
            .sum();
        area / (std::f64::consts::PI * base * base)
    }

    #[test]
    fn an_ellipse_has_the_discs_area_and_its_longer_axis_where_it_is_told() {
        for (elongation, skew) in [(0.4, 0.0), (-0.3, 0.0), (0.2, 0.25), (0.0, -0.5)] {
            let given = [
                ("center_x", 0.4),
                ("center_y", -0.1),
                ("radius", 0.1),
                ("elongation", elongation),
                ("skew", skew),
            ];
            let added = AddedEffect::fixed("friction_patch", &given);
            let edge = patch_edge(&values(&added).expect("valid values"));
            let centre = Point::new(0.4, -0.1);
            let twice_area: f64 = edge
                .windows(2)
                .map(|pair| {
                    let [from, to] = [pair[0] - centre, pair[1] - centre];
                    from.x * to.y - from.y * to.x
                })
                .sum();
            assert!((0.5 * twice_area / (PI * 0.01) - 1.0).abs() < 0.01);
            let farthest = edge.iter().map(|at| *at - centre);
            let farthest = farthest.max_by(|a, b| a.norm().total_cmp(&b.norm()));
            let farthest = farthest.expect("an edge has points");
            let size = f64::hypot(elongation, skew);
            assert!((farthest.norm() / (0.1 * size.exp()) - 1.0).abs() < 0.01);
            let turned = 2.0 * (farthest.bearing() - 0.5 * skew.atan2(elongation));
            assert!(turned.cos() > 0.99, "{elongation} {skew}");
        }
    }

    #[test]
    fn the_covered_share_is_that_of_the_areas() {
        for (base, disc) in [(0.03, 0.1), (0.03, 0.02), (0.05, 0.05)] {
            for step in 0..40 {
                let distance = 0.005 * f64::from(step);
                let (share, expected) = (
                    covered(base, disc, distance * distance),
                    counted(base, disc, distance),
                );
                assert!(
                    (share - expected).abs() < 1e-3,
                    "{base} {disc} {distance}: {share} {expected}"
                );
            }
        }
    }
}
