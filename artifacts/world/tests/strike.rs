//! A simulated strike against formulas, and against itself at finer steps.

use std::time::Instant;

use values::{Command, Conditions, Point, Rig, Shape};
use world::{
    AddedEffect, Estimate, GRAVITY, Simulator, SolveSettings, SolveStatus, Steps, Worker, World,
    WorldError,
};

const ORIGIN: Point = Point::new(0.3, 0.0);

fn commands() -> impl Iterator<Item = Command> {
    (0..=12).map(|i| Command {
        speed: 0.4 + 0.05 * f64::from(i),
        // Nearer to a box's corner a tip that moves on strikes it twice, and both impacts hang on a hair.
        angle: -0.48 + 0.08 * f64::from(i),
    })
}

fn still_air(rig: &Rig) -> World {
    ["fluid_blunt_drag", "fluid_slender_drag"]
        .iter()
        .fold(World::nominal(rig), |world, name| world.with(name, 0.0))
}

#[test]
fn halving_every_step_moves_no_stop_by_half_a_millimetre() {
    for shape in [Shape::Cylinder, Shape::Box] {
        let rig = Rig::demo(shape);
        let world = World::nominal(&rig).with("friction", 0.25);
        let Steps { contact, slide } = Steps::default();
        let coarse = Simulator::new(&rig, &world).expect("valid");
        let fine = Steps {
            contact: contact / 2.0,
            slide: slide / 2.0,
        };
        let fine = Simulator::with_steps(&rig, &world, fine).expect("valid");
        let mut worst: f64 = 0.0;
        for command in commands() {
            let stop = |sim: &Simulator| {
                sim.worker()
                    .strike(ORIGIN, command, &Conditions::default())
                    .expect("rests")
                    .stop
            };
            worst = worst.max(stop(&coarse).distance(stop(&fine)));
        }
        println!(
            "{shape:?}: halving every step moves the stop by at most {:.3} mm",
            1e3 * worst
        );
        assert!(worst < 0.5e-3, "{shape:?}: {worst} m");
    }
}

#[test]
fn a_cylinder_released_at_e_slides_as_far_as_friction_says() {
    let rig = Rig::demo(Shape::Cylinder);
    for (friction, restitution) in [(0.15, 0.2), (0.25, 0.5), (0.5, 0.8), (0.25, -0.3)] {
        let world = still_air(&rig)
            .with("friction", friction)
            .with("restitution", restitution);
        let simulator = Simulator::new(&rig, &world).expect("valid");
        let mut worker = simulator.worker();
        for command in commands() {
            let path = worker
                .strike(ORIGIN, command, &Conditions::default())
                .expect("rests")
                .stop
                - ORIGIN;
            let release = (1.0 + restitution) * command.speed;
            let expected = release * release / (2.0 * friction * GRAVITY);
            // During the two milliseconds of contact friction takes, and the tip gives, a little.
            assert!(
                (path.norm() / expected - 1.0).abs() < 0.03,
                "{friction} {restitution}: {path:?} against {expected}"
            );
            assert!((path.bearing() - command.angle).abs() < 1e-6);
        }
    }
}

#[test]
fn deceleration_is_friction_times_gravity_at_every_speed() {
    let rig = Rig::demo(Shape::Cylinder);
    let simulator = Simulator::new(&rig, &still_air(&rig).with("friction", 0.25)).expect("valid");
    let command = Command {
        speed: 1.0,
        angle: 0.3,
    };
    let strike = simulator
        .worker()
        .strike(ORIGIN, command, &Conditions::default())
        .expect("rests");
    let (d, h) = (|t: f64| strike.at(t).distance(ORIGIN), 0.04);
    for t in [0.1, 0.2, 0.3, 0.4, 0.5] {
        let deceleration = -(d(t + h) - 2.0 * d(t) + d(t - h)) / (h * h);
        assert!(
            (deceleration / (0.25 * GRAVITY) - 1.0).abs() < 2e-3,
            "{deceleration} at {t} s"
        );
    }
}

