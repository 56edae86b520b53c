//! A pull towards one place, or a push away from it: a magnet below the table, a single dent or swelling.

use super::{
    EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters, Slide,
    formula::forcing_within, parameters::middle,
};

/// Width in m of the cells on which pulls are tried, and how far they reach.
const CELL: f64 = 0.08;
const REACHES: [f64; 2] = [0.06, 0.15];

/// Local pull; parameters `center_x`, `center_y`; `reach`: at half of it the pull is greatest, nearly; `pull`: of the acceleration near the
/// centre over the distance from there.
pub const SPEC: EffectSpec = EffectSpec {
    name: "local_pull",
    parameters: Parameters::Listed(&[
        middle("center_x", 0.5),
        middle("center_y", 0.0),
        EffectParameter::new("reach", "m", [0.02, 0.4], 0.05).neutral_at(0.1),
        EffectParameter::new("pull", "1/s²", [-200.0, 200.0], 3.0),
    ]),
    family: Family::ForceByPlace,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    // It belongs to no table: a table of any shape that does no more is not named either.
    naming: Naming::Never,
    source: "force on a small magnetic body beside a dipole at some depth, between that on soft iron and that on a magnet",
    starts: |experiment| FitStart::at_places(experiment, CELL, &REACHES, &[("pull", 0.5)]),
    build: |values, _| {
        let (centre, reach, pull) = (values.centre(), values.get("reach"), values.get("pull"));
        let acceleration = move |slide: &Slide<'_>| {
            let apart = slide.position - centre;
            apart * (-pull * falls(apart.dot(apart) / (reach * reach)))
        };
        forcing_within(acceleration, move |_| 0.5 * reach)
    },
    statement: |values| {
        let (pull, reach) = (values.get("pull"), values.get("reach"));
        format!(
            "something {} ({:.2}, {:.2}) m, by up to {:.2} m/s² some {:.0} cm from there, as a magnet below the table or a single {} does: look \
             there, and log again without it",
            if pull < 0.0 {
                "pushes objects away from"
            } else {
                "pulls objects towards"
            },
            values.get("center_x"),
            values.get("center_y"),
            pull.abs() * reach * STEEPEST * falls(STEEPEST * STEEPEST),
            100.0 * STEEPEST * reach,
            if pull < 0.0 { "swelling" } else { "dent" },
        )
    },
};

/// Distance at which the pull is greatest, in reaches: 1/√5.
const STEEPEST: f64 = 0.447_213_595_499_957_9;

/// Factor on the pull at a squared distance, in squared reaches.
fn falls(square: f64) -> f64 {
    (1.0 + square).powi(-3)
}

#[cfg(test)]
mod tests {
    use values::Point;

    use crate::effects::tests::Bench;

    #[test]
    fn the_slide_follows_its_formula() {
        let (centre, reach, pull) = (Point::new(0.45, 0.12), 0.1, 6.0);
        let slid = Bench::with(
            "local_pull",
            &[
                ("center_x", centre.x),
                ("center_y", centre.y),
                ("reach", reach),
                ("pull", pull),
            ],
        )
        .slide(0.9, 0.1);
        slid.assert_integrates(|position, _| {
            let apart = position - centre;
            apart * (-pull / (1.0 + apart.dot(apart) / (reach * reach)).powi(3))
        });
    }
}
