//! A path that curls: a force across the way, a constant part of friction, as on an object that spins or that leans on one edge.

use values::Point;

use super::{
    Acts, Effect, EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters, Slide,
    wording,
};

/// Speed in m/s below which the way has no direction.
const STILL: f64 = 1e-6;

/// Path curl; parameter `part`: force to the left of the way over that of friction.
pub const SPEC: EffectSpec = EffectSpec {
    name: "path_curl",
    parameters: Parameters::Listed(&[EffectParameter::new("part", "", [-1.0, 1.0], 0.05)]),
    family: Family::FrictionByHeading,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    naming: Naming::Never,
    source: "sideways friction of an object that turns or tips while it slides (Penner 2001, on curling stones), at its simplest",
    starts: |_| FitStart::linear(("part", 0.01)),
    build: |values, _| {
        Box::new(PathCurl {
            part: values.get("part"),
        })
    },
    statement: |values| {
        let part = values.get("part");
        format!(
            "paths curl to the {}, by a force across the way of {} of friction's: an object that spins or stands on one edge does so; look at its \
             base, and at whether the tip strikes its middle",
            wording::side(part),
            wording::percent(part)
        )
    },
};

struct PathCurl {
    part: f64,
}

impl Effect for PathCurl {
    fn acts(&self) -> Acts {
        Acts::Slide
    }

    fn acceleration(&self, slide: &Slide<'_>) -> Point {
        let speed = slide.velocity.norm();
        if speed < STILL {
            return Point::default();
        }
        let left = Point::new(-slide.velocity.y, slide.velocity.x) * speed.recip();
        left * (self.part * slide.dry)
    }
}

#[cfg(test)]
mod tests {
    use values::Point;

    use crate::effects::tests::{Bench, DRY};

    #[test]
    fn the_stop_follows_its_formula() {
        let slid = Bench::with("path_curl", &[("part", 0.1)]).slide(0.9, 0.1);
        slid.assert_integrates(|_, velocity| {
            Point::new(-velocity.y, velocity.x) * (0.1 * DRY / velocity.norm())
        });
    }
}
