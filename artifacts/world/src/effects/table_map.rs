//! A table whose height varies smoothly, with no other form assumed: a = −g·∇h(p), h bumps on a grid, drawn to none.
//!
//! h is the field of [`field`](super::field), in m.

use values::Point;

use super::{
    EffectParameter, EffectSpec, Family, Naming, Origin, Parameters, field::Nodes,
    formula::forcing_within, wording,
};
use crate::GRAVITY;

const NODES: Nodes = Nodes {
    // On 0.8 m by 1 m nodes are 9 cm apart: waves of 25 cm are followed to a fifth of their slope.
    count: 120,
    // Boards warp and sag by some millimetres over a length like this: slopes of 1 to 3 %.
    height: EffectParameter::new("height", "m", [-0.2, 0.2], 0.003),
};

/// Table map; parameters are those of a field, its heights in m.
pub const SPEC: EffectSpec = EffectSpec {
    name: "table_map",
    parameters: Parameters::Listed(&NODES.parameters::<124>()),
    family: Family::ForceByPlace,
    origin: Origin::Table,
    equivalent: &[],
    contains: &["table_tilt", "table_bowl"],
    naming: Naming::InPlace,
    source: "weight on a surface of any shape, its slope small; Gaussian radial basis with a ridge",
    starts: |experiment| NODES.starts(experiment, 0.0005),
    build: |values, _| {
        let map = NODES.field(values);
        let stretch = map.stretch();
        forcing_within(
            move |slide| map.at(slide.position).1 * -GRAVITY,
            move |_| stretch,
        )
    },
    statement: |values| {
        let map = NODES.field(values);
        let slopes = map.places().map(|place| (place, map.at(place).1 * -1.0));
        let none = (Point::default(), Point::default());
        let (place, down) = slopes
            .max_by(|a, b| a.1.norm().total_cmp(&b.1.norm()))
            .unwrap_or(none);
        format!(
            "objects move as on a table whose height varies, steepest around ({:.2}, {:.2}) m, down by {:.1} mm per metre towards {} from +x; \
             a magnet, or a lens of another form than was fitted, looks alike: measure the table's height there, look below it, calibrate the \
             camera, and log again",
            place.x,
            place.y,
            1000.0 * down.norm(),
            wording::degrees(down.bearing())
        )
    },
};

#[cfg(test)]
mod tests {
    use values::Point;

    use super::GRAVITY;
    use crate::effects::tests::Bench;

    #[test]
    fn the_slide_follows_its_formula() {
        let map = [
            ("low_x", 0.1),
            ("high_x", 1.2),
            ("low_y", -0.45),
            ("high_y", 0.45),
            ("node_35", 0.003),
            ("node_54", -0.002),
        ];
        let slid = Bench::with("table_map", &map).slide(0.9, 0.1);
        slid.assert_integrates(|position, _| {
            // Downhill of h·exp(−r²/2w²) is h·r/w²·exp(−r²/2w²).
            let width = 0.8 * 0.1;
            let downhill = |height: f64, x: f64, y: f64| {
                let apart = position - Point::new(x, y);
                let bump = height * (-0.5 * apart.dot(apart) / (width * width)).exp();
                apart * (GRAVITY * bump / (width * width))
            };
            downhill(0.003, 0.4, 0.05) + downhill(-0.002, 0.6, -0.05)
        });
    }
}
