//! Each limit refuses by its own reason, with numbers, and plans nothing.

use store::{Artifact, Model};
use strike::{Planner, Reason, Refusal};
use values::Point;
use world::{AddedEffect, Estimate, World};

use crate::fixture::{self, FROM, TO};

fn refusal(artifact: &Artifact, model: Model, from: Point, to: Point) -> Refusal {
    match Planner::new(artifact, model).unwrap().plan(from, to) {
        Ok(plan) => panic!("planned {plan:?}"),
        Err(refusal) => refusal,
    }
}

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
    check(
        Point::new(0.05, 0.0),
        TO,
        Reason::OffTable,
        "`from` (0.0500, 0.0000)",
    );
    check(
        FROM,
        Point::new(0.5, 0.61),
        Reason::OffTable,
        "[-0.6000, 0.6000]",
    );
    check(
        FROM,
        Point::new(1e300, 0.0),
        Reason::OffTable,
        "`to` (1e300, 0.0000) is",
    );
}

#[test]
fn a_target_where_the_object_is_cannot_be_reached() {
    check(FROM, FROM, Reason::Unreachable, "0.0 mm");
}

#[test]
fn paths_and_targets_must_be_among_the_trained() {
    let refused = |from, to, said: &str| check(from, to, Reason::OutsideTrainedRegion, said);
    refused(FROM, Point::new(0.32, 0.05), "length in m is 0.0200");
    refused(FROM, Point::new(0.31, 0.59), "bearing in rad is 1.55");
    refused(
        Point::new(0.4, 0.05),
        Point::new(0.97, 0.05),
        "target's x in m is 0.9700",
    );
    refused(Point::new(0.3, 0.4), Point::new(0.6, 0.57), "target's y");
}

#[test]
fn a_target_that_no_speed_reaches_is_unreachable() {
    let mut artifact = fixture::artifact();
    // At 4 m/s, the fastest that a solve tries, the object leaves at 1.6 m/s and slides 0.29 m.
    artifact.sysid.world = World::nominal(&artifact.rig)
        .with("friction", 0.45)
        .with("restitution", -0.6);
    let refusal = refusal(&artifact, Model::Sysid, FROM, Point::new(0.75, 0.05));
    assert_eq!(refusal.refused, Reason::Unreachable);
    assert!(refusal.detail.contains("mm from `to`"), "{refusal}");
}

#[test]
fn a_world_in_which_nothing_rests_diverges() {
    let mut artifact = fixture::artifact();
    let mut world = World::nominal(&artifact.rig).with("friction", 0.02);
    world.effects.push(AddedEffect {
        name: "table_tilt".into(),
        parameters: [("tilt_x".to_string(), Estimate::fixed(0.1))].into(),
    });
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

#[test]
fn a_residual_that_moves_the_stop_farther_than_it_was_trained_to_is_refused() {
    let mut artifact = fixture::artifact();
    // Within the arm's limits, and 0.1 m beyond the target.
    artifact.sysid.residual = Some(fixture::constant([0.2, 0.0]));
    let to = Point::new(0.48, 0.08);
    let refused = |artifact: &Artifact| refusal(artifact, Model::SysidResidual, FROM, to);
    let told = refused(&artifact);
    assert_eq!(told.refused, Reason::ResidualTooLarge, "{told}");
    assert!(told.detail.contains("mm from `to`"), "{told}");
    artifact.sysid.residual = Some(fixture::constant([0.28, 0.5]));
    assert_eq!(refused(&artifact).refused, Reason::ResidualTooLarge);
    // Where nobody measured the world alone, a tenth of the path is the most.
    artifact.manifest.provenance.metrics.clear();
    artifact.sysid.residual = Some(fixture::constant(fixture::SYSID_RESIDUAL));
    assert_eq!(refused(&artifact).refused, Reason::ResidualTooLarge);
}

#[test]
fn a_residual_that_moves_the_stop_off_the_table_is_refused() {
    let mut artifact = fixture::artifact();
    artifact.sysid.residual = Some(fixture::constant([0.0, 0.2]));
    let planner = Planner::new(&artifact, Model::SysidResidual).unwrap();
    let from = Point::new(0.3, 0.35);
    assert!(planner.plan(from, Point::new(0.6, 0.5)).is_ok());
    let told = refusal(
        &artifact,
        Model::SysidResidual,
        from,
        Point::new(0.6, 0.548),
    );
    assert_eq!(told.refused, Reason::ResidualTooLarge, "{told}");
    assert!(told.detail.contains("off the table"), "{told}");
}

#[test]
fn the_angle_must_be_the_arms() {
    check(
        Point::new(0.3, -0.1),
        Point::new(0.5, 0.15),
        Reason::AngleLimit,
        "[-0.8000, 0.8000]",
    );
}

#[test]
fn the_tip_must_stay_within_reach() {
    check(
        Point::new(0.11, 0.0),
        Point::new(0.5, 0.0),
        Reason::Reach,
        "`start` (-0.0",
    );
    check(
        Point::new(0.3, -0.55),
        Point::new(0.55, -0.35),
        Reason::Reach,
        "`start`",
    );
}

#[test]
fn a_start_between_the_base_and_the_tables_edge_is_within_reach() {
    let planner = Planner::new(&fixture::artifact(), Model::Sysid).unwrap();
    let plan = planner
        .plan(Point::new(0.2, 0.0), Point::new(0.55, 0.0))
        .unwrap();
    assert!(plan.start.x < fixture::rig().table.x.low && plan.start.x > 0.0);
}
