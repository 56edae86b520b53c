//! Which strike to make next: the one that lies farthest from those made, of place, speed and angle, and stays on the table.

use values::{Command, Interval, Point, Rig};

use super::collection::Collection;
use super::error::CollectError;
use super::request::StrikeRequest;
use crate::{CommandPlanner, Plan, Resting};

/// Number of commands that are compared for one strike.
const CANDIDATES: u64 = 96;
/// Number of places that are tried for the object before it is said that none serves.
const PLACES: u64 = 64;
/// Parts of the table that the object starts from: the paper's, the third in the middle of its near third.
const START_X: (f64, f64) = (1.0 / 9.0, 1.0 / 3.0);
const START_Y: (f64, f64) = (1.0 / 3.0, 2.0 / 3.0);

/// Where the object is best put for the next strike: the next place of an even sequence from which a strike fits. `is_over` ends the search,
/// which takes minutes where none does.
pub(super) fn request(
    planner: &CommandPlanner,
    collection: &Collection,
    is_over: &dyn Fn() -> bool,
) -> Result<StrikeRequest, CollectError> {
    let (made, farther) = (collection.made(), collection.farther(planner));
    let first = collection.strikes_made() as u64;
    let mut last = None;
    for place in first..first + PLACES {
        if is_over() {
            return Err(CollectError::Interrupted);
        }
        let from = start(planner.rig(), place);
        match choose(planner, &Resting::at(from), &made, farther) {
            Ok(plan) => {
                return Ok(StrikeRequest {
                    from,
                    command: plan.command(),
                });
            }
            Err(error) => last = Some(error),
        }
    }
    Err(last.unwrap_or_else(|| CollectError::NoStrike("no place was tried".into())))
}

/// The n-th place of the object, to a millimetre.
fn start(rig: &Rig, n: u64) -> Point {
    let part = |bounds: Interval, (low, high): (f64, f64), base: u64| {
        let share = low + (high - low) * halton(n, base);
        ((bounds.low + share * (bounds.high - bounds.low)) * 1e3).round() / 1e3
    };
    Point::new(part(rig.table.x, START_X, 2), part(rig.table.y, START_Y, 3))
}

/// The strike of an object at rest whose command lies farthest from those made, of those that can be made.
pub(super) fn choose(
    planner: &CommandPlanner,
    rest: &Resting,
    made: &[StrikeRequest],
    farther: f64,
) -> Result<Plan, CollectError> {
    let (rig, from, yaw) = (planner.rig(), rest.point, rest.yaw.unwrap_or(0.0));
    let between = |range: Interval, share: f64| {
        let value = range.low + share * (range.high - range.low);
        (value * 1e4).round() / 1e4
    };
    // Other candidates for each strike: none is tried a hundred times.
    let offset = made.len() as u64 * CANDIDATES;
    let mut candidates: Vec<(f64, Command)> = (0..CANDIDATES)
        .map(|n| {
            let command = Command::new(
                between(rig.robot.speed, halton(offset + n, 2)),
                between(rig.robot.angle, halton(offset + n, 3)),
            );
            (alone(rig, StrikeRequest { from, command }, made), command)
        })
        .collect();
    candidates.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut last = None;
    for (_, command) in candidates {
        match planner.plan_turned(from, command, farther, yaw) {
            Ok(plan) => return Ok(plan),
            Err(refusal) => last = Some(refusal),
        }
    }
    Err(CollectError::NoStrike(format!(
        "no command of robot.speed and robot.angle can be struck with the object at ({:.3}, {:.3}) m{}; lay it elsewhere",
        from.x,
        from.y,
        last.map_or(String::new(), |refusal| format!(
            ", the last was refused: {refusal}"
        ))
    )))
}

/// Distance of a strike from the nearest of those made, in shares of the ranges.
fn alone(rig: &Rig, request: StrikeRequest, made: &[StrikeRequest]) -> f64 {
    let share = |a: f64, b: f64, range: Interval| (a - b) / (range.high - range.low).max(1e-9);
    made.iter()
        .map(|other| {
            [
                share(request.command.speed, other.command.speed, rig.robot.speed),
                share(request.command.angle, other.command.angle, rig.robot.angle),
                share(request.from.x, other.from.x, rig.table.x),
                share(request.from.y, other.from.y, rig.table.y),
            ]
            .iter()
            .map(|part| part * part)
            .sum()
        })
        .fold(f64::INFINITY, f64::min)
}

/// The n-th number of an even sequence in 0..1 (Halton, 1960).
fn halton(n: u64, base: u64) -> f64 {
    let (mut n, mut digit, mut sum) = (n + 1, 1.0, 0.0);
    while n > 0 {
        digit /= base as f64;
        sum += digit * (n % base) as f64;
        n /= base;
    }
    sum
}

#[cfg(test)]
mod tests {
    use values::Shape;

    use super::*;

    #[test]
    fn commands_fill_what_the_arm_may_do_evenly_and_stay_on_the_table() {
        let rig = Rig::demo(Shape::Cylinder);
        let planner = CommandPlanner::nominal(&rig).expect("a world");
        let mut made = Vec::new();
        let (mut speeds, mut angles) = ([0; 3], [0; 3]);
        for n in 0..54 {
            let from = start(&rig, n);
            let plan = choose(&planner, &Resting::at(from), &made, 1.0).expect("a strike");
            let third = |range: Interval, value: f64| {
                let share = (value - range.low) / (range.high - range.low);
                ((share * 3.0) as usize).min(2)
            };
            speeds[third(rig.robot.speed, plan.speed)] += 1;
            angles[third(rig.robot.angle, plan.angle)] += 1;
            assert!(rig.table.contains(plan.to));
            made.push(StrikeRequest {
                from,
                command: plan.command(),
            });
        }
        // Eighteen a third where all were alike; from some places the fastest ones leave the table.
        let is_even = |thirds: [u32; 3]| thirds.iter().all(|count| (6..=30).contains(count));
        assert!(is_even(speeds) && is_even(angles), "{speeds:?} {angles:?}");
    }

    #[test]
    fn a_box_is_struck_as_it_is_seen_to_stand() {
        let planner = CommandPlanner::nominal(&Rig::demo(Shape::Box)).expect("a world");
        let turned = |yaw| Resting {
            yaw: Some(yaw),
            ..Resting::at(Point::new(0.3, 0.0))
        };
        let plan = |yaw| choose(&planner, &turned(yaw), &[], 1.0);
        assert_eq!(plan(0.2).expect("a strike").yaw, Some(0.2));
        let error = plan(0.6).expect_err("on its corner").to_string();
        assert!(error.contains("lay it straighter"), "{error}");
    }

    #[test]
    fn from_a_place_that_nothing_fits_the_reason_is_reported() {
        let rig = Rig::demo(Shape::Cylinder);
        let planner = CommandPlanner::nominal(&rig).expect("a world");
        let edge = Resting::at(Point::new(0.98, 0.0));
        let error = choose(&planner, &edge, &[], 1.0).expect_err("at the edge");
        assert!(error.to_string().contains("refused"), "{error}");
    }
}
