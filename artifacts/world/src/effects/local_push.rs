//! A push to one side about one place: a jet of air, a draught past an edge, a plate under the cloth that slopes.

use values::Point;

use super::{
    EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters, Slide,
    formula::forcing_within, parameters::middle, wording,
};

const fn push(name: &'static str) -> EffectParameter {
    EffectParameter::new(name, "m/s²", [-5.0, 5.0], 0.05)
}

/// Width in m of the cells on which pushes are tried, and how far they reach.
const CELL: f64 = 0.1;
const REACHES: [f64; 2] = [0.08, 0.2];

/// Local push; parameters `center_x`, `center_y`; `reach`: the distance at which 0.61 of it is left; `push_x`, `push_y`: acceleration at the centre.
pub const SPEC: EffectSpec = EffectSpec {
    name: "local_push",
    parameters: Parameters::Listed(&[
        middle("center_x", 0.5),
        middle("center_y", 0.0),
        EffectParameter::new("reach", "m", [0.03, 0.3], 0.05).neutral_at(0.1),
        push("push_x"),
        push("push_y"),
    ]),
    family: Family::ForceByPlace,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    // No height of a table pushes one way and not back: a table of any shape that does no more is not named either.
    naming: Naming::Never,
    source: "momentum of a jet of air on an object within its width",
    starts: |experiment| {
        FitStart::at_places(
            experiment,
            CELL,
            &REACHES,
            &[("push_x", 0.02), ("push_y", 0.02)],
        )
    },
    build: |values, _| {
        let (centre, reach) = (values.centre(), values.get("reach"));
        let push = Point::new(values.get("push_x"), values.get("push_y"));
        let acceleration = move |slide: &Slide<'_>| {
            let apart = slide.position - centre;
            push * (-0.5 * apart.dot(apart) / (reach * reach)).exp()
        };
        forcing_within(acceleration, move |_| 0.5 * reach)
    },
    statement: |values| {
        let push = Point::new(values.get("push_x"), values.get("push_y"));
        format!(
            "something pushes objects towards {} from +x, by {:.2} m/s² at ({:.2}, {:.2}) m and less from some {:.0} cm on, as air that blows there \
             or a plate that slopes does: look there, and log again without it",
            wording::degrees(push.bearing()),
            push.norm(),
            values.get("center_x"),
            values.get("center_y"),
            100.0 * values.get("reach"),
        )
    },
};

#[cfg(test)]
mod tests {
    use values::Point;

    use crate::effects::tests::Bench;

    #[test]
    fn the_slide_follows_its_formula() {
        let (centre, reach, push) = (Point::new(0.45, 0.12), 0.1, Point::new(0.1, -0.3));
        let slid = Bench::with(
            "local_push",
            &[
                ("center_x", centre.x),
                ("center_y", centre.y),
                ("reach", reach),
                ("push_x", push.x),
                ("push_y", push.y),
            ],
        )
        .slide(0.9, 0.1);
        slid.assert_integrates(|position, _| {
            let apart = position - centre;
            push * (-apart.dot(apart) / (2.0 * reach * reach)).exp()
        });
    }
}
