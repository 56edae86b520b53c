//! A table that is hollow or domed: a = −g·κ·(p − p₀).

use values::{Point, Rig};

use super::{
    action::{Acts, Effect, Slide},
    parameters::{EffectParameter, Parameters, Values},
    spec::{EffectSpec, Family},
    start::{Column, FitStart},
};
use crate::GRAVITY;

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

/// Curvature in 1/m below which a bowl is flat, and has no centre.
const FLAT: f64 = 1e-6;

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
    family: Family::ForceByPlace,
    equivalent: &[],
    contains: &[],
    is_last_resort: false,
    source: "weight on a paraboloid of height κ·|p − p₀|²/2, its slope small",
    starts: |experiment| {
        let columns = [(0.0, 0.0), (0.5, 0.0), (0.0, 0.5)]
            .iter()
            .map(|(x, y)| Column::new(&[("center_x", *x), ("center_y", *y)], ("curvature", 0.02)))
            .collect();
        let free = &["curvature", "center_x", "center_y"];
        vec![
            FitStart::new(columns, free)
                .about(experiment)
                .combined_by(one_bowl),
        ]
    },
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

/// A sum of paraboloids is one.
fn one_bowl(start: &FitStart, coefficients: &[f64]) -> Vec<(String, f64)> {
    let columns = || start.columns.iter().zip(coefficients);
    let total: f64 = columns()
        .map(|(column, coefficient)| coefficient * column.strength.1)
        .sum();
    let safe = if total.abs() < FLAT { FLAT } else { total };
    let mut parameters = vec![("curvature".into(), total)];
    for place in ["center_x", "center_y"] {
        let moment: f64 = columns()
            .map(|(column, coefficient)| {
                let at = column.form.iter().find(|(name, _)| name == place);
                coefficient * column.strength.1 * at.map_or(0.0, |(_, value)| *value)
            })
            .sum();
        parameters.push((place.into(), moment / safe));
    }
    parameters
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
