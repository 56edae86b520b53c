//! Strikes in the embedded rig, and the logs that they leave.

use std::fs;
use std::path::Path;
use std::time::Duration;

use durable::Lock;
use ingest::{Ingest, ingest_log};
use rig::{Hidden, Truth};
use serde_json::Value;
use values::{Point, Strike};

use crate::commands::{command, stderr, stdout, strike};
use crate::fixture;

const STRIKE: [&str; 9] = [
    "--from", "0.3", "0.05", "--to", "0.6", "0.1", "--json", "--robot", "sim",
];

/// A strike with a log of this name.
fn into(log: &Path) -> Vec<&str> {
    [STRIKE.as_slice(), &["--log", log.to_str().unwrap()]].concat()
}

fn answer(artifacts: &Path, arguments: &[&str]) -> Value {
    let output = strike(artifacts, arguments);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The one strike of a log, as the next run ingests it.
fn read(log: &Path) -> Strike {
    let outcome = ingest_log(log, &fixture::rig(), &Ingest::default()).unwrap();
    assert!(outcome.whole);
    assert_eq!(outcome.rejects, []);
    let [strike] = outcome.strikes.try_into().unwrap();
    strike
}

fn point(value: &Value) -> Point {
    serde_json::from_value(value.clone()).unwrap()
}

#[test]
fn the_next_run_ingests_a_strike_as_it_was_commanded_and_seen() {
    let dir = fixture::published();
    let answer = answer(dir.path(), &STRIKE);
    let log = dir.path().join("strikes/strike_000001.mcap");
    assert_eq!(answer["log"], log.to_str().unwrap());
    let strike = read(&log);
    let lineages = logs::write::lineages(&log).unwrap();
    let [lineage] = &lineages[..] else {
        panic!("{lineages:?}");
    };
    assert_eq!(lineage["version"], answer["artifact"].as_str().unwrap());
    assert_eq!(lineage["model"], answer["model"].as_str().unwrap());
    assert_eq!(lineage["manifest"].len(), 64);
    assert_eq!(lineage["robot_answered"], "struck");
    let plan: serde_json::Value = serde_json::from_str(&lineage["plan"]).unwrap();
    assert_eq!(plan["speed"], answer["speed"]);
    assert!((strike.command.speed - answer["speed"].as_f64().unwrap()).abs() < 1e-6);
    assert!((strike.command.angle - answer["angle"].as_f64().unwrap()).abs() < 1e-6);
    // What the camera saw, within its noise.
    let seen_at = |key: &str, seen: Point| {
        let there = point(&answer[key]);
        assert!(seen.distance(there) < 0.002, "{key} {there:?}: {seen:?}");
    };
    seen_at("from", strike.initial);
    seen_at("stopped", strike.stop);
    let miss = point(&answer["stopped"]).distance(point(&answer["to"]));
    assert!((miss - answer["miss"].as_f64().unwrap()).abs() < 1e-12);
}

#[test]
fn the_demos_default_rig_is_not_struck_in_silence() {
    let dir = fixture::published();
    let printed = |more: &[&str]| {
        let output = strike(dir.path(), &[&STRIKE, more].concat());
        stderr(&output).to_owned()
    };
    assert!(printed(&[]).contains("no truth.json"));
    assert!(!printed(&["--quiet"]).contains("no truth.json"));
}

#[test]
fn each_strike_has_a_log_and_a_scatter_of_its_own() {
    let dir = fixture::published();
    let folder = dir.path().join("strikes");
    let stops: Vec<_> = (0..3)
        .map(|_| answer(dir.path(), &STRIKE)["stopped"].clone())
        .collect();
    assert!(stops[0] != stops[1] && stops[1] != stops[2]);
    let starts =
        [1, 2, 3].map(|number| read(&folder.join(format!("strike_{number:06}.mcap"))).t_start);
    assert!(starts.is_sorted(), "stamps run on: {starts:?}");
    assert_eq!(fs::read_dir(folder).unwrap().count(), 3);
}

#[test]
fn a_named_log_is_written_once() {
    let dir = fixture::published();
    let log = dir.path().join("one.mcap");
    let arguments = into(&log);
    answer(dir.path(), &arguments);
    let written = fs::read(&log).unwrap();
    let again = strike(dir.path(), &arguments);
    assert_eq!(again.status.code(), Some(2));
    assert!(stderr(&again).contains("never overwritten"));
    assert_eq!(fs::read(&log).unwrap(), written);
    assert!(!dir.path().join("strikes").exists());
}

#[test]
fn a_strike_with_a_named_log_has_a_scatter_of_its_own() {
    let dir = fixture::published();
    let struck = |name: &str| {
        let log = dir.path().join(name);
        let arguments = into(&log);
        (
            answer(dir.path(), &arguments)["stopped"].clone(),
            read(&log),
        )
    };
    let (one, two) = (struck("one.mcap"), struck("two.mcap"));
    assert_ne!(one.0, two.0);
    assert_ne!(one.1.id, two.1.id, "the next run takes both");
    assert!(one.1.t_start < two.1.t_start, "stamps run on");
}

#[test]
fn a_strike_whose_log_is_taken_while_it_is_made_is_kept_and_reported() {
    let dir = fixture::published();
    let log = dir.path().join("one.mcap");
    // The program waits for the lock of the count once its log is open: the name is taken then.
    let lock = Lock::acquire(&dir.path().join(".struck.lock")).unwrap();
    let arguments = into(&log);
    let child = command(dir.path(), &arguments).spawn().unwrap();
    let is_open = || {
        let names = fs::read_dir(dir.path()).unwrap().flatten();
        let names: Vec<_> = names.map(|entry| entry.file_name()).collect();
        names
            .iter()
            .any(|name| name.to_string_lossy().starts_with(".strike."))
    };
    while !is_open() {
        std::thread::sleep(Duration::from_millis(1));
    }
    fs::write(&log, "mine").unwrap();
    drop(lock);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(answer["miss"].as_f64().unwrap() > 0.0, "{answer}");
    assert!(answer["log_moved"].as_str().unwrap().contains("one.mcap"));
    let kept = dir.path().join("one_2.mcap");
    assert_eq!(answer["log"], kept.to_str().unwrap());
    read(&kept);
    assert_eq!(fs::read(&log).unwrap(), b"mine");
}

#[test]
fn the_rig_of_a_folder_is_the_one_that_is_struck() {
    let dir = fixture::published();
    let truth = Truth {
        hidden: Hidden::default(),
        friction: 0.5,
        ..Truth::demo(&fixture::rig(), 3)
    };
    fs::write(dir.path().join("truth.json"), truth.to_json()).unwrap();
    let rough = point(&answer(dir.path(), &STRIKE)["stopped"]);
    let elsewhere = tempfile::tempdir().unwrap();
    let smooth = Truth {
        friction: 0.2,
        ..truth
    };
    fs::write(elsewhere.path().join("truth.json"), smooth.to_json()).unwrap();
    let robot = format!("sim:{}", elsewhere.path().display());
    let arguments = [&STRIKE[..8], &[robot.as_str()]].concat();
    let smooth = point(&answer(dir.path(), &arguments)["stopped"]);
    assert!(rough.x + 0.1 < smooth.x, "{rough:?} {smooth:?}");
}

#[test]
fn a_rig_that_the_plan_was_not_made_for_is_not_struck() {
    let dir = fixture::published();
    let mut rig = fixture::rig();
    rig.object.mass = 0.5;
    let truth = Truth::demo(&rig, 1).to_json();
    fs::write(dir.path().join("truth.json"), truth).unwrap();
    let output = strike(dir.path(), &STRIKE);
    assert_eq!(output.status.code(), Some(4));
    let printed = stderr(&output);
    assert!(printed.contains("nothing has moved"), "{printed}");
    let refusal: Value = serde_json::from_str(stdout(&output)).unwrap();
    assert_eq!(refusal["refused"], "not_ready");
    assert_eq!(refusal["to"], serde_json::json!([0.6, 0.1]));
    let logs = fs::read_dir(dir.path().join("strikes"));
    assert_eq!(logs.map_or(0, Iterator::count), 0, "no log");
}

#[test]
fn a_truth_that_cannot_be_read_is_reported() {
    let dir = fixture::published();
    let output = strike(dir.path(), &[&STRIKE[..8], &["sim:/none/such"]].concat());
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("/none/such/truth.json"));
    let answer: Value = serde_json::from_str(stdout(&output)).unwrap();
    assert!(answer["failed"].as_str().unwrap().contains("/none/such"));
}
