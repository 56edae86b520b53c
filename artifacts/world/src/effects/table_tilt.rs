//! A table that is not level: a = g·(sin t_x, sin t_y).

use values::Point;

use super::{
    Acts, Column, EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters,
    formula::forcing, wording,
};
use crate::GRAVITY;

const fn tilt(name: &'static str) -> EffectParameter {
    EffectParameter::new(name, "rad", [-0.3, 0.3], 0.005)
}

/// Table tilt; parameters `tilt_x`, `tilt_y`: the slope down along +x and +y.
pub const SPEC: EffectSpec = EffectSpec {
    name: "table_tilt",
    parameters: Parameters::Listed(&[tilt("tilt_x"), tilt("tilt_y")]),
    family: Family::ForceByPlace,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    naming: Naming::Ordinary,
    source: "weight on an inclined plane",
    starts: |_| {
        let column = |name| Column::new(&[], (name, 0.002));
        let columns = vec![column("tilt_x"), column("tilt_y")];
        vec![FitStart::new(columns, &["tilt_x", "tilt_y"])]
    },
    build: |values, _| {
        let [x, y] = ["tilt_x", "tilt_y"].map(|name| values.get(name).sin());
        let acceleration = Point::new(x, y) * GRAVITY;
        forcing(Acts::Strike, move |_| acceleration)
    },
    statement: |values| {
        let down = Point::new(values.get("tilt_x"), values.get("tilt_y"));
        format!(
            "the table slopes down by {:.1} mm per metre towards {} from +x",
            1000.0 * down.norm(),
            wording::degrees(down.bearing())
        )
    },
};

#[cfg(test)]
mod tests {
    use values::Point;

    use super::GRAVITY;
    use crate::effects::tests::{Bench, DRY};

    #[test]
    fn downhill_goes_further_by_its_formula() {
        let tilt: f64 = 0.01;
        let slid = Bench::with("table_tilt", &[("tilt_x", tilt)]).slide(0.9, 0.0);
        slid.assert_distance(slid.speed().powi(2) / (2.0 * (DRY - GRAVITY * tilt.sin())));
    }

    #[test]
    fn a_slope_across_turns_the_slide_by_its_formula() {
        let tilt: f64 = 0.02;
        let slid = Bench::with("table_tilt", &[("tilt_y", tilt)]).slide(0.9, 0.2);
        slid.assert_integrates(|_, _| Point::new(0.0, GRAVITY * tilt.sin()));
    }
}
