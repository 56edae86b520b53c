//! What a diagnosis makes of designs that a laboratory starts with, and of what depends on the start or on the order of strikes.

#[expect(
    dead_code,
    reason = "other tests use the other kinds of noise and forms"
)]
#[path = "support/table.rs"]
mod table;

use std::collections::BTreeMap;

use diagnose::{Diagnosis, Verdict};
use table::{Hidden, Noise, Plan, Table};
use values::Point;

fn diagnosed(plan: Plan, hidden: Hidden, seed: u64) -> Diagnosis {
    let table = Table {
        plan,
        noise: Noise::Ideal,
        hidden: vec![hidden],
        strikes: 100,
        seed,
    };
    table.diagnosed()
}

#[test]
fn a_narrow_design_is_no_gap() {
    for plan in [
        Plan::OneAngle,
        Plan::OneSpeed,
        Plan::OneCommand,
        Plan::OneStart,
        Plan::Grid,
        Plan::Sweep,
    ] {
        let found = diagnosed(plan, Hidden::Nothing, 61);
        assert_eq!(
            found.verdict,
            Verdict::Consistent,
            "{plan:?}: {}",
            found.summary
        );
    }
}

#[test]
fn an_arm_whose_speed_depends_on_its_reach_is_no_table() {
    let found = diagnosed(Plan::Random, Hidden::Reach(0.9), 62);
    assert_eq!(found.verdict, Verdict::Named, "{}", found.summary);
    let names: Vec<&str> = found.effects.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(names, ["striker_error_by_place"], "{}", found.summary);
    let by_start = found.r#where.iter().any(|w| w.covariate == "start");
    assert!(by_start, "{:?}", found.r#where);
}

#[test]
fn friction_that_steps_or_cycles_with_the_order_is_no_wander() {
    for hidden in [Hidden::StepInOrder(0.12), Hidden::CycleInOrder(0.12, 20.0)] {
        let found = diagnosed(Plan::Random, hidden, 63);
        assert_ne!(
            found.verdict,
            Verdict::Consistent,
            "{hidden:?}: {}",
            found.summary
        );
        let by_order = found.r#where.iter().any(|w| w.covariate == "order");
        assert!(by_order, "{:?}", found.r#where);
    }
}

#[test]
fn a_wander_has_no_name_whatever_wanders_and_where_commands_follow_the_order() {
    for (plan, hidden) in [
        (Plan::Random, Hidden::LaunchWander(0.006)),
        (Plan::OneAngle, Hidden::LaunchWander(0.006)),
        (Plan::Sweep, Hidden::Wander(0.01)),
    ] {
        for seed in 90..94 {
            let found = diagnosed(plan, hidden, seed);
            assert_ne!(
                found.verdict,
                Verdict::Named,
                "{plan:?} {seed}: {}",
                found.summary
            );
        }
    }
}

#[test]
fn strikes_of_two_objects_are_two_groups_and_no_scatter() {
    for plan in [Plan::Random, Plan::OneCommand] {
        let found = diagnosed(plan, Hidden::TwoObjects(0.3), 64);
        assert_eq!(found.verdict, Verdict::Unexplained, "{}", found.summary);
        assert!(found.summary.contains("two groups"), "{}", found.summary);
    }
}

#[test]
fn what_changes_with_the_command_halfway_or_waves_over_the_table_is_no_scatter() {
    for hidden in [Hidden::GainHalfway(0.7), Hidden::Ripple(0.8)] {
        let found = diagnosed(Plan::Random, hidden, 65);
        assert_eq!(
            found.verdict,
            Verdict::Unexplained,
            "{hidden:?}: {}",
            found.summary
        );
    }
}

#[test]
fn what_a_spin_or_a_clock_does_is_not_given_the_names_of_a_table_that_does_nearly_the_same() {
    for (hidden, cause) in [
        (Hidden::Curl(0.2), "curl to the left"),
        (Hidden::SlowingClock(0.06), "clock"),
        (Hidden::Stretched(0.08), "the camera shows lengths"),
        (Hidden::LensHalfway(1.0), "acts in some part of the strikes"),
        (Hidden::Backlash(0.04), "the command of the strike before"),
    ] {
        let found = diagnosed(Plan::Random, hidden, 66);
        assert_eq!(
            found.verdict,
            Verdict::Unexplained,
            "{hidden:?}: {}",
            found.summary
        );
        assert!(found.summary.contains(cause), "{}", found.summary);
    }
}

/// What repeats of a command scatter by where they stop, and the floor that a diagnosis states.
fn scatter_and_floor(plan: Plan, noise: Noise, hidden: Hidden) -> (f64, Diagnosis) {
    let table = Table {
        plan,
        noise,
        hidden: vec![hidden],
        strikes: 100,
        seed: 64,
    };
    let (_, strikes) = table.strike();
    let mut paths: BTreeMap<[u64; 2], Vec<Point>> = BTreeMap::new();
    for strike in &strikes {
        let command = [strike.command.speed, strike.command.angle].map(f64::to_bits);
        paths.entry(command).or_default().push(strike.path());
    }
    let away = |paths: &Vec<Point>| {
        let sum = paths.iter().fold(Point::default(), |sum, p| sum + *p);
        let mean = sum * (paths.len() as f64).recip();
        paths
            .iter()
            .map(|p| (*p - mean).dot(*p - mean))
            .sum::<f64>()
    };
    let squares: f64 = paths.values().map(away).sum();
    let scatter = (squares / (strikes.len() - paths.len()) as f64).sqrt();
    (scatter, table.diagnosed())
}

#[test]
fn the_floor_is_what_repeats_of_one_command_scatter_by_where_they_stop() {
    let (scatter, found) = scatter_and_floor(Plan::OneCommand, Noise::Ideal, Hidden::Nothing);
    // Counted from a track's first frame, a slide is 15 % and more too short, and so is the floor.
    let ratio = found.gap.noise_floor / scatter;
    assert!((0.92..1.08).contains(&ratio), "{ratio}");
}

#[test]
fn what_slows_objects_beside_friction_takes_of_what_repeats_scatter_by() {
    let (scatter, found) = scatter_and_floor(Plan::Grid, Noise::Friction(0.06), Hidden::Drag(1.0));
    assert_eq!(found.effects.len(), 1, "{}", found.summary);
    // Were friction and launch to move stops as they do without drag, it would be 1.3 and more.
    let ratio = found.gap.noise_floor / scatter;
    assert!((0.9..1.1).contains(&ratio), "{ratio}");
}

#[test]
fn what_changed_once_is_not_in_the_floor() {
    let (scatter, _) = scatter_and_floor(Plan::Grid, Noise::Ideal, Hidden::Nothing);
    let (_, found) = scatter_and_floor(Plan::Grid, Noise::Ideal, Hidden::TurnedHalfway(0.1));
    assert_eq!(found.verdict, Verdict::Unexplained, "{}", found.summary);
    let ratio = found.gap.noise_floor / scatter;
    assert!((0.8..1.25).contains(&ratio), "{ratio}");
}
