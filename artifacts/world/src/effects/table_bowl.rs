//! A table that is hollow or domed: a = −g·K·(p − p₀), K = κ·1 for a round bowl.
//!
//! A table that sags more one way than the other, a trough at the extreme, has K = [[κ + d, t], [t, κ − d]].

use values::Point;

use super::{
    Acts, Column, EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters,
    formula::forcing, wording,
};
use crate::GRAVITY;

const fn centre(name: &'static str, neutral: f64) -> EffectParameter {
    EffectParameter::new(name, "m", [-3.0, 3.0], 0.2).neutral_at(neutral)
}

/// Curvature in 1/m below which a bowl is flat along some way, and has no centre there.
const FLAT: f64 = 1e-6;

const fn unequal(name: &'static str) -> EffectParameter {
    EffectParameter::new(name, "1/m", [-0.5, 0.5], 0.03)
}

/// Table bowl; parameters `curvature` = κ, the mean (negative: a dome), `stretch` = d: by how much it is more along x and less along
/// y, `twist` = t: the same towards the diagonal, and `center_x`, `center_y` = p₀.
pub const SPEC: EffectSpec = EffectSpec {
    name: "table_bowl",
    parameters: Parameters::Listed(&[
        EffectParameter::new("curvature", "1/m", [-0.3, 0.5], 0.03),
        unequal("stretch"),
        unequal("twist"),
        centre("center_x", 0.5),
        centre("center_y", 0.0),
    ]),
    family: Family::ForceByPlace,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    naming: Naming::Ordinary,
    source: "weight on a paraboloid of height (p − p₀)ᵀK(p − p₀)/2, its slope small: the second order of any smooth table",
    starts: |experiment| {
        let at = |x: f64, y: f64, name: &str| {
            Column::new(&[("center_x", x), ("center_y", y)], (name, 0.02))
        };
        let round = [(0.0, 0.0), (0.5, 0.0), (0.0, 0.5)].map(|(x, y)| at(x, y, "curvature"));
        let unequal = ["stretch", "twist"].map(|name| at(0.0, 0.0, name));
        let start = |columns: &[&[Column]], free: &[&str]| {
            FitStart::new(columns.concat(), free)
                .about(experiment)
                .combined_by(one_bowl)
        };
        let free = ["curvature", "center_x", "center_y", "stretch", "twist"];
        vec![
            start(&[&round], &free[..3]),
            start(&[&round, &unequal], &free),
        ]
    },
    build: |values, _| {
        let [mean, stretch, twist] =
            ["curvature", "stretch", "twist"].map(|name| GRAVITY * values.get(name));
        // Rows of g·K in 1/s².
        let along_x = Point::new(mean + stretch, twist);
        let along_y = Point::new(twist, mean - stretch);
        let centre = values.centre();
        forcing(Acts::Slide, move |slide| {
            let back = centre - slide.position;
            Point::new(along_x.dot(back), along_y.dot(back))
        })
    },
    statement: |values| {
        let curvature = values.get("curvature");
        let (shape, pull) = if curvature < 0.0 {
            ("domed: it pushes away from", -curvature)
        } else {
            (
                "hollow (a spring or a cable pulls alike): it pulls towards",
                curvature,
            )
        };
        let (stretch, twist) = (values.get("stretch"), values.get("twist"));
        let unequal = stretch.hypot(twist);
        let sideways = if unequal < LEAST_UNEQUAL * pull {
            String::new()
        } else {
            format!(
                " on the mean, by {:.2} m/s² more towards {} from +x and as much less across",
                GRAVITY * unequal,
                wording::degrees(0.5 * twist.atan2(stretch))
            )
        };
        format!(
            "the table is {shape} ({:.2}, {:.2}) m with {:.2} m/s² for every metre from there{sideways}",
            values.get("center_x"),
            values.get("center_y"),
            GRAVITY * pull
        )
    },
};

/// Difference of curvatures over their mean below which a statement calls a bowl round.
const LEAST_UNEQUAL: f64 = 0.02;

/// A sum of paraboloids is one: of round ones wherever they are, and of unequal ones about the origin.
fn one_bowl(start: &FitStart, coefficients: &[f64]) -> Vec<(String, f64)> {
    let heights = |name: &str| {
        let name = name.to_string();
        let all = start.columns.iter().zip(coefficients);
        all.filter(move |(column, _)| column.strength.0 == name)
            .map(|(column, coefficient)| (column, coefficient * column.strength.1))
    };
    let total = |name: &str| heights(name).map(|(_, height)| height).sum::<f64>();
    let [mean, stretch, twist] = ["curvature", "stretch", "twist"].map(total);
    let moment = |place: &str| {
        heights("curvature")
            .map(|(column, height)| height * column.form_of(place))
            .sum::<f64>()
    };
    // p₀ = K⁻¹·moment.
    let moment = Point::new(moment("center_x"), moment("center_y"));
    let determinant = mean * mean - stretch * stretch - twist * twist;
    let safe = if determinant.abs() < FLAT * FLAT {
        FLAT * FLAT
    } else {
        determinant
    };
    let centre = Point::new(
        (mean - stretch) * moment.x - twist * moment.y,
        (mean + stretch) * moment.y - twist * moment.x,
    ) * safe.recip();
    [
        ("curvature", mean),
        ("stretch", stretch),
        ("twist", twist),
        ("center_x", centre.x),
        ("center_y", centre.y),
    ]
    .map(|(name, value)| (name.to_string(), value))
    .into()
}

#[cfg(test)]
mod tests {
    use values::Point;

    use super::GRAVITY;
    use crate::effects::tests::{Bench, DRY, START};

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
    fn a_trough_pulls_across_itself_alone() {
        // Its bottom runs at a bearing b: K = κ·nnᵀ, n = (−sin b, cos b).
        let (curvature, b) = (0.16f64, 0.5f64);
        let normal = Point::new(-b.sin(), b.cos());
        let centre = Point::new(0.4, -0.1);
        let trough = [
            ("curvature", 0.5 * curvature),
            ("stretch", -0.5 * curvature * (2.0 * b).cos()),
            ("twist", -0.5 * curvature * (2.0 * b).sin()),
            ("center_x", centre.x),
            ("center_y", centre.y),
        ];
        let slid = Bench::with("table_bowl", &trough).slide(0.8, 0.0);
        slid.assert_integrates(|position, _| {
            normal * (-GRAVITY * curvature * normal.dot(position - centre))
        });
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
