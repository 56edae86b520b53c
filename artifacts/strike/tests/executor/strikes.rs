//! Strikes in the embedded rig, and the logs that they leave.

use std::fs;
use std::path::Path;

use logs::{Event, Limits, Sample, Wanted};
use rig::{Hidden, Truth};
use serde_json::Value;
use values::Point;

use crate::commands::{stderr, strike};
use crate::fixture;

const STRIKE: [&str; 9] = [
    "--from", "0.3", "0.05", "--to", "0.6", "0.1", "--json", "--robot", "sim",
];

fn answer(artifacts: &Path, arguments: &[&str]) -> Value {
    let output = strike(artifacts, arguments);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Centroids and commands of a log.
fn read(log: &Path) -> (Vec<Sample>, Vec<Sample>) {
    let topics = fixture::rig().topics;
    let wanted = [&topics.centroid, &topics.command].map(|topic| Wanted {
        topic,
        required: true,
    });
    let (mut centroids, mut commands) = (Vec::new(), Vec::new());
    let summary = logs::read(log, &wanted, Limits::default(), &mut |event| match event {
        Event::Sample(0, sample) => centroids.push(sample),
        Event::Sample(_, sample) => commands.push(sample),
        Event::Lost(damage) => panic!("{damage:?}"),
    })
    .unwrap();
    assert!(summary.damage.is_empty());
    (centroids, commands)
}

fn point(value: &Value) -> Point {
    serde_json::from_value(value.clone()).unwrap()
}

#[test]
fn a_strike_is_logged_as_it_was_commanded_and_seen() {
    let dir = fixture::published();
    let answer = answer(dir.path(), &STRIKE);
    let log = dir.path().join("strikes/strike_000001.mcap");
    assert_eq!(answer["log"], log.to_str().unwrap());
    let (centroids, commands) = read(&log);

    let fastest = commands
        .iter()
        .map(|sample| sample.x.hypot(sample.y))
        .fold(0.0, f64::max);
    assert!((fastest - answer["speed"].as_f64().unwrap()).abs() < 1e-6);
    let plateau = commands.iter().max_by(|a, b| a.x.total_cmp(&b.x)).unwrap();
    let angle = answer["angle"].as_f64().unwrap();
    assert!((plateau.y.atan2(plateau.x) - angle).abs() < 1e-6);

    let [first, last] =
        [centroids[0], centroids[centroids.len() - 1]].map(|sample| Point::new(sample.x, sample.y));
    assert!(first.distance(point(&answer["from"])) < 0.005, "{first:?}");
    assert!(last.distance(point(&answer["stopped"])) < 0.005, "{last:?}");
    let miss = point(&answer["stopped"]).distance(point(&answer["to"]));
    assert!((miss - answer["miss"].as_f64().unwrap()).abs() < 1e-12);
}

#[test]
fn each_strike_has_a_log_and_a_scatter_of_its_own() {
    let dir = fixture::published();
    let stops: Vec<_> = (0..3)
        .map(|_| answer(dir.path(), &STRIKE)["stopped"].clone())
        .collect();
    assert!(stops[0] != stops[1] && stops[1] != stops[2]);
    let last = |number: u32| {
        let (centroids, _) = read(&dir.path().join(format!("strikes/strike_{number:06}.mcap")));
        (centroids[0].stamp, centroids[centroids.len() - 1].stamp)
    };
    assert!(
        last(1).1 < last(2).0 && last(2).1 < last(3).0,
        "stamps run on"
    );
    assert_eq!(fs::read_dir(dir.path().join("strikes")).unwrap().count(), 3);
}

#[test]
fn a_named_log_is_written_once() {
    let dir = fixture::published();
    let log = dir.path().join("one.mcap");
    let arguments = [STRIKE.as_slice(), &["--log", log.to_str().unwrap()]].concat();
    answer(dir.path(), &arguments);
    let written = fs::read(&log).unwrap();
    let again = strike(dir.path(), &arguments);
    assert_eq!(again.status.code(), Some(2));
    assert!(stderr(&again).contains("never overwritten"));
    assert_eq!(fs::read(&log).unwrap(), written);
    assert!(!dir.path().join("strikes").exists());
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
    fs::write(
        dir.path().join("truth.json"),
        Truth::demo(&rig, 1).to_json(),
    )
    .unwrap();
    let output = strike(dir.path(), &STRIKE);
    assert_eq!(output.status.code(), Some(4));
    assert!(
        stderr(&output).contains("nothing has moved"),
        "{}",
        stderr(&output)
    );
    let logs = fs::read_dir(dir.path().join("strikes"));
    assert_eq!(logs.map_or(0, Iterator::count), 0, "no log");
}

#[test]
fn a_truth_that_cannot_be_read_is_told() {
    let dir = fixture::published();
    let output = strike(dir.path(), &[&STRIKE[..8], &["sim:/none/such"]].concat());
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("/none/such/truth.json"));
}
