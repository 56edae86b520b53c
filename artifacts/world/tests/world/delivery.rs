//! A correction of what the arm delivers.

use std::sync::Arc;

use values::{Command, Conditions, Point, Rig, Shape};
use world::{AddedEffect, AsCommanded, Delivery, Simulator, SolveSettings, SolveStatus, World};

/// A tenth faster and 0.05 rad further left than the effects say.
struct Off;

impl Delivery for Off {
    fn deliver(&self, commanded: Command, by_effects: &dyn Fn(Command) -> Command) -> Command {
        let by_effects = by_effects(commanded);
        Command::new(1.1 * by_effects.speed, by_effects.angle + 0.05)
    }
}

const START: Point = Point { x: 0.3, y: 0.0 };

fn rig() -> Rig {
    Rig::demo(Shape::Cylinder)
}

fn stop(simulator: &Simulator, speed: f64, angle: f64) -> Point {
    let command = Command { speed, angle };
    let strike = simulator
        .worker()
        .strike(START, command, &Conditions::default());
    strike.expect("rests").stop
}

#[test]
fn a_correction_acts_after_the_effects() {
    let mut world = World::nominal();
    world
        .effects
        .push(AddedEffect::fixed("striker_speed_error", &[("slope", 0.8)]));
    let plain = Simulator::new(&rig(), &World::nominal()).expect("valid");
    let corrected = Simulator::new(&rig(), &world)
        .expect("valid")
        .with_delivery(Arc::new(Off));
    let expected = stop(&plain, 0.7 * 0.8 * 1.1, 0.15);
    assert!(stop(&corrected, 0.7, 0.1).distance(expected) < 1e-6);
    let as_told = Simulator::new(&rig(), &world)
        .expect("valid")
        .with_delivery(Arc::new(AsCommanded));
    assert!(stop(&as_told, 0.7, 0.1).distance(stop(&plain, 0.7, 0.1)) < 1e-6);
}

#[test]
fn a_solve_takes_the_correction_into_account() {
    let corrected = Simulator::new(&rig(), &World::nominal())
        .expect("valid")
        .with_delivery(Arc::new(Off));
    let target = START + Point::polar(0.25, 0.2);
    let conditions = Conditions::default();
    let settings = SolveSettings::default();
    let solution = corrected
        .worker()
        .solve(START, target, &conditions, &settings, None);
    assert_eq!(solution.status, SolveStatus::Solved);
    let Command { speed, angle } = solution.command;
    assert!(stop(&corrected, speed, angle).distance(target) < 1e-3);
}
