//! What differs from session to session: one that is known, one that was never seen, and one of which a few strikes are known.

use std::process::Command;

use rig::{Hidden, Sim, Truth};
use store::{Artifact, Model};
use strike::{Destination, OpenLog, Plan, Planner, Recent, Robot, SimRobot, TruthSource};
use values::{Point, Shape, Strike};
use world::{AddedEffect, World};

use crate::fixture::{self, FROM, TO};

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
    artifact(vec![AddedEffect::fixed("friction_by_session", &changes)])
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
    let known = expected(&known.unwrap());
    let held_out = metrics.mean.hypot(metrics.sd);
    assert!((1.0..1.2).contains(&(known / held_out)), "{known}");
    // A third more friction than the mean, one standard deviation, stops an object a third short, to first order.
    let path = TO.distance(FROM);
    let unknown = expected(&effect(&artifact));
    assert!((0.3..0.4).contains(&(unknown / path)), "{unknown}");
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
    let artifact = artifact(vec![AddedEffect::fixed("camera_distortion", &bent)]);
    let mut own = artifact.rig.clone();
    own.camera.centre = Point::new(0.3, 0.1);
    let there = Planner::within(&artifact, Model::Effect, &own).unwrap();
    assert_eq!(plan(&there).speed, plan(&effect(&artifact)).speed);
}

/// The embedded rig with the fixture's own friction and restitution, times this factor on friction, and a good arm.
fn truth(friction: f64) -> Truth {
    let mut truth = Truth::demo(&fixture::rig(), 3);
    truth.hidden = Hidden::none();
    (truth.friction, truth.restitution) = (0.25 * friction, 0.5);
    (truth.scatter.speed, truth.scatter.angle) = (0.002, 0.001);
    truth
}

fn struck(dir: &std::path::Path, friction: f64, place: usize) -> Strike {
    let rig = fixture::rig();
    let truth = truth(friction);
    let mut sim = Sim::from(truth).unwrap().after(place);
    let speed = 0.6 + 0.05 * place as f64;
    let recording = sim.strike(
        Point::new(0.25, 0.0),
        values::Command { speed, angle: 0.05 },
    );
    let path = dir.join(format!("{friction}_{place}.mcap"));
    let log = OpenLog::open(Destination::File(path.clone())).unwrap();
    log.write(&recording.samples, &rig.topics).unwrap();
    let outcome = ingest::ingest_log(&path, &rig, &ingest::Ingest::default()).unwrap();
    ingest::assemble(vec![outcome]).0.remove(0)
}

#[test]
fn plans_follow_a_table_whose_friction_changed_and_none_is_made_for_another_table() {
    let dir = tempfile::tempdir().unwrap();
    // The rig's own table in the executor's world: what is compared is its change.
    let artifact = fixture::artifact();
    let planner = Planner::new(&artifact, Model::Sysid).unwrap();
    let seen = |friction: f64, strikes: usize| {
        let strikes: Vec<Strike> = (0..strikes)
            .map(|i| struck(dir.path(), friction, i))
            .collect();
        let mut recent = planner.recent();
        planner
            .follow(&artifact, &mut recent, &strikes)
            .map(|()| recent)
    };
    let usual = seen(1.0, 6).unwrap();
    let slower = seen(1.15, 6).unwrap();
    let by = slower.filter().mean().friction - usual.filter().mean().friction;
    assert!((by - 1.15f64.ln()).abs() < 0.05, "{by}");
    let plan_after = |recent: &Recent| {
        let planner = Planner::new(&artifact, Model::Sysid).unwrap();
        planner.adapted(recent, true).plan(FROM, TO).unwrap()
    };
    let (usual, slower) = (plan_after(&usual), plan_after(&slower));
    assert!(
        slower.speed > 1.04 * usual.speed,
        "{} {}",
        slower.speed,
        usual.speed
    );
    assert!(!slower.if_as_before);
    assert_eq!(slower.adapted.unwrap().strikes, 6);
    let error = seen(2.2, 4).err().unwrap().to_string();
    assert!(error.contains("carom collect"), "{error}");
}

#[test]
fn recent_logs_are_read_on_the_command_line_and_own_strikes_by_themselves() {
    let dir = fixture::published();
    std::fs::create_dir(dir.path().join("rig")).unwrap();
    std::fs::write(dir.path().join("rig/truth.json"), truth(1.0).to_json()).unwrap();
    let run = |more: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_strike"))
            .args(["--artifacts", dir.path().to_str().unwrap(), "--quiet"])
            .args(["--from", "0.3", "0.05", "--to", "0.6", "0.1"])
            .args(more)
            .output()
            .unwrap();
        let error = String::from_utf8(output.stderr).unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        (output.status.code(), error, text)
    };
    let log = dir.path().join("new.mcap");
    let log = log.to_str().unwrap();
    assert_eq!(run(&["--robot", "sim", "--log", log]).0, Some(0));
    let (code, error, text) = run(&["--recent", log, "--model", "sysid"]);
    assert_eq!((code, error), (Some(0), String::new()));
    assert!(text.contains("by 1 recent strikes: friction"), "{text}");
    let (code, error, _) = run(&["--recent", "nowhere.mcap"]);
    assert!(code == Some(2) && error.contains("nowhere.mcap"), "{error}");
    let (code, error, _) = run(&["--session", "friday.mcap"]);
    assert!(code == Some(2) && error.contains("friday.mcap"), "{error}");
    // Of its own strikes nothing is known before the first; then each plan stands on all.
    for strikes in 0..3 {
        let (code, error, text) = run(&["--adapt", "--robot", "sim", "--model", "sysid"]);
        assert_eq!((code, error.as_str()), (Some(0), ""));
        let said = text.contains(&format!("by {strikes} recent strikes"));
        assert_eq!(said, strikes > 0, "{text}");
        assert_eq!(text.contains("if the table is as it was"), strikes == 0);
    }
    let kept = dir.path().join("strikes/adapted.json");
    let before = std::fs::read(&kept).unwrap();
    // Another model, as another version, begins anew, from the same logs.
    let (code, _, text) = run(&["--adapt", "--model", "effect"]);
    assert!(
        code == Some(0) && text.contains("by 3 recent strikes"),
        "{text}"
    );
    assert_ne!(std::fs::read(&kept).unwrap(), before);
    // What rotted on the disk is not believed, a copy of a log shows nothing new, and a cut one is told.
    let again = || run(&["--adapt", "--model", "effect"]);
    let rotten = std::fs::read_to_string(&kept).unwrap();
    let (start, digit) = (rotten.find("\"mean\":[").unwrap() + 8, '7');
    std::fs::write(
        &kept,
        rotten[..start].to_owned() + &digit.to_string() + &rotten[start..],
    )
    .unwrap();
    assert_eq!(again().2, text);
    let own = dir.path().join("strikes/strike_000001.mcap");
    std::fs::copy(&own, own.with_file_name("strike_000004.mcap")).unwrap();
    assert_eq!(again().2, text);
    let bytes = std::fs::read(&own).unwrap();
    std::fs::write(
        own.with_file_name("strike_000005.mcap"),
        &bytes[..bytes.len() / 2],
    )
    .unwrap();
    let (code, error, said) = again();
    assert!(
        code == Some(0) && said == text && error.contains("strike_000005.mcap"),
        "{error}"
    );
}