#[test]
fn the_same_strike_gives_the_same_bits() {
    let rig = Rig::demo(Shape::Box);
    let simulator = Simulator::new(&rig, &World::nominal(&rig)).expect("valid");
    let command = Command {
        speed: 0.8,
        angle: 0.2,
    };
    let mut worker = simulator.worker();
    let first = worker
        .strike(ORIGIN, command, &Conditions::default())
        .expect("rests");
    worker
        .strike(
            ORIGIN,
            Command {
                speed: 0.5,
                angle: -0.3,
            },
            &Conditions::default(),
        )
        .expect("rests");
    assert_eq!(
        first,
        worker
            .strike(ORIGIN, command, &Conditions::default())
            .expect("rests")
    );
    assert_eq!(
        first,
        simulator
            .worker()
            .strike(ORIGIN, command, &Conditions::default())
            .expect("rests")
    );
}

#[test]
fn a_ball_rolls_on_after_it_has_slid() {
    let rig = Rig::demo(Shape::Sphere);
    let world = still_air(&rig).with("rolling_friction", 0.002);
    let simulator = Simulator::new(&rig, &world).expect("valid");
    let command = Command {
        speed: 0.4,
        angle: 0.1,
    };
    let strike = simulator
        .worker()
        .strike(ORIGIN, command, &Conditions::default())
        .expect("rests");
    let slid = (1.5_f64 * 0.4).powi(2) / (2.0 * 0.3 * GRAVITY);
    assert!(
        strike.stop.distance(ORIGIN) > 2.0 * slid,
        "{:?}",
        strike.stop
    );
}

#[test]
fn what_cannot_be_struck_is_told() {
    let rig = Rig::demo(Shape::Cylinder);
    let simulator = Simulator::new(&rig, &World::nominal(&rig)).expect("valid");
    for (speed, angle) in [
        (0.0, 0.0),
        (f64::NAN, 0.0),
        (0.5, f64::INFINITY),
        (-1.0, 0.0),
    ] {
        assert!(
            simulator
                .worker()
                .strike(ORIGIN, Command { speed, angle }, &Conditions::default())
                .is_err()
        );
    }
}

#[test]
fn every_reachable_target_is_solved_in_about_one_simulation() {
    for (shape, most) in [(Shape::Cylinder, 1.05), (Shape::Box, 1.2)] {
        let rig = Rig::demo(shape);
        let simulator = Simulator::new(&rig, &World::nominal(&rig)).expect("valid");
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
fn what_lies_beyond_an_arm_that_saturates_is_told_in_a_few_simulations() {
    let rig = Rig::demo(Shape::Cylinder);
    let mut world = World::nominal(&rig);
    world.effects.push(AddedEffect {
        name: "striker_speed_error".into(),
        parameters: [("cap".to_string(), Estimate::fixed(0.8))].into(),
    });
    let simulator = Simulator::new(&rig, &world).expect("valid");
    let mut worker = simulator.worker();
    let mut reach = |command| {
        let strike = worker.strike(ORIGIN, command, &Conditions::default());
        (strike.expect("rests").stop - ORIGIN).norm()
    };
    let furthest = reach(Command {
        speed: 1.0,
        angle: 0.1,
    });
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
    let simulator = Simulator::new(&rig, &World::nominal(&rig)).expect("valid");
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
            let command = Command {
                speed: around.speed + faster * step.speed,
                angle: (around.angle + turned * step.angle).clamp(-edge, edge),
            };
            let strike = worker
                .strike(ORIGIN, command, &Conditions::default())
                .expect("rests");
            if strike.stop.distance(target) < miss {
                (best, miss) = (command, strike.stop.distance(target));
            }
        }
        step = Command {
            speed: 0.6 * step.speed,
            angle: 0.6 * step.angle,
        };
    }
    miss
}

