//! A push round about a place, as of air that turns there: a = ω·z×(p − c). No table pushes so, whatever its shape, for no height has a curl.

use values::Point;

use super::{
    Acts, Column, EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters,
    formula::forcing, parameters::middle, wording,
};

/// Rate in 1/s² below which there is no centre.
const STILL: f64 = 1e-6;

/// Air whirl; parameters `rate` = ω: to the left about the centre, for each metre from it; `center_x`, `center_y` = c.
pub const SPEC: EffectSpec = EffectSpec {
    name: "air_whirl",
    parameters: Parameters::Listed(&[
        EffectParameter::new("rate", "1/s²", [-10.0, 10.0], 0.3),
        middle("center_x", 0.5),
        middle("center_y", 0.0),
    ]),
    family: Family::ForceByPlace,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    naming: Naming::Never,
    source: "drag of air that turns as a whole, at speeds far above the object's; the part of a linear field of force that has a curl",
    starts: |experiment| {
        let at =
            |(x, y): (f64, f64)| Column::new(&[("center_x", x), ("center_y", y)], ("rate", 0.1));
        let columns = [(0.0, 0.0), (0.5, 0.0), (0.0, 0.5)].map(at);
        let start = FitStart::new(columns.into(), &["rate", "center_x", "center_y"]);
        vec![start.about(experiment).combined_by(one_whirl)]
    },
    build: |values, _| {
        let (rate, centre) = (values.get("rate"), values.centre());
        forcing(Acts::Slide, move |slide| {
            let arm = slide.position - centre;
            Point::new(-arm.y, arm.x) * rate
        })
    },
    statement: |values| {
        let rate = values.get("rate");
        format!(
            "something pushes objects round about ({:.2}, {:.2}) m, to the {}, by {:.2} m/s² for every metre from there, as air that turns does and no \
             table: look for a fan or an outlet of air, and log again without it",
            values.get("center_x"),
            values.get("center_y"),
            wording::side(rate),
            rate.abs(),
        )
    },
};

/// A sum of whirls is one: of all their rates, about their weighted centre.
fn one_whirl(start: &FitStart, coefficients: &[f64]) -> Vec<(String, f64)> {
    let (mut rate, mut moment) = (0.0, Point::default());
    for (column, coefficient) in start.columns.iter().zip(coefficients) {
        let own = coefficient * column.strength.1;
        rate += own;
        moment = moment + Point::new(column.form_of("center_x"), column.form_of("center_y")) * own;
    }
    let safe = if rate.abs() < STILL { STILL } else { rate };
    let centre = moment * safe.recip();
    [
        ("rate", rate),
        ("center_x", centre.x),
        ("center_y", centre.y),
    ]
    .map(|(name, value)| (name.to_string(), value))
    .into()
}

#[cfg(test)]
mod tests {
    use values::Point;

    use super::{SPEC, one_whirl};
    use crate::effects::{Experiment, tests::Bench};

    #[test]
    fn the_slide_follows_its_formula() {
        let (centre, rate) = (Point::new(0.45, -0.1), 0.8);
        let slid = Bench::with(
            "air_whirl",
            &[
                ("rate", rate),
                ("center_x", centre.x),
                ("center_y", centre.y),
            ],
        )
        .slide(0.9, 0.1);
        slid.assert_integrates(|position, _| {
            let arm = position - centre;
            Point::new(-arm.y, arm.x) * rate
        });
    }

    #[test]
    fn whirls_add_up_to_one() {
        let rig = values::Rig::demo(values::Shape::Cylinder);
        let experiment = Experiment {
            rig: &rig,
            strikes: &[],
        };
        let start = &(SPEC.starts)(&experiment)[0];
        let one = one_whirl(start, &[2.0, 6.0, -3.0]);
        let of = |name: &str| one.iter().find(|(known, _)| known == name).map(|(_, v)| *v);
        assert!((of("rate").expect("given") - 0.5).abs() < 1e-12);
        assert!((of("center_x").expect("given") - 0.6).abs() < 1e-12);
        assert!((of("center_y").expect("given") + 0.3).abs() < 1e-12);
    }
}
