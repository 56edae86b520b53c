//! Which strikes a set is made of: designs that a laboratory would make, from physics and the rig's limits alone.

use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rig::{PlannedStrike, StrikeIndex, Truth};
use serde::{Deserialize, Serialize};
use values::Interval;

use super::super::form::{one_of, uniform};
use super::kind::HardKind;

values::named! {
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Design {
        /// Strikes as in the demo: start, speed and angle at random; 40 to 160 strikes.
        Random = "at random, as the demo",
        /// At random, 25 strikes.
        Few = "at random, 25 strikes",
        /// At random, 400 strikes.
        Many = "at random, 400 strikes",
        /// At random, with a quarter of the strikes in a row missing from the logs.
        Gaps = "at random, gaps in the order",
        /// All pairs of five angles and four speeds, from two starts, once to three times, in their order or shuffled.
        Grid = "a grid",
        /// One angle; start and speed at random.
        OneAngle = "one angle",
        /// One speed; start and angle at random.
        OneSpeed = "one speed",
        /// One start; speed and angle at random.
        OneStart = "one start",
        /// One start and command, again and again.
        Repeats = "repeats of one command",
        /// One start; speed or angle rises from strike to strike, the other is fixed.
        Sweep = "a sweep",
    }
}

/// Number of designs that vary everything.
const WIDE: usize = 5;

/// Share of the sets in the demo's design: of those that hide nothing, and of the others.
const RANDOM_CONTROLS: f64 = 0.35;
const RANDOM: f64 = 0.6;
const STRIKES: [usize; 5] = [40, 60, 90, 120, 160];
/// The object stays this far from the table's edge where nothing is hidden, in m: room for what will be.
const MARGIN: f64 = 0.08;
/// Where a person puts an object down that is to lie at one place, in m.
const PUT_DOWN: f64 = 0.002;
/// Draws before a design is given up.
const TRIES: usize = 2000;

impl Design {
    /// Draws a design that can tell what a set of this kind hides. One angle, speed, start or command makes different phenomena the same, and a
    /// sweep makes of every change by the order one by the command: no name would be wrong.
    pub(super) fn draw(kind: HardKind, random: &mut ChaCha8Rng) -> Self {
        let (share, fit) = match kind {
            HardKind::Control => (RANDOM_CONTROLS, Self::ALL.len()),
            HardKind::Odd => (RANDOM, Self::ALL.len()),
            HardKind::Order => (RANDOM, Self::ALL.len() - 1),
            _ => (RANDOM, WIDE),
        };
        if random.random::<f64>() < share {
            Self::Random
        } else {
            *one_of(random, &Self::ALL[1..fit])
        }
    }

    /// The strikes in their order; none where such strikes would leave the table. `truth` hides nothing yet.
    pub(super) fn plan(self, truth: &Truth, random: &mut ChaCha8Rng) -> Option<Vec<PlannedStrike>> {
        let count = *one_of(random, &STRIKES);
        match self {
            Self::Random => like(truth, count, [false; 3], random),
            Self::Few => like(truth, 25, [false; 3], random),
            Self::Many => like(truth, 400, [false; 3], random),
            Self::Gaps => like(truth, count * 4 / 3, [false; 3], random),
            Self::OneStart => like(truth, count, [true, false, false], random),
            Self::OneSpeed => like(truth, count, [false, true, false], random),
            Self::OneAngle => like(truth, count, [false, false, true], random),
            Self::Repeats => like(truth, count, [true; 3], random),
            Self::Grid => grid(truth, random),
            Self::Sweep => sweep(truth, count, random),
        }
    }
}

/// A strike anywhere within the demo's starts and the robot's limits.
fn anywhere(truth: &Truth, random: &mut ChaCha8Rng) -> PlannedStrike {
    let robot = &truth.rig.robot;
    PlannedStrike {
        x0: uniform(random, 0.2, 0.4),
        y0: uniform(random, -0.2, 0.2),
        speed: uniform(random, robot.speed.low, robot.speed.high),
        angle: uniform(random, robot.angle.low, robot.angle.high),
    }
}

fn stays(truth: &Truth, strike: &PlannedStrike) -> bool {
    let (x, y) = (truth.rig.table.x, truth.rig.table.y);
    let inside =
        |value: f64, side: Interval| (side.low + MARGIN..=side.high - MARGIN).contains(&value);
    let outcome = truth.outcome(strike.initial(), strike.command(), StrikeIndex::default());
    outcome.is_ok_and(|slide| {
        let moved = slide.rest_time() > 0.0;
        moved && slide.points().all(|at| inside(at.x, x) && inside(at.y, y))
    })
}

