//! Each limit refuses by its own reason, with numbers, and plans nothing.

use std::f64::consts::{FRAC_PI_2, PI};

use store::Model;
use strike::{Plan, Planner, Ramp, Reason, Refusal};
use values::{Point, Rig, Shape};
use world::{AddedEffect, World};

use crate::fixture::{self, FROM, TO, refusal};

/// The refusal of plain sysid, without the residual.
fn check(from: Point, to: Point, reason: Reason, said: &str) {
    let refusal = refusal(&fixture::artifact(), Model::Sysid, from, to);
    assert_eq!(refusal.refused, reason, "{refusal}");
    assert!(refusal.detail.contains(said), "{refusal}");
    assert!(refusal.detail.len() > 30, "says how to mend: {refusal}");
    // NaN is not equal to itself; its text is.
    assert_eq!(format!("{:?}", refusal.from), format!("{:?}", Some(from)));
    assert_eq!(format!("{:?}", refusal.to), format!("{:?}", Some(to)));
}

#[test]
fn numbers_must_be_finite() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        check(Point::new(bad, 0.0), TO, Reason::NotFinite, "`from`");
        check(FROM, Point::new(0.5, bad), Reason::NotFinite, "`to`");
    }
}

#[test]
fn object_and_target_must_be_on_the_table() {
    let off = |from, to, said: &str| check(from, to, Reason::OffTable, said);
    off(Point::new(0.05, 0.0), TO, "`from` (0.0500, 0.0000)");
    off(FROM, Point::new(0.5, 0.61), "[-0.6000, 0.6000]");
    off(FROM, Point::new(1e300, 0.0), "`to` (1e300, 0.0000) is");
}

#[test]
fn a_target_where_the_object_is_cannot_be_reached() {
    check(FROM, FROM, Reason::Unreachable, "0.0 mm");
}

#[test]
fn paths_and_targets_must_be_among_the_trained() {
    let refused = |from, to, said: &str| check(from, to, Reason::OutsideTrainedRegion, said);
    refused(FROM, Point::new(0.32, 0.05), "length in m is 0.0200");
    refused(FROM, Point::new(0.31, 0.565), "bearing in rad is 1.55");
    let (from, to) = (Point::new(0.4, 0.05), Point::new(0.97, 0.05));
    refused(from, to, "target's x in m is 0.9700");
    refused(Point::new(0.3, 0.4), Point::new(0.6, 0.57), "target's y");
}

#[test]
fn a_target_that_no_speed_reaches_is_unreachable() {
    let mut artifact = fixture::artifact();
    // At 4 m/s, the fastest that a solve tries, the object leaves at 1.6 m/s and slides 0.29 m.
    artifact.sysid.world = World::nominal()
        .with("friction", 0.45)
        .with("restitution", -0.6);
    let refusal = refusal(&artifact, Model::Sysid, FROM, Point::new(0.75, 0.05));
    assert_eq!(refusal.refused, Reason::Unreachable);
    assert!(refusal.detail.contains("mm from `to`"), "{refusal}");
}

#[test]
fn a_world_in_which_nothing_rests_diverges() {
    let mut artifact = fixture::artifact();
    let mut world = World::nominal().with("friction", 0.02);
    let tilt = AddedEffect::fixed("table_tilt", &[("tilt_x", 0.1)]);
    world.effects.push(tilt);
    artifact.sysid.world = world;
    let refusal = refusal(&artifact, Model::Sysid, FROM, TO);
    assert_eq!(refusal.refused, Reason::Diverged);
}

#[test]
fn the_speed_must_be_the_arms() {
    check(FROM, Point::new(0.36, 0.05), Reason::SpeedLimit, "farther");
    check(FROM, Point::new(0.94, 0.05), Reason::SpeedLimit, "nearer");
}

#[test]
fn the_final_speed_counts_not_the_simulated_one() {
    let artifact = fixture::artifact();
    // Simulated just below the highest speed, and above it with the residual.
    let planner = Planner::new(&artifact, Model::Sysid).unwrap();
    let to = Point::new(0.745, 0.05);
    let simulated = planner.plan(FROM, to).unwrap().speed;
    let high = artifact.rig.robot.speed.high;
    assert!(
        simulated < high && simulated + fixture::SYSID_RESIDUAL[0] > high,
        "{simulated}"
    );
    let refusal = refusal(&artifact, Model::SysidResidual, FROM, to);
    assert_eq!(refusal.refused, Reason::SpeedLimit);
    assert!(refusal.detail.contains("residual +0.0"), "{refusal}");
}

/// The plan within a rig of its own, in which the arm stands as given.
fn within(change: impl FnOnce(&mut Rig), from: Point, to: Point) -> Result<Plan, Refusal> {
    let artifact = fixture::artifact();
    let mut rig = artifact.rig.clone();
    change(&mut rig);
    let planner = Planner::within(&artifact, Model::Sysid, &rig).unwrap();
    planner.plan(from, to)
}

fn refused(answer: Result<Plan, Refusal>, reason: Reason, said: &str) {
    let refusal = answer.expect_err("refused");
    assert_eq!(refusal.refused, reason, "{refusal}");
    assert!(refusal.detail.contains(said), "{refusal}");
}

