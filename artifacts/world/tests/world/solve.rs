//! Solving a path backwards, in reach and out of it.

use std::time::Instant;

use values::{Command, Conditions, Point, Rig, Shape};
use world::{AddedEffect, Simulator, SolveSettings, SolveStatus, Worker, World};

const ORIGIN: Point = Point::new(0.3, 0.0);

#[test]
fn every_reachable_target_is_solved_in_about_one_simulation() {
    for (shape, most) in [(Shape::Cylinder, 1.05), (Shape::Box, 1.2)] {
        let rig = Rig::demo(shape);
        let simulator = Simulator::new(&rig, &World::nominal()).expect("valid");
        let mut worker = simulator.worker();
        let (mut evaluations, mut count) = (0, 0);
        let begun = Instant::now();
        for i in 0..12 {
            for j in 0..9 {
                let path = Point::polar(0.08 + 0.04 * f64::from(i), -0.4 + 0.1 * f64::from(j));
                let solution = worker.solve(
                    ORIGIN,
                    ORIGIN + path,
                    &Conditions::default(),
                    &SolveSettings::default(),
                    None,
                );
                assert_eq!(
                    solution.status,
                    SolveStatus::Solved,
                    "{path:?}: {solution:?}"
                );
                assert!(solution.miss < 1e-3);
                evaluations += solution.evaluations;
                count += 1;
            }
        }
        let mean = f64::from(evaluations) / f64::from(count);
        println!(
            "{shape:?}: {mean:.2} simulations a solve, {:.0} solves/s",
            f64::from(count) / begun.elapsed().as_secs_f64()
        );
        assert!(mean <= most, "{shape:?}: {mean} simulations a solve");
    }
}

#[test]
fn what_lies_beyond_an_arm_that_saturates_is_reported_in_a_few_simulations() {
    let rig = Rig::demo(Shape::Cylinder);
    let mut world = World::nominal();
    world
        .effects
        .push(AddedEffect::fixed("striker_speed_error", &[("cap", 0.8)]));
    let simulator = Simulator::new(&rig, &world).expect("valid");
    let mut worker = simulator.worker();
    let mut reach = |command| {
        let strike = worker.strike(ORIGIN, command, &Conditions::default());
        (strike.expect("rests").stop - ORIGIN).norm()
    };
    let furthest = reach(Command::new(1.0, 0.1));
    for (share, status) in [
        (0.95, SolveStatus::Solved),
        (1.05, SolveStatus::Unreachable),
        (1.5, SolveStatus::Unreachable),
    ] {
        let target = ORIGIN + Point::polar(share * furthest, 0.1);
        let settings = SolveSettings::default();
        let solution = worker.solve(ORIGIN, target, &Conditions::default(), &settings, None);
        assert_eq!(solution.status, status, "{share}: {solution:?}");
        assert!(solution.evaluations <= 6, "{share}: {solution:?}");
        let beyond = (share - 1.0).max(0.0) * furthest;
        assert!(
            (solution.miss - beyond).abs() < 1e-3,
            "{share}: {solution:?}"
        );
    }
}

#[test]
fn an_unreachable_target_is_a_status() {
    let rig = Rig::demo(Shape::Cylinder);
    let simulator = Simulator::new(&rig, &World::nominal()).expect("valid");
    let settings = SolveSettings {
        speed: [0.4, 1.0].into(),
        ..SolveSettings::default()
    };
    let solution = simulator.worker().solve(
        ORIGIN,
        Point::new(5.0, 0.0),
        &Conditions::default(),
        &settings,
        None,
    );
    assert_eq!(solution.status, SolveStatus::Unreachable);
    assert!(solution.miss > 1.0 && solution.evaluations < 100);
}

