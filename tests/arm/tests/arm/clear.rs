//! Where planned strikes send the tip, judged by geometry of its own: places half a millimetre apart, and distances from each to all that
//! the rig file names. Nothing of the planner's checks is used.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use strike::{CommandPlanner, Plan, Planner};
use values::{Command, Interval, Obstacle, Point, Rig, Shape};
use world::World;

use crate::fixture;

/// Places on the tip's way are so far apart, in m.
const STEP: f64 = 0.0005;
/// The tip may be so far beside its line, in m, before it is stopped.
const ASIDE: f64 = 0.005;
/// Targets that are drawn on one rig.
const DRAWS: usize = 200;
/// Rounding of the distances compared, in m.
const ROUNDING: f64 = 1e-9;

type Random = ChaCha8Rng;

fn between(random: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * random.random::<f64>()
}

/// A table with an arm beside it, and what stands on it.
fn rig(random: &mut Random) -> Rig {
    let shapes = [Shape::Cylinder, Shape::Box, Shape::Sphere];
    let mut rig = Rig::demo(shapes[random.random_range(0..3)]);
    let robot = &mut rig.robot;
    robot.base = Some(Point::new(
        between(random, -0.3, 0.1),
        between(random, -0.7, 0.7),
    ));
    robot.keep_out = Some(between(random, 0.05, 0.25));
    if random.random::<f64>() < 0.7 {
        let low = between(random, 0.05, 0.4);
        robot.reach = Some([low, low + between(random, 0.3, 0.9)].into());
    }
    robot.jerk = (random.random::<f64>() < 0.5).then_some(100.0);
    robot.acceleration = between(random, 2.0, 10.0);
    for _ in 0..random.random_range(0..5) {
        let at = Point::new(between(random, 0.1, 1.0), between(random, -0.6, 0.6));
        let [one, other] = [0; 2].map(|_| between(random, 0.005, 0.1));
        robot.obstacles.push(if random.random::<f64>() < 0.5 {
            Obstacle::Disc {
                centre: at,
                radius: one,
            }
        } else {
            Obstacle::Box {
                x: [at.x - one, at.x + one].into(),
                y: [at.y - other, at.y + other].into(),
            }
        });
    }
    rig
}

fn world() -> World {
    let world = World::nominal().with("friction", 0.2);
    world.with("restitution", 0.5)
}

/// What the tip, of the rig's radius, comes too near to at a place; none where it does not.
fn too_near(rig: &Rig, at: Point) -> Option<String> {
    let (robot, table, radius) = (&rig.robot, &rig.table, rig.striker.radius);
    let base = robot.base.unwrap();
    let x_low = table.x.low.min(base.x);
    let is_over = at.x - radius >= x_low - ROUNDING
        && at.x + radius <= table.x.high + ROUNDING
        && at.y - radius >= table.y.low - ROUNDING
        && at.y + radius <= table.y.high + ROUNDING;
    let from_base = at.distance(base);
    if !is_over {
        return Some("the area".into());
    }
    if from_base - radius < robot.keep_out.unwrap() + ASIDE {
        return Some("the keep-out".into());
    }
    if robot
        .reach
        .is_some_and(|reach| from_base < reach.low - ROUNDING || from_base > reach.high + ROUNDING)
    {
        return Some("its reach".into());
    }
    met(rig, at, radius + ASIDE)
}

/// The obstacle that what reaches so far (m) about a place meets.
fn met(rig: &Rig, at: Point, reach: f64) -> Option<String> {
    let gap = |obstacle: &Obstacle| match obstacle {
        Obstacle::Disc { centre, radius } => at.distance(*centre) - radius,
        Obstacle::Box { x, y } => {
            let beyond = |low: f64, high: f64, v: f64| (low - v).max(v - high).max(0.0);
            beyond(x.low, x.high, at.x).hypot(beyond(y.low, y.high, at.y))
        }
    };
    let met = rig.robot.obstacles.iter().find(|o| gap(o) < reach);
    met.map(|obstacle| format!("{obstacle:?}"))
}

/// What an object that slides there comes too near to: an obstacle, or with its smallest half width the table's edge.
fn slides_into(rig: &Rig, at: Point) -> Option<String> {
    let (table, half) = (&rig.table, rig.object.solid.narrowest());
    // A ball rests on a point.
    let foot = if rig.object.shape() == Shape::Sphere {
        0.0
    } else {
        half
    };
    let is_on = |range: Interval, v: f64| {
        range.low <= v - foot + ROUNDING && v + foot <= range.high + ROUNDING
    };
    let is_on_table = is_on(table.x, at.x) && is_on(table.y, at.y);
    let edge = (!is_on_table).then(|| "the object: the table's edge".to_owned());
    edge.or_else(|| met(rig, at, half).map(|obstacle| format!("the object: {obstacle}")))
}

