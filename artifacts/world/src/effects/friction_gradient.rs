//! Friction that changes linearly over the table: μ(p) = μ·(1 + g·(p − c)).

use values::Point;

use super::{
    Acts, Column, EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters,
    formula::braking, parameters::centre, wording,
};

/// Least factor on friction: however far a falling gradient goes on, this share of friction is left.
const LEAST_FACTOR: f64 = 0.05;

const fn along(name: &'static str) -> EffectParameter {
    EffectParameter::new(name, "1/m", [-3.0, 3.0], 0.2)
}

/// Friction gradient; parameters `gradient_x`, `gradient_y` = g, and `center_x`, `center_y` = c, where friction is the
/// world's: the middle of the strikes that were fitted.
pub const SPEC: EffectSpec = EffectSpec {
    name: "friction_gradient",
    parameters: Parameters::Listed(&[
        along("gradient_x"),
        along("gradient_y"),
        centre("center_x", 0.5),
        centre("center_y", 0.0),
    ]),
    family: Family::FrictionByPlace,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    naming: Naming::Ordinary,
    source: "friction varies over a table (Yu et al. 2016; Ma and Rodriguez 2018), to first order",
    starts: |experiment| {
        let [x, y] = experiment.extent();
        let centre = [
            ("center_x", 0.5 * (x.0 + x.1)),
            ("center_y", 0.5 * (y.0 + y.1)),
        ];
        let names = ["gradient_x", "gradient_y"];
        let columns = names.map(|name| Column::new(&centre, (name, 0.05)));
        vec![FitStart::new(columns.into(), &names)]
    },
    build: |values, _| {
        let gradient = Point::new(values.get("gradient_x"), values.get("gradient_y"));
        let centre = values.centre();
        braking(Acts::Slide, move |slide| {
            (1.0 + gradient.dot(slide.position - centre)).max(LEAST_FACTOR)
        })
    },
    statement: |values| {
        let gradient = Point::new(values.get("gradient_x"), values.get("gradient_y"));
        format!(
            "friction rises by {} per metre towards {} from +x",
            wording::percent(gradient.norm()),
            wording::degrees(gradient.bearing())
        )
    },
};

#[cfg(test)]
mod tests {
    use values::Point;

    use crate::effects::tests::{Bench, DRY};

    #[test]
    fn the_stop_follows_its_formula() {
        let gradient = Point::new(0.6, -0.8);
        let parameters = [
            ("gradient_x", gradient.x),
            ("gradient_y", gradient.y),
            ("center_x", 0.4),
        ];
        let slid = Bench::with("friction_gradient", &parameters).slide(0.9, 0.2);
        slid.assert_integrates(|position, velocity| {
            let more = gradient.dot(position - Point::new(0.4, 0.0));
            velocity * (-DRY * more / velocity.norm())
        });
    }
}
