//! What a plan holds.

use store::Model;
use strike::Planner;
use values::{Command, Conditions, Point};
use world::{Profile, Simulator, World};

use crate::fixture::{self, FROM, TO, plan};

#[test]
fn the_simulated_command_brings_the_object_to_the_target_in_its_world() {
    let artifact = fixture::artifact();
    for (model, world) in [
        (Model::Nominal, World::nominal()),
        (Model::SysidResidual, artifact.sysid.world.clone()),
        (
            Model::Effect,
            artifact.effect.as_ref().unwrap().world.clone(),
        ),
    ] {
        let plan = plan(model);
        let simulator = Simulator::new(&artifact.rig, &world).unwrap();
        let command = Command::new(plan.speed_sim, plan.angle_sim);
        let stop = simulator
            .worker()
            .strike(FROM, command, &Conditions::default())
            .unwrap()
            .stop;
        assert!(stop.distance(TO) < 1e-3, "{model:?}: {stop:?}");
    }
}

#[test]
fn the_tip_moves_on_the_profile_of_the_final_command() {
    let plan = plan(Model::SysidResidual);
    let rig = fixture::rig();
    let standoff = rig.object.solid.reach() + rig.striker.radius;
    let profile = Profile::plan(FROM, plan.command(), rig.robot.acceleration, standoff);
    for (planned, expected) in [
        (plan.start, profile.start),
        (plan.pre_strike, profile.pre_strike),
        (plan.strike, profile.strike),
        (plan.stop, profile.stop),
    ] {
        assert!(planned.distance(expected) < 1e-9);
    }
    assert!((plan.stroke().t_stop - profile.t_stop).abs() < 1e-9);
    assert_eq!(plan.path, TO - FROM);
    assert_eq!(plan.acceleration, rig.robot.acceleration);
}

#[test]
fn a_plan_does_not_depend_on_what_was_planned_before() {
    let planner = Planner::new(&fixture::artifact(), Model::Sysid).unwrap();
    let first = planner.plan(FROM, TO).unwrap();
    planner
        .plan(Point::new(0.25, -0.1), Point::new(0.6, -0.05))
        .unwrap();
    assert_eq!(planner.plan(FROM, TO).unwrap(), first);
}

#[test]
fn a_plan_states_its_artifact_and_what_to_expect() {
    let plan = plan(Model::Sysid);
    assert_eq!(plan.artifact, "v0001");
    // A version that does not say how its table varies: as held-out strikes missed, and what is assumed of every table.
    let metrics = fixture::artifact().manifest.provenance.metrics;
    let known = metrics[&Model::Sysid];
    let miss = plan.expected_miss.unwrap();
    let held_out = known.mean.hypot(known.sd);
    assert!(
        miss > held_out && miss < 1.2 * held_out,
        "{miss} {held_out}"
    );
    assert_eq!(plan.expected_miss_strikes, Some(known.n));
    assert!(plan.if_as_before && plan.adapted.is_none());
}

#[test]
fn a_model_that_the_artifact_lacks_is_reported_with_those_it_has() {
    let mut artifact = fixture::artifact();
    artifact.effect = None;
    let error = Planner::new(&artifact, Model::Effect).err().unwrap();
    let text = error.to_string();
    assert!(
        text.contains("`effect`") && text.contains("nominal, sysid, sysid_residual"),
        "{text}"
    );
}
