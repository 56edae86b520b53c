//! Friction that varies smoothly over the table, with no other form assumed: bumps on a grid, their heights drawn to none.
//!
//! μ(p) = μ·(1 + f(p)), f the field of [`field`](super::field).

use values::Point;

use super::{
    EffectParameter, EffectSpec, Family, Naming, Origin, Parameters,
    field::{Field, Nodes},
    formula::braking_within,
    friction_step::SMALL,
    wording,
};

const NODES: Nodes = Nodes {
    count: 48,
    // Friction of real tables varies by 10 to 20 %.
    height: EffectParameter::new("height", "", [-0.9, 3.0], 0.15),
};
/// Least factor on friction: however deep bumps add up, this share of friction is left.
const LEAST_FACTOR: f64 = 0.05;

/// Friction map; parameters are those of a field, its heights relative to friction.
pub const SPEC: EffectSpec = EffectSpec {
    name: "friction_map",
    parameters: Parameters::Listed(&NODES.parameters::<52>()),
    family: Family::FrictionByPlace,
    origin: Origin::Table,
    equivalent: &[],
    contains: &["friction_patch", "friction_gradient", "friction_step"],
    naming: Naming::LastResort,
    source: "friction varies over a table (Yu et al. 2016; Ma and Rodriguez 2018); Gaussian radial basis with a ridge",
    starts: |experiment| NODES.starts(experiment, SMALL),
    build: |values, _| {
        let map = NODES.field(values);
        let stretch = map.stretch();
        braking_within(move |slide| factor(&map, slide.position), move |_| stretch)
    },
    statement: |values| {
        let map = NODES.field(values);
        let factors = || map.places().map(|place| (place, factor(&map, place)));
        let nearest_one = (Point::default(), 1.0);
        let least = factors()
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or(nearest_one);
        let most = factors()
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or(nearest_one);
        let described = |(place, factor): (Point, f64)| {
            let change = wording::higher(factor - 1.0);
            format!("{change} around ({:.2}, {:.2}) m", place.x, place.y)
        };
        format!(
            "friction varies over the table: {}, {}",
            described(most),
            described(least)
        )
    },
};

fn factor(map: &Field, position: Point) -> f64 {
    (1.0 + map.at(position).0).max(LEAST_FACTOR)
}

#[cfg(test)]
mod tests {
    use values::Point;

    use crate::effects::tests::{Bench, DRY};

    #[test]
    fn the_stop_follows_its_formula() {
        let map = [
            ("low_x", 0.3),
            ("high_x", 1.0),
            ("low_y", -0.25),
            ("high_y", 0.25),
            ("node_9", 0.4),
            ("node_14", -0.2),
        ];
        let slid = Bench::with("friction_map", &map).slide(0.9, 0.1);
        slid.assert_integrates(|position, velocity| {
            let bump = |x: f64, y: f64| {
                let apart = position - Point::new(x, y);
                let width = 0.8 * 0.1;
                (-0.5 * apart.dot(apart) / (width * width)).exp()
            };
            let more = 0.4 * bump(0.4, 0.05) - 0.2 * bump(0.5, -0.05);
            velocity * (-DRY * more / velocity.norm())
        });
    }
}
