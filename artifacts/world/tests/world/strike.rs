//! A simulated strike against formulas, and against itself at finer steps.

use values::{Command, Conditions, Point, Rig, Shape};
use world::{AddedEffect, GRAVITY, Simulator, Steps, World, WorldError};

const ORIGIN: Point = Point::new(0.3, 0.0);

fn commands() -> impl Iterator<Item = Command> {
    (0..=12).map(|i| Command {
        speed: 0.4 + 0.05 * f64::from(i),
        // Nearer to a box's corner a tip that moves on strikes it twice, and both impacts hang on a hair.
        angle: -0.48 + 0.08 * f64::from(i),
    })
}

fn still_air() -> World {
    ["fluid_blunt_drag", "fluid_slender_drag"]
        .iter()
        .fold(World::nominal(), |world, name| world.with(name, 0.0))
}

#[test]
fn halving_every_step_moves_no_stop_by_half_a_millimetre() {
    for shape in [Shape::Cylinder, Shape::Box] {
        let rig = Rig::demo(shape);
        let world = World::nominal().with("friction", 0.25);
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
        let world = still_air()
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
    let simulator = Simulator::new(&rig, &still_air().with("friction", 0.25)).expect("valid");
    let command = Command::new(1.0, 0.3);
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
    let simulator = Simulator::new(&rig, &World::nominal()).expect("valid");
    let command = Command::new(0.8, 0.2);
    let mut worker = simulator.worker();
    let first = worker
        .strike(ORIGIN, command, &Conditions::default())
        .expect("rests");
    worker
        .strike(ORIGIN, Command::new(0.5, -0.3), &Conditions::default())
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

/// It slides at μ·g until it rolls, at v/3.5·(μ − s·c)·g, then rolls at c·g; c by the torque that a ball's inertia shares.
#[test]
fn a_ball_slides_and_then_rolls() {
    let rig = Rig::demo(Shape::Sphere);
    let radius = rig.object.solid.half_height();
    for (friction, rolling, in_slip) in [
        (0.3, 0.02, 0.0),
        (0.18, 0.1, 0.0),
        (0.18, 0.1, 0.5),
        (0.18, 0.1, 1.0),
        (0.5, 0.01, 1.0),
    ] {
        let world = still_air()
            .with("friction", friction)
            .with("rolling_friction", 1.4 * radius * rolling)
            .with("rolling_in_slip", in_slip);
        let simulator = Simulator::new(&rig, &world).expect("valid");
        for speed in [0.4, 0.8] {
            let launch = 1.5 * speed;
            let slides = launch / (3.5 * (friction - in_slip * rolling) * GRAVITY);
            let left = launch - friction * GRAVITY * slides;
            let slid = 0.5 * (launch + left) * slides;
            let expected = slid + left * left / (2.0 * rolling * GRAVITY);
            let strike = simulator
                .worker()
                .strike(ORIGIN, Command::new(speed, 0.3), &Conditions::default())
                .expect("rests");
            for (gone, expected) in [(strike.stop, expected), (strike.at(slides), slid)] {
                let off = gone.distance(ORIGIN) / expected - 1.0;
                assert!(
                    off.abs() < 5e-3,
                    "{friction} {rolling} {in_slip} {speed}: {off}"
                );
            }
        }
    }
}

#[test]
fn what_cannot_be_struck_is_reported() {
    let rig = Rig::demo(Shape::Cylinder);
    let simulator = Simulator::new(&rig, &World::nominal()).expect("valid");
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

/// A slope that all but takes friction away, and steeper ones: the track is as short as any, or there is none.
#[test]
fn what_runs_away_downhill_takes_no_memory() {
    let rig = Rig::demo(Shape::Cylinder);
    let tilt =
        |tilt_x: f64| AddedEffect::fixed("table_tilt", &[("tilt_x", tilt_x), ("tilt_y", 0.0)]);
    let command = Command::new(0.8, 0.0);
    for steeper in [-1e-3, -1e-6, -1e-9, -1e-12, 0.0, 1e-12, 1e-6, 1e-3, 0.1] {
        let mut world = still_air().with("friction", 0.02);
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
    let world = World::nominal()
        .with("friction", 0.9)
        .with("restitution", -0.6);
    let simulator = Simulator::new(&rig, &world).expect("valid");
    let command = Command::new(0.8, 0.0);
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
    let simulator = Simulator::new(&rig, &World::nominal()).expect("valid");
    let mut worker = simulator.worker();
    let command = Command::new(0.7, 0.1);
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

#[test]
fn a_strike_leads_as_far_as_after_an_impact_without_duration() {
    let rig = Rig::demo(Shape::Cylinder);
    for (friction, restitution) in [(0.15, 0.5), (0.29, 0.42), (0.29, 0.58)] {
        let world = World::nominal()
            .with("friction", friction)
            .with("restitution", restitution);
        let simulator = Simulator::new(&rig, &world).expect("valid");
        for speed in [0.4, 0.7, 1.0] {
            let command = Command { speed, angle: 0.2 };
            let stop = simulator
                .worker()
                .strike(ORIGIN, command, &Conditions::default())
                .expect("rests")
                .stop;
            let launch = (1.0 + restitution) * speed;
            let expected = launch * launch / (2.0 * friction * GRAVITY);
            let off = stop.distance(ORIGIN) / expected - 1.0;
            assert!(
                off.abs() < 3e-4,
                "{friction}, {restitution}, {speed}: {off}"
            );
        }
    }
}