#[test]
fn what_is_reported_unreachable_no_strike_on_the_face_reaches_and_nothing_else_is() {
    let rig = Rig::demo(Shape::Box);
    let [half_x, half_y, _] = rig.object.half_size.expect("a box");
    // Half the tip's radius clear of the edge.
    let edge = ((half_y - 0.5 * rig.striker.radius) / (half_x + rig.striker.radius)).atan();
    // Where it holds the box less, the tip catches up with it near the corner, and any stop may follow.
    for tip_friction in [0.4, 0.5] {
        let world = World::nominal(&rig).with("tip_friction", tip_friction);
        let simulator = Simulator::new(&rig, &world).expect("valid");
        let mut worker = simulator.worker();
        let step = Command {
            speed: 0.04,
            angle: edge / 32.0,
        };
        let settings = SolveSettings {
            speed: [0.4, 1.2].into(),
            ..SolveSettings::default()
        };
        let mut grid = Vec::new();
        for i in 0..=20 {
            for j in 0..=32 {
                let command = Command {
                    speed: 0.4 + step.speed * f64::from(i),
                    angle: step.angle * f64::from(j),
                };
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
    let mut world = World::nominal(&rig).with("friction", 0.02);
    world.effects.push(AddedEffect {
        name: "table_tilt".into(),
        parameters: [("tilt_x".to_string(), Estimate::fixed(0.1))].into(),
    });
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

/// A slope that all but takes friction away, and steeper ones: the track is as short as any, or there is none.
#[test]
fn what_runs_away_downhill_takes_no_memory() {
    let rig = Rig::demo(Shape::Cylinder);
    let tilt = |tilt_x: f64| AddedEffect {
        name: "table_tilt".into(),
        parameters: [("tilt_x", tilt_x), ("tilt_y", 0.0)]
            .map(|(name, value)| (name.to_string(), Estimate::fixed(value)))
            .into(),
    };
    let command = Command {
        speed: 0.8,
        angle: 0.0,
    };
    for steeper in [-1e-3, -1e-6, -1e-9, -1e-12, 0.0, 1e-12, 1e-6, 1e-3, 0.1] {
        let mut world = still_air(&rig).with("friction", 0.02);
        world.effects.push(tilt(0.02_f64.asin() + steeper));
        let Ok(simulator) = Simulator::new(&rig, &world) else {
            continue;
        };
        let begun = std::time::Instant::now();
        let struck =
            simulator
                .worker()
                .strike(Point::new(0.3, 0.0), command, &Conditions::default());
        match struck {
            Ok(simulated) => assert!(simulated.track.len() < 50_000, "{steeper}"),
            Err(error) => assert!(matches!(error, WorldError::Diverged { .. }), "{error}"),
        }
        assert!(begun.elapsed().as_secs() < 5, "{steeper}");
    }
}

#[test]
fn an_object_that_brakes_harder_than_the_tip_is_pushed_and_ends_at_rest() {
    let rig = Rig::demo(Shape::Cylinder);
    let world = World::nominal(&rig)
        .with("friction", 0.9)
        .with("restitution", -0.6);
    let simulator = Simulator::new(&rig, &world).expect("valid");
    let command = Command {
        speed: 0.8,
        angle: 0.0,
    };
    let stop = simulator
        .worker()
        .strike(ORIGIN, command, &Conditions::default())
        .expect("rests")
        .stop;
    // The tip holds its speed for two contact times and runs on over v²/(2a) to its own rest, at the speed that stands for the
    // low restitution.
    let tip_speed: f64 = 0.8 * (1.0 - 0.6) / 1.2;
    let held = 2.0 * world.value("contact_time").expect("a parameter");
    let pushed = tip_speed * held + tip_speed.powi(2) / (2.0 * rig.robot.acceleration);
    assert!((stop.x - ORIGIN.x - pushed).abs() < 0.5e-3, "{stop:?}");
}

#[test]
fn a_worker_counts_its_steps_over_all_strikes() {
    let rig = Rig::demo(Shape::Cylinder);
    let simulator = Simulator::new(&rig, &World::nominal(&rig)).expect("valid");
    let mut worker = simulator.worker();
    let command = Command {
        speed: 0.7,
        angle: 0.1,
    };
    let mut counts = vec![worker.steps()];
    for _ in 0..2 {
        worker
            .strike(ORIGIN, command, &Conditions::default())
            .expect("rests");
        counts.push(worker.steps());
    }
    assert_eq!(counts[0], [0, 0]);
    assert!(counts[1][0] > 0 && counts[1][1] > 0, "{counts:?}");
    assert_eq!(counts[2], counts[1].map(|steps| 2 * steps));
}