#[test]
fn a_start_between_the_base_and_the_tables_edge_needs_an_arm_that_says_where_it_stands() {
    let (from, to) = (Point::new(0.2, 0.0), Point::new(0.55, 0.0));
    refused(within(|_| (), from, to), Reason::Reach, "robot.base");
    let placed = |base: f64| {
        let stand = move |rig: &mut Rig| {
            rig.robot.base = Some(Point::new(base, 0.0));
            rig.robot.keep_out = Some(0.2);
        };
        within(stand, from, to)
    };
    let plan = placed(-0.2).unwrap();
    assert!(plan.start.x < fixture::rig().table.x.low && plan.start.x > 0.0);
    refused(placed(-0.1), Reason::KeepOut, "robot.keep_out is 0.2");
}

#[test]
fn a_strike_that_would_start_at_the_base_is_refused_by_name() {
    // The object's footprint does not even lie on the table at (0.115, 0).
    check(Point::new(0.115, 0.0), TO, Reason::OffTable, "reaches 0.03");
    // On a table that goes up to the base the tip would start 6 mm from the base's axis.
    let table = |rig: &mut Rig| rig.table.x.low = -0.5;
    let answer = within(table, Point::new(0.115, 0.0), Point::new(0.4, 0.0));
    refused(answer, Reason::KeepOut, "robot.keep_out is not stated");
}

#[test]
fn a_run_up_that_does_not_fit_says_which_speed_would() {
    let stiff = |jerk: f64| move |rig: &mut Rig| rig.robot.jerk = Some(jerk);
    let (from, to) = (Point::new(0.3, 0.0), Point::new(0.6, 0.0));
    assert!(within(stiff(100.0), from, to).is_ok());
    let refusal = within(stiff(10.0), from, to).err().unwrap();
    assert_eq!(refusal.refused, Reason::Reach);
    let text = refusal.detail.split("up to ").nth(1).expect("a speed");
    let speed: f64 = text.split(' ').next().unwrap().parse().unwrap();
    // From its start at 0.112 the tip has 0.136 m of run-up: v²·√(v/10) = 0.136² m.
    let fits = |speed: f64| Ramp::to(speed, 5.0, Some(10.0)).length() <= 0.3 - 0.042 - 0.01 - 0.112;
    assert!(fits(speed) && !fits(speed + 0.02), "{speed}");
}

#[test]
fn an_arm_that_brakes_more_slowly_than_the_object_pushes_it_again() {
    let mut artifact = fixture::artifact();
    artifact.rig.robot.acceleration = 2.0;
    artifact.rig.table.x = [-2.0, 2.0].into();
    artifact.rig.robot.base = Some(Point::new(-1.5, 0.0));
    // The object slows down at 4.4 m/s², and leaves hardly faster than the tip.
    artifact.sysid.world = World::nominal()
        .with("friction", 0.45)
        .with("restitution", 0.0);
    let (from, to) = (Point::new(0.3, 0.0), Point::new(0.36, 0.0));
    let answer = refusal(&artifact, Model::Sysid, from, to);
    assert_eq!(answer.refused, Reason::SecondPush, "{answer}");
    artifact.rig.robot.acceleration = 20.0;
    let planner = Planner::new(&artifact, Model::Sysid).unwrap();
    planner.plan(from, to).unwrap();
}

#[test]
fn the_object_lies_where_training_strikes_started() {
    let (from, to) = (Point::new(0.5, 0.0), Point::new(0.8, 0.0));
    let said = "the object's x in m is 0.5000";
    check(from, to, Reason::OutsideTrainedRegion, said);
    // An older version does not state it.
    let mut artifact = fixture::artifact();
    artifact.manifest.provenance.trained_region.start_x = None;
    let planner = Planner::new(&artifact, Model::Sysid).unwrap();
    planner.plan(from, to).unwrap();
}

#[test]
fn a_box_must_not_be_turned_far() {
    let mut artifact = fixture::artifact();
    artifact.rig = Rig::demo(Shape::Box);
    let planner = Planner::new(&artifact, Model::Sysid).unwrap();
    let to = Point::new(0.6, 0.05);
    for yaw in [0.0, 0.2, -FRAC_PI_2 + 0.03, PI] {
        planner.plan_turned(FROM, to, yaw).unwrap();
    }
    for (yaw, reason) in [(0.3, Reason::Turned), (f64::NAN, Reason::NotFinite)] {
        refused(planner.plan_turned(FROM, to, yaw), reason, "in rad");
    }
    // Its face is met as in training.
    artifact.manifest.provenance.trained_region.bearing = [-0.1, 0.1].into();
    let planner = Planner::new(&artifact, Model::Sysid).unwrap();
    planner.plan_turned(FROM, to, 0.08).unwrap();
    let answer = planner.plan_turned(FROM, to, 0.2);
    refused(answer, Reason::OutsideTrainedRegion, "turned box");
    // What is round has no yaw.
    let round = Planner::new(&fixture::artifact(), Model::Sysid).unwrap();
    round.plan_turned(FROM, TO, 0.7).unwrap();
}