fn places(from: Point, to: Point) -> impl Iterator<Item = Point> {
    let steps = (from.distance(to) / STEP).ceil().max(1.0) as u32;
    (0..=steps).map(move |step| from + (to - from) * (f64::from(step) / f64::from(steps)))
}

/// Distance (m) from the tip's centre to the object that lies at the plan's start.
fn to_object(rig: &Rig, plan: &Plan, at: Point) -> f64 {
    let apart = at - plan.from;
    match rig.object.solid.half_sides() {
        None => apart.norm() - rig.object.solid.reach(),
        Some([x, y]) => {
            let (sin, cos) = plan.yaw.unwrap_or(0.0).sin_cos();
            let (u, v) = (cos * apart.x + sin * apart.y, cos * apart.y - sin * apart.x);
            let (beyond_u, beyond_v) = (u.abs() - x, v.abs() - y);
            beyond_u.max(0.0).hypot(beyond_v.max(0.0)) + beyond_u.max(beyond_v).min(0.0)
        }
    }
}

fn wrong(rig: &Rig, plan: &Plan, here: Point) -> Option<String> {
    let on_its_way = places(plan.start, plan.stop).find_map(|at| too_near(rig, at));
    let on_the_way_there = plan
        .check_approach(here)
        .ok()
        .and_then(|()| places(here, plan.start).find_map(|at| too_near(rig, at)));
    // A ball is struck at the height of the tip, where it may be narrower: the others are met in plan view.
    let clear = |at| to_object(rig, plan, at) - rig.striker.radius;
    let is_flat = rig.object.shape() != Shape::Sphere;
    let before = places(plan.start, plan.pre_strike)
        .map(clear)
        .fold(f64::INFINITY, f64::min);
    let at_touch = clear(plan.strike);
    let met_early = (is_flat && (before < ASIDE || at_touch.abs() > 1e-3))
        .then(|| format!("the object: {before} before, {at_touch} at the touch"));
    let slide = places(plan.from, plan.to).find_map(|at| slides_into(rig, at));
    on_its_way.or(on_the_way_there).or(met_early).or(slide)
}

#[test]
fn no_planned_strike_leaves_its_area_or_reach_or_comes_near_the_base_or_an_obstacle() {
    // All of the page's are some minutes' work.
    let wanted = if std::env::var("ARM_PAGE").is_ok() {
        10_000
    } else {
        600
    };
    let [planned, turned, refused]: [AtomicUsize; 3] = Default::default();
    let of_rig = |seed: u64| {
        let mut random = Random::seed_from_u64(seed);
        let rig = rig(&mut random);
        let mut artifact = fixture::artifact();
        artifact.rig = rig.clone();
        artifact.sysid.world = world();
        let planner = Planner::within(&artifact, store::Model::Sysid, &rig).unwrap();
        let commands = CommandPlanner::nominal(&rig).unwrap();
        for draw in 0..DRAWS {
            let mut point = |x: [f64; 2], y: f64| {
                Point::new(
                    between(&mut random, x[0], x[1]),
                    between(&mut random, -y, y),
                )
            };
            let (from, to, here) = (
                point([0.1, 0.5], 0.6),
                point([0.2, 1.0], 0.6),
                point([-0.3, 1.1], 0.7),
            );
            let yaw = between(&mut random, -0.3, 0.3);
            // Every fifth one as a collection plans it, of which no target is known.
            let of = |range: Interval| between(&mut random, range.low, range.high);
            let [speed, angle] = [rig.robot.speed, rig.robot.angle].map(of);
            let plan = match draw % 5 {
                0 => commands.plan_turned(from, Command { speed, angle }, 1.5, yaw),
                _ => planner.plan_turned(from, to, yaw),
            };
            let Ok(plan) = plan else {
                refused.fetch_add(1, Ordering::Relaxed);
                continue;
            };
            let wrong = wrong(&rig, &plan, here);
            assert_eq!(wrong, None, "seed {seed}: {rig:?}\n{plan:?}");
            planned.fetch_add(1, Ordering::Relaxed);
            turned.fetch_add(usize::from(plan.yaw.is_some()), Ordering::Relaxed);
        }
    };
    thread::scope(|scope| {
        for first in 0..2 {
            let (of_rig, planned) = (&of_rig, &planned);
            scope.spawn(move || {
                for seed in (first..).step_by(2) {
                    if planned.load(Ordering::Relaxed) >= wanted {
                        return;
                    }
                    of_rig(seed);
                }
            });
        }
    });
    let [planned, turned, refused] = [planned, turned, refused].map(AtomicUsize::into_inner);
    println!("{planned} strikes planned, {turned} of turned boxes, {refused} refused");
    assert!(turned > planned / 20);
}
