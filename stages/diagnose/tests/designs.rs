//! What a diagnosis makes of designs that a laboratory starts with, and of what depends on the start or on the order of strikes.

#[expect(
    dead_code,
    reason = "other tests use the other kinds of noise and forms"
)]
#[path = "support/table.rs"]
mod table;

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

#[test]
fn the_floor_is_what_repeats_of_one_command_scatter_by_where_they_stop() {
    let table = Table {
        plan: Plan::OneCommand,
        noise: Noise::Ideal,
        hidden: vec![Hidden::Nothing],
        strikes: 100,
        seed: 64,
    };
    let (_, strikes) = table.strike();
    let paths: Vec<Point> = strikes.iter().map(|strike| strike.path()).collect();
    let count = paths.len() as f64;
    let mean = paths.iter().fold(Point::default(), |sum, p| sum + *p) * count.recip();
    let squares: f64 = paths.iter().map(|p| (*p - mean).dot(*p - mean)).sum();
    let scatter = (squares / (count - 1.0)).sqrt();
    let found = table.diagnosed();
    // Counted from a track's first frame, a slide is 15 % and more too short, and so is the floor.
    let ratio = found.gap.noise_floor / scatter;
    assert!((0.92..1.08).contains(&ratio), "{ratio}");
}