/// The least distance in m between a target and any stop of these commands, found on a grid and refined around its best.
fn nearest(
    worker: &mut Worker<'_>,
    grid: &[(Command, Point)],
    target: Point,
    step: Command,
    edge: f64,
) -> f64 {
    let by_distance = |a: &&(Command, Point), b: &&(Command, Point)| {
        a.1.distance(target).total_cmp(&b.1.distance(target))
    };
    let (mut best, stop) = *grid.iter().min_by(by_distance).expect("a grid");
    let mut miss = stop.distance(target);
    let mut step = step;
    for _ in 0..7 {
        let around = best;
        for (faster, turned) in [
            (-1.0, -1.0),
            (-1.0, 0.0),
            (-1.0, 1.0),
            (0.0, -1.0),
            (0.0, 1.0),
            (1.0, -1.0),
            (1.0, 0.0),
            (1.0, 1.0),
        ] {
            let command = Command::new(
                around.speed + faster * step.speed,
                (around.angle + turned * step.angle).clamp(-edge, edge),
            );
            let strike = worker
                .strike(ORIGIN, command, &Conditions::default())
                .expect("rests");
            if strike.stop.distance(target) < miss {
                (best, miss) = (command, strike.stop.distance(target));
            }
        }
        step = Command::new(0.6 * step.speed, 0.6 * step.angle);
    }
    miss
}

#[test]
fn what_is_reported_unreachable_no_strike_on_the_face_reaches_and_nothing_else_is() {
    let rig = Rig::demo(Shape::Box);
    let [half_x, half_y] = rig.object.solid.half_sides().expect("a box");
    // Half the tip's radius clear of the edge.
    let edge = ((half_y - 0.5 * rig.striker.radius) / (half_x + rig.striker.radius)).atan();
    // Where it holds the box less, the tip catches up with it near the corner, and any stop may follow.
    for tip_friction in [0.4, 0.5] {
        let world = World::nominal().with("tip_friction", tip_friction);
        let simulator = Simulator::new(&rig, &world).expect("valid");
        let mut worker = simulator.worker();
        let step = Command::new(0.04, edge / 32.0);
        let settings = SolveSettings {
            speed: [0.4, 1.2].into(),
            ..SolveSettings::default()
        };
        let mut grid = Vec::new();
        for i in 0..=20 {
            for j in 0..=32 {
                let command =
                    Command::new(0.4 + step.speed * f64::from(i), step.angle * f64::from(j));
                let strike = worker
                    .strike(ORIGIN, command, &Conditions::default())
                    .expect("rests");
                grid.push((command, strike.stop));
            }
        }
        let (mut solved, mut evaluations, mut in_vain) = (0, 0, 0);
        for i in 0..6 {
            for j in 0..8 {
                let target =
                    ORIGIN + Point::polar(0.09 + 0.07 * f64::from(i), 0.05 + 0.07 * f64::from(j));
                let solution =
                    worker.solve(ORIGIN, target, &Conditions::default(), &settings, None);
                if solution.status == SolveStatus::Solved {
                    solved += 1;
                    evaluations += solution.evaluations;
                    assert!(solution.miss < 1e-3);
                } else {
                    in_vain += solution.evaluations;
                    let miss = nearest(&mut worker, &grid, target, step, edge);
                    assert!(miss >= 1e-3, "{target:?}: {solution:?} but {miss}");
                }
            }
        }
        println!(
            "tip friction {tip_friction}: {solved} of 48 solved in {evaluations} simulations, the others given up in {in_vain}"
        );
        assert!((10..48).contains(&solved), "{solved}");
        assert!(evaluations <= 2 * solved, "{evaluations}");
        assert!(in_vain <= 12 * (48 - solved), "{in_vain}");
    }
}

#[test]
fn what_never_comes_to_rest_is_given_up_soon() {
    let rig = Rig::demo(Shape::Cylinder);
    let mut world = World::nominal().with("friction", 0.02);
    world
        .effects
        .push(AddedEffect::fixed("table_tilt", &[("tilt_x", 0.1)]));
    let simulator = Simulator::new(&rig, &world).expect("valid");
    let solution = simulator.worker().solve(
        ORIGIN,
        Point::new(0.6, 0.0),
        &Conditions::default(),
        &SolveSettings::default(),
        None,
    );
    assert_eq!(solution.status, SolveStatus::Diverged);
    assert!(solution.evaluations <= 4, "{solution:?}");
}
