//! What differs from session to session: one that is known, one that was never seen, and one of which a few strikes are known.

use std::process::Command;

use rig::Hidden;
use store::{Artifact, Model};
use strike::{Plan, Planner, Robot, SimRobot, TruthSource};
use values::{Point, Shape};
use world::{AddedEffect, Estimate, World};

use crate::fixture::{self, FROM, TO};

fn added(name: &str, parameters: &[(&str, f64)]) -> AddedEffect {
    AddedEffect {
        name: name.into(),
        parameters: parameters
            .iter()
            .map(|(name, value)| (name.to_string(), Estimate::fixed(*value)))
            .collect(),
    }
}

/// The artifact with these effects in place of its own.
fn artifact(effects: Vec<AddedEffect>) -> Artifact {
    let mut artifact = fixture::artifact();
    let effect = artifact.effect.as_mut().unwrap();
    effect.world = World {
        effects,
        ..effect.world.clone()
    }
    .with_populations();
    artifact
}

/// Friction 20 % higher and lower than the mean of two sessions.
fn two_sessions() -> Artifact {
    let changes = [("monday.mcap", 0.2), ("tuesday.mcap", -0.2)];
    artifact(vec![added("friction_by_session", &changes)])
}

fn plan(planner: &Planner) -> Plan {
    planner.plan(FROM, TO).unwrap()
}

fn effect(artifact: &Artifact) -> Planner {
    Planner::new(artifact, Model::Effect).unwrap()
}

#[test]
fn a_session_that_was_never_seen_is_planned_with_the_mean() {
    let artifact = two_sessions();
    let mean = Planner::new(&artifact, Model::Sysid).unwrap();
    let unknown = plan(&effect(&artifact));
    assert!((unknown.speed - plan(&mean).speed).abs() < 1e-6);
    let known = |name| plan(&effect(&artifact).in_session(&artifact, name).unwrap()).speed;
    assert!(known("monday.mcap") > 1.08 * unknown.speed);
    assert!(known("tuesday.mcap") < 0.92 * unknown.speed);
}

#[test]
fn the_expected_miss_counts_the_scatter_between_sessions() {
    let mut artifact = two_sessions();
    let metrics = artifact.manifest.provenance.metrics[&Model::Sysid];
    let provenance = &mut artifact.manifest.provenance;
    provenance.metrics.insert(Model::Effect, metrics);
    let expected = |planner: &Planner| plan(planner).expected_miss.unwrap();
    let known = effect(&artifact).in_session(&artifact, "monday.mcap");
    assert_eq!(expected(&known.unwrap()), metrics.mean);
    // A third more friction than the mean, one standard deviation, stops an object a quarter short.
    let path = TO.distance(FROM);
    let unknown = expected(&effect(&artifact));
    assert!((0.12..0.3).contains(&(unknown / path)), "{unknown}");
}

#[test]
fn a_session_that_the_version_does_not_know_is_no_name_for_one() {
    let artifact = two_sessions();
    let error = effect(&artifact).in_session(&artifact, "friday.mcap");
    let error = error.err().unwrap().to_string();
    assert!(error.contains("`friday.mcap`") && error.contains("monday.mcap, tuesday.mcap"));
    let plain = fixture::artifact();
    let error = effect(&plain).in_session(&plain, "monday.mcap");
    let error = error.err().unwrap().to_string();
    assert!(
        error.contains("nothing that it named differs by session"),
        "{error}"
    );
}

#[test]
fn the_embedded_rig_strikes_in_a_session_that_was_logged_or_in_a_new_one() {
    let dir = tempfile::tempdir().unwrap();
    let hidden = Hidden::parse(&["friction_by_session=0.2"]).unwrap();
    let settings = rig::demo::Settings {
        sessions: Some(2),
        ..rig::demo::Settings::new(Shape::Cylinder, 6, 3, Some(hidden))
    };
    let truth = rig::demo::write(&settings, dir.path()).unwrap().truth;
    let plan = plan(&effect(&fixture::artifact()));
    let path = |session: Option<&str>| {
        let source = TruthSource::File(&truth);
        let mut robot = SimRobot::open(&fixture::rig(), source, 0, session)?;
        let stop = robot.strike(&plan)?.unwrap().stop.unwrap();
        Ok::<_, strike::RobotError>(stop.distance(FROM))
    };
    // The rig's own series of friction: 1.2, 0.93, 0.85 times the usual one; launches scatter alike.
    let [first, second, new] = [
        path(Some("session_000.mcap")).unwrap(),
        path(Some("session_001.mcap")).unwrap(),
        path(None).unwrap(),
    ];
    assert!(
        (second / first - 1.2 / 0.93).abs() < 0.05,
        "{first} {second}"
    );
    assert!((new / first - 1.2 / 0.85).abs() < 0.05, "{first} {new}");
    for other in ["session_002.mcap", "monday.mcap"] {
        let error = path(Some(other)).expect_err(other).to_string();
        assert!(error.contains(other), "{error}");
    }
}

#[test]
fn another_centre_of_the_camera_in_the_robots_own_rig_file_changes_no_plan() {
    let bent = [("k1", 0.15), ("center_x", 0.45), ("center_y", 0.0)];
    let artifact = artifact(vec![added("camera_distortion", &bent)]);
    let mut own = artifact.rig.clone();
    own.camera.centre = Point::new(0.3, 0.1);
    let there = Planner::within(&artifact, Model::Effect, &own).unwrap();
    assert_eq!(plan(&there).speed, plan(&effect(&artifact)).speed);
}

#[test]
fn recent_logs_of_a_new_session_are_read_on_the_command_line() {
    let dir = fixture::published();
    let run = |more: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_strike"))
            .args(["--artifacts", dir.path().to_str().unwrap(), "--quiet"])
            .args(["--from", "0.3", "0.05", "--to", "0.6", "0.1"])
            .args(more)
            .output()
            .unwrap();
        let error = String::from_utf8(output.stderr).unwrap();
        (output.status.code(), error)
    };
    let log = dir.path().join("new.mcap");
    let log = log.to_str().unwrap();
    assert_eq!(run(&["--robot", "sim", "--log", log]).0, Some(0));
    assert_eq!(run(&["--recent", log]), (Some(0), String::new()));
    let (code, error) = run(&["--recent", "nowhere.mcap"]);
    assert!(code == Some(2) && error.contains("nowhere.mcap"), "{error}");
    let (code, error) = run(&["--session", "friday.mcap"]);
    assert!(code == Some(2) && error.contains("friday.mcap"), "{error}");
}
