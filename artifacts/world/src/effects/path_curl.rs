//! A path that curls: a force across the way, of which one part is friction's and one grows with speed.
//!
//! An object that spins or leans on one edge is pushed aside by a part of friction, one that spins in air by its speed (Magnus).

use values::Point;

use super::{
    Acts, Column, EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters,
    formula::forcing, wording,
};

/// Speed in m/s below which the way has no direction.
const STILL: f64 = 1e-6;

/// Path curl; parameters `part`: force to the left of the way over that of friction; `rate`: acceleration to the left over the speed.
pub const SPEC: EffectSpec = EffectSpec {
    name: "path_curl",
    parameters: Parameters::Listed(&[
        EffectParameter::new("part", "", [-1.0, 1.0], 0.05),
        EffectParameter::new("rate", "1/s", [-5.0, 5.0], 0.1),
    ]),
    family: Family::FrictionByHeading,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    naming: Naming::Never,
    source: "sideways friction of an object that turns or tips while it slides (Penner 2001, on curling stones), at its simplest; lift of a body \
             that spins in a fluid (Magnus), in proportion to its speed",
    starts: |experiment| {
        // Along one way a slope and a grain push across it, too.
        if experiment.is_one_way() {
            return Vec::new();
        }
        let strengths = [("part", 0.01), ("rate", 0.01)];
        let both = strengths.map(|strength| Column::new(&[], strength));
        let each = strengths.into_iter().flat_map(FitStart::linear);
        let both = FitStart::new(both.into(), &["part", "rate"]);
        each.chain([both]).collect()
    },
    build: |values, _| {
        let (part, rate) = (values.get("part"), values.get("rate"));
        forcing(Acts::Slide, move |slide| {
            let speed = slide.velocity.norm();
            if speed < STILL {
                return Point::default();
            }
            let left = Point::new(-slide.velocity.y, slide.velocity.x) * speed.recip();
            left * (part * slide.dry + rate * speed)
        })
    },
    statement: |values| {
        let (part, rate) = (values.get("part"), values.get("rate"));
        let friction = format!("{} of friction's", wording::percent(part));
        let speed = format!("{:.2} m/s² for every m/s", rate.abs());
        let (left, force) = match (part == 0.0, rate == 0.0) {
            (false, false) if part * rate < 0.0 => {
                (part, format!("{friction}, less {speed} of speed"))
            }
            (false, false) => (part, format!("{friction} and {speed} of speed")),
            (true, _) => (rate, format!("{speed} of speed")),
            (_, true) => (part, friction),
        };
        format!(
            "paths curl to the {}, by a force across the way of {force}: an object that spins or stands on one edge does so; look at its \
             base, and at whether the tip strikes its middle",
            wording::side(left),
        )
    },
};

#[cfg(test)]
mod tests {
    use values::Point;

    use crate::effects::tests::{Bench, DRY};

    #[test]
    fn the_stop_follows_its_formula() {
        let slid = Bench::with("path_curl", &[("part", 0.1), ("rate", -0.2)]).slide(0.9, 0.1);
        slid.assert_integrates(|_, velocity| {
            Point::new(-velocity.y, velocity.x) * (0.1 * DRY / velocity.norm() - 0.2)
        });
    }
}
