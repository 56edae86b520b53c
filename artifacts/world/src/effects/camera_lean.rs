//! A camera that does not look straight down: seen = c + S·(p − c)/(1 + l·(p − c)), c the point it looks down on.
//!
//! S foreshortens lengths along the lean: by cos α where the camera leans by α, sin α = |l|·h at a height h over the table.

use values::Point;

use super::{
    Column, EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters,
    formula::seeing, parameters::centre, wording,
};

/// Scale beyond which a picture shows no table: what lies there is as good as at the horizon.
const LEAST_SCALE: f64 = 0.2;

const fn lean(name: &'static str) -> EffectParameter {
    EffectParameter::new(name, "1/m", [-0.8, 0.8], 0.04)
}

/// sin α of a camera that sees the table edge-on, or nearly so.
const STEEPEST: f64 = 0.95;

/// Camera lean; parameters `lean_x`, `lean_y` = l, `height` = h along the camera's axis (0: lengths are not foreshortened), and
/// `center_x`, `center_y` = c (the rig's camera where they are not given).
pub const SPEC: EffectSpec = EffectSpec {
    name: "camera_lean",
    parameters: Parameters::Listed(&[
        lean("lean_x"),
        lean("lean_y"),
        EffectParameter::new("height", "m", [0.0, 5.0], 0.5),
        centre("center_x", 0.45),
        centre("center_y", 0.0),
    ]),
    family: Family::SeenByPlace,
    origin: Origin::Camera,
    equivalent: &[],
    contains: &[],
    naming: Naming::Ordinary,
    source: "perspective of a plane that is not parallel to the image (keystone, foreshortening): a camera h from the table that leans by α has l = sin α/h",
    starts: |experiment| {
        let [x, y] = experiment.camera_centre();
        let leaning = |height, free: &[&str]| {
            let form = [x, y, ("height", height)];
            let columns = ["lean_x", "lean_y"].map(|name| Column::new(&form, (name, 0.01)));
            FitStart::new(columns.into(), free)
        };
        vec![
            leaning(0.0, &["lean_x", "lean_y"]),
            leaning(USUAL_HEIGHT, &["lean_x", "lean_y", "height"]),
        ]
    },
    build: |values, rig| {
        let centre = values.camera_centre(rig);
        let lean = Point::new(values.get("lean_x"), values.get("lean_y"));
        let sine = (lean.norm() * values.get("height")).min(STEEPEST);
        // Factor by which S changes a length along the lean, less one, over |l|²: (cos α − 1)/|l|², with a limit where nothing leans.
        let shorter = match lean.dot(lean) {
            0.0 => 0.0,
            square => ((1.0 - sine * sine).sqrt() - 1.0) / square,
        };
        seeing(0.0, move |point| {
            let apart = point - centre;
            let along = lean.dot(apart);
            let foreshortened = apart + lean * (shorter * along);
            centre + foreshortened * (1.0 + along).max(LEAST_SCALE).recip()
        })
    },
    statement: |values| {
        let lean = Point::new(values.get("lean_x"), values.get("lean_y"));
        format!(
            "the camera leans: it shows lengths {:.1} % smaller for every metre towards {} from +x",
            100.0 * lean.norm(),
            wording::degrees(lean.bearing())
        )
    },
};

/// Height in m at which a camera over a table hangs, roughly: where fits begin.
const USUAL_HEIGHT: f64 = 1.0;

#[cfg(test)]
mod tests {
    use values::Point;

    use crate::effects::tests::{Bench, START, assert_near};

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
    fn from_a_height_lengths_along_the_lean_are_foreshortened() {
        let lean = 0.2;
        let height = 1.1;
        let bench = Bench::with("camera_lean", &[("lean_x", lean), ("height", height)]);
        let centre = bench.rig.camera.centre;
        let cosine = (1.0 - (lean * height).powi(2)).sqrt();
        let see = |at: Point| {
            let apart = at - centre;
            let depth = 1.0 + lean * apart.x;
            centre + Point::new(cosine * apart.x, apart.y) * depth.recip()
        };
        // Turned round for the start, which is seen, too.
        let seen = START - centre;
        let x = seen.x / (cosine - lean * seen.x);
        let start = centre + Point::new(x, seen.y * (1.0 + lean * x));
        let plain = Bench::plain().strike(0.8, 0.2);
        let expected = see(start + (plain.stop - START));
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
