//! A lens that bends the picture: seen = c + (p − c)·(1 + k₁·r² + k₂·r⁴), r the distance from the point c it looks down on.

use super::{
    Column, EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters,
    formula::seeing, parameters::centre, wording,
};

/// Distance in m from the camera's centre at which the distortion is stated.
const STATED_AT: f64 = 0.5;

/// Camera distortion; parameters `k1` = k₁ and `k2` = k₂, in metres of the table, and `center_x`, `center_y` = c (the rig's
/// camera where they are not given). A wide lens, as a fisheye is, needs k₂: k₁ alone folds its picture.
pub const SPEC: EffectSpec = EffectSpec {
    name: "camera_distortion",
    parameters: Parameters::Listed(&[
        EffectParameter::new("k1", "1/m²", [-3.0, 3.0], 0.05),
        EffectParameter::new("k2", "1/m⁴", [-20.0, 20.0], 0.2),
        centre("center_x", 0.45),
        centre("center_y", 0.0),
    ]),
    family: Family::SeenByPlace,
    origin: Origin::Camera,
    equivalent: &[],
    contains: &[],
    naming: Naming::Ordinary,
    source: "radial terms of lens distortion, and of its decentring, which is that of an axis elsewhere (Brown 1971)",
    starts: |experiment| {
        let [x, y] = experiment.camera_centre();
        let looks_down_on =
            |dx: f64, dy: f64| Column::new(&[(x.0, x.1 + dx), (y.0, y.1 + dy)], ("k1", 0.02));
        let off_centre = [(0.0, 0.0), (ASIDE, 0.0), (0.0, ASIDE)];
        let off_centre = off_centre.map(|(dx, dy)| looks_down_on(dx, dy)).to_vec();
        let about = |(name, centre): (&'static str, f64)| (name, (centre - MOST, centre + MOST));
        let off_centre = FitStart::new(off_centre, &["k1", x.0, y.0]).combined_by(one_lens);
        let off_centre = [x, y]
            .map(about)
            .into_iter()
            .fold(off_centre, |start, (name, range)| {
                start.kept_in(name, range)
            });
        let wide = Column::new(&[], ("k2", 0.1));
        vec![
            FitStart::new(vec![looks_down_on(0.0, 0.0)], &["k1"]),
            FitStart::new(vec![looks_down_on(0.0, 0.0), wide], &["k1", "k2"]),
            off_centre,
        ]
    },
    build: |values, rig| {
        let centre = values.camera_centre(rig);
        let (k1, k2) = (values.get("k1"), values.get("k2"));
        seeing(0.0, move |point| {
            let apart = point - centre;
            let square = apart.dot(apart);
            centre + apart * (1.0 + square * (k1 + square * k2))
        })
    },
    statement: |values| {
        let square = STATED_AT * STATED_AT;
        let share = square * (values.get("k1") + values.get("k2") * square);
        format!(
            "the lens shows what is {STATED_AT} m from its axis at ({:.2}, {:.2}) m {} too {} it",
            values.get("center_x"),
            values.get("center_y"),
            wording::percent(share),
            if share < 0.0 { "near to" } else { "far from" }
        )
    },
};

/// Distance in m from the camera's centre of the lenses from which a fit of one that looks down elsewhere begins, and of such a lens at the most.
const ASIDE: f64 = 0.1;
const MOST: f64 = 0.15;

/// The lens that several about other points make together, to first order in their distances: its axis is their mean, by strength.
fn one_lens(start: &FitStart, coefficients: &[f64]) -> Vec<(String, f64)> {
    let strengths = start.columns.iter().zip(coefficients);
    let strengths = strengths.map(|(column, c)| (column, c * column.strength.1));
    let strengths: Vec<(&Column, f64)> = strengths.collect();
    let k1: f64 = strengths.iter().map(|(_, k1)| k1).sum();
    let axis = |name: &str| {
        let at = |column: &Column| column.form_of(name);
        let stated = strengths.first().map_or(0.0, |(column, _)| at(column));
        let moment: f64 = strengths.iter().map(|(c, k1)| k1 * (at(c) - stated)).sum();
        let aside = if k1.abs() > 1e-6 { moment / k1 } else { 0.0 };
        (name.to_string(), stated + aside.clamp(-MOST, MOST))
    };
    vec![("k1".into(), k1), axis("center_x"), axis("center_y")]
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::{Bench, START, assert_near};

    #[test]
    fn the_seen_stop_follows_its_formula_from_where_the_object_is() {
        for (k1, k2) in [(-0.3, 0.0), (0.3, 0.0), (-1.2, 2.0)] {
            let bench = Bench::with("camera_distortion", &[("k1", k1), ("k2", k2)]);
            let centre = bench.rig.camera.centre;
            let seen_at = |r: f64| r * (1.0 + r * r * (k1 + k2 * r * r));
            // The radius of the true start.
            let seen = START - centre;
            let (mut low, mut high) = (0.0, 2.0 * seen.norm());
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if seen_at(middle) < seen.norm() {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            let start = centre + seen * (low / seen.norm());
            let plain = Bench::plain().strike(0.8, 0.2);
            let stop = start + (plain.stop - START) - centre;
            let expected = centre + stop * (seen_at(stop.norm()) / stop.norm());
            assert_near(bench.strike(0.8, 0.2).stop, expected, 1e-6);
        }
    }
}
