//! A table that is hollow or domed: a = −g·κ·(p − p₀).

use values::{Point, Rig};

use super::{Acts, Effect, EffectParameter, EffectSpec, GRAVITY, Parameters, Slide, Values};

const fn centre(name: &'static str, neutral: f64) -> EffectParameter {
    EffectParameter {
        name,
        unit: "m",
        low: -3.0,
        high: 3.0,
        neutral,
        scale: 0.2,
    }
}

/// Table bowl; parameters `curvature` = κ (negative: a dome) and `center_x`, `center_y` = p₀.
pub const SPEC: EffectSpec = EffectSpec {
    name: "table_bowl",
    parameters: Parameters::Listed(&[
        EffectParameter {
            name: "curvature",
            unit: "1/m",
            low: -0.3,
            high: 0.5,
            neutral: 0.0,
            scale: 0.03,
        },
        centre("center_x", 0.5),
        centre("center_y", 0.0),
    ]),
    equivalent: &[],
    source: "weight on a paraboloid of height κ·|p − p₀|²/2, its slope small",
    build: |values: &Values, _: &Rig| {
        Box::new(TableBowl {
            stiffness: GRAVITY * values.get("curvature"),
            centre: Point::new(values.get("center_x"), values.get("center_y")),
        })
    },
    statement: |values| {
        let curvature = values.get("curvature");
        let (shape, pull) = if curvature < 0.0 {
            ("domed: it pushes away from", -curvature)
        } else {
            ("hollow: it pulls towards", curvature)
        };
        format!(
            "the table is {shape} ({:.2}, {:.2}) m with {:.2} m/s² for every metre from there",
            values.get("center_x"),
            values.get("center_y"),
            GRAVITY * pull
        )
    },
};

struct TableBowl {
    /// g·κ in 1/s².
    stiffness: f64,
    centre: Point,
}

impl Effect for TableBowl {
    fn acts(&self) -> Acts {
        Acts::Slide
    }

    fn acceleration(&self, slide: &Slide<'_>) -> Point {
        (self.centre - slide.position) * self.stiffness
    }
}

#[cfg(test)]
mod tests {
    use values::Point;

    use super::GRAVITY;
    use crate::effects::tests::{Bench, DRY, START};

    #[test]
    fn it_changes_the_track() {
        let bowl = [("curvature", 0.03), ("center_y", -0.2)];
        Bench::with("table_bowl", &bowl).assert_changes_track();
    }

    #[test]
    fn the_stop_follows_its_formula() {
        // Along the line through the centre u = x − x₀ + a/ω², ω² = g·κ, swings freely: u² + u'²/ω² stays.
        let (curvature, centre) = (0.2, 0.4);
        let bowl = [
            ("curvature", curvature),
            ("center_x", centre),
            ("center_y", START.y),
        ];
        let slid = Bench::with("table_bowl", &bowl).slide(0.9, 0.0);
        let stiffness = GRAVITY * curvature;
        let u = slid.from.x - centre + DRY / stiffness;
        slid.assert_distance(u.hypot(slid.speed() / stiffness.sqrt()) - u);
    }

    #[test]
    fn it_pulls_aside_by_its_formula() {
        let (curvature, centre) = (-0.1, Point::new(0.4, -0.3));
        let dome = [
            ("curvature", curvature),
            ("center_x", centre.x),
            ("center_y", centre.y),
        ];
        let slid = Bench::with("table_bowl", &dome).slide(0.8, 0.0);
        slid.assert_integrates(|position, _| (centre - position) * (GRAVITY * curvature));
    }
}