/// A planned strike whose object is put down anew at its start, up to [`PUT_DOWN`] (m) off along x and y.
fn put_down(at: &PlannedStrike, random: &mut ChaCha8Rng) -> PlannedStrike {
    PlannedStrike {
        x0: at.x0 + uniform(random, -PUT_DOWN, PUT_DOWN),
        y0: at.y0 + uniform(random, -PUT_DOWN, PUT_DOWN),
        ..*at
    }
}

/// Strikes at random, but with the first one's start, speed or angle where `fixed` says so.
fn like(
    truth: &Truth,
    count: usize,
    [start, speed, angle]: [bool; 3],
    random: &mut ChaCha8Rng,
) -> Option<Vec<PlannedStrike>> {
    let mut plan: Vec<PlannedStrike> = Vec::with_capacity(count);
    let mut tries = 0;
    while plan.len() < count {
        tries += 1;
        if tries > TRIES + 50 * count {
            return None;
        }
        let mut strike = anywhere(truth, random);
        if let Some(first) = plan.first() {
            if start {
                let again = put_down(first, random);
                (strike.x0, strike.y0) = (again.x0, again.y0);
            }
            if speed {
                strike.speed = first.speed;
            }
            if angle {
                strike.angle = first.angle;
            }
        }
        if stays(truth, &strike) {
            plan.push(strike);
        }
    }
    Some(plan)
}

/// Equal steps from one value to another.
fn steps(within: Interval, count: usize) -> impl Iterator<Item = f64> + Clone {
    let width = within.high - within.low;
    (0..count).map(move |i| within.low + width * i as f64 / (count - 1) as f64)
}

fn grid(truth: &Truth, random: &mut ChaCha8Rng) -> Option<Vec<PlannedStrike>> {
    let robot = &truth.rig.robot;
    let mut cells = Vec::new();
    for _ in 0..2 {
        let start = anywhere(truth, random);
        for speed in steps(robot.speed, 4) {
            for angle in steps(robot.angle, 5) {
                cells.push(PlannedStrike {
                    speed,
                    angle,
                    ..start
                });
            }
        }
    }
    // Those that would leave the table are left out, as a person does.
    cells.retain(|cell| stays(truth, cell));
    let rounds = 1 + (3.0 * random.random::<f64>()) as usize;
    let mut plan: Vec<PlannedStrike> = (0..rounds)
        .flat_map(|_| cells.clone())
        .map(|cell| put_down(&cell, random))
        .collect();
    if random.random::<f64>() < 0.5 {
        plan.shuffle(random);
    }
    (plan.len() >= 16).then_some(plan)
}

fn sweep(truth: &Truth, count: usize, random: &mut ChaCha8Rng) -> Option<Vec<PlannedStrike>> {
    let robot = &truth.rig.robot;
    let by_speed = random.random::<f64>() < 0.5;
    let passes = 1 + (2.0 * random.random::<f64>()) as usize;
    for _ in 0..TRIES {
        let first = anywhere(truth, random);
        // As far up as this start and angle let it.
        let top = uniform(random, 0.5, 1.0);
        let share = |i: usize| (i * passes % count) as f64 / count as f64;
        let at = |i: usize| match by_speed {
            true => PlannedStrike {
                speed: robot.speed.low + top * share(i) * (robot.speed.high - robot.speed.low),
                ..first
            },
            false => PlannedStrike {
                angle: robot.angle.low + share(i) * (robot.angle.high - robot.angle.low),
                ..first
            },
        };
        if (0..count).all(|i| stays(truth, &at(i))) {
            return Some((0..count).map(|i| put_down(&at(i), random)).collect());
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rig::Hidden;
    use values::Shape;

    use super::*;

    #[test]
    fn every_design_can_be_made_and_is_what_it_says() {
        for shape in [Shape::Cylinder, Shape::Box] {
            let mut truth = Truth::demo(&Truth::demo_rig(shape), 1);
            truth.hidden = Hidden::none();
            let mut random = ChaCha8Rng::seed_from_u64(4);
            for design in Design::ALL {
                let plan = design.plan(&truth, &mut random).expect("it can be made");
                let sd = |of: fn(&PlannedStrike) -> f64| {
                    let n = plan.len() as f64;
                    let mean = plan.iter().map(of).sum::<f64>() / n;
                    (plan.iter().map(|s| (of(s) - mean).powi(2)).sum::<f64>() / n).sqrt()
                };
                let spreads = [
                    sd(|s| s.x0) > 0.005,
                    sd(|s| s.speed) > 1e-9,
                    sd(|s| s.angle) > 1e-9,
                ];
                let expected = match design {
                    Design::OneAngle => [true, true, false],
                    Design::OneSpeed => [true, false, true],
                    Design::OneStart => [false, true, true],
                    Design::Repeats => [false; 3],
                    Design::Sweep => [false, spreads[1], !spreads[1]],
                    _ => [true; 3],
                };
                assert_eq!(spreads, expected, "{design:?}");
            }
        }
    }
}
