//! What a person does while a night goes on.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use rig::{Hidden, RecordingWriter, Sim, Truth};
use values::{Command, Point, Shape};

use crate::fixture::{carom, done, json};

/// Bytes that a folder holds.
fn size(dir: &Path) -> u64 {
    let files = fs::read_dir(dir).unwrap().flatten();
    files
        .map(|file| match file.metadata() {
            Ok(it) if it.is_dir() => size(&file.path()),
            it => it.map_or(0, |it| it.len()),
        })
        .sum()
}

#[test]
fn a_version_that_is_put_to_use_during_a_night_stays_and_the_next_night_decides_anew() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path();
    let name = dir.display();
    done(&format!("demo --strikes 100 --seed 4 --out {name}/rig"));
    fs::create_dir(dir.join("logs")).unwrap();
    let log = |session: u32| {
        let session = format!("session_{session:03}.mcap");
        let from = dir.join("rig/logs").join(&session);
        fs::copy(from, dir.join("logs").join(&session)).unwrap();
    };
    // So split, the first session's 25 strikes hold out eight, which judge a first version.
    let usual = format!("{name}/logs --rig {name}/rig/rig.toml --out {name}/run --seed 6");
    log(0);
    done(&format!("nightly {usual}"));
    log(1);
    done(&format!("run {usual}"));
    done(&format!("artifacts rollback v0001 --artifacts {name}/run"));
    let latest = || fs::read_to_string(dir.join("run/latest")).unwrap();
    assert_eq!(latest().trim(), "v0001");

    // Once the night has answered for the new log it has read what is in use, and minutes of work on this machine lie ahead.
    log(2);
    let run = dir.join("run");
    let answers = || size(&run.join("cache/ingest"));
    let before = answers();
    let night = {
        let line = format!("nightly {usual}");
        thread::spawn(move || carom(&line).map(|said| said.json))
    };
    while answers() == before && !night.is_finished() {
        thread::sleep(Duration::from_millis(5));
    }
    done(&format!("artifacts rollback v0002 --artifacts {name}/run"));
    assert!(!night.is_finished(), "the night was over before");
    let night = night.join().unwrap().unwrap();
    assert_eq!(
        (&night["before"], &night["latest"]),
        (&"v0001".into(), &"v0002".into())
    );
    assert_ne!(night["status"], "promoted", "{night}");
    assert_eq!(latest().trim(), "v0002");

    // The decision was about another version.
    let next = carom(&format!("nightly {usual}")).unwrap().json;
    assert_ne!(next["status"], "nothing_new", "{next}");
    assert_eq!(json(&run, "nightly.json")["before"], "v0002");

    // Less than it learnt from is no reason to replace it.
    let in_use = latest();
    for session in [1, 2] {
        fs::remove_file(dir.join(format!("logs/session_{session:03}.mcap"))).unwrap();
    }
    let poorer = carom(&format!("nightly {usual}")).unwrap().json;
    assert_eq!(poorer["status"], "kept", "{poorer}");
    assert!(
        poorer["why"].to_string().contains("session_001.mcap"),
        "{poorer}"
    );
    assert_eq!(latest(), in_use);
}

/// A folder with a rig file and one for its logs.
struct Lab {
    truth: Truth,
    folder: tempfile::TempDir,
}

impl Lab {
    /// Of a table that leans: the demo's whole mixture takes each night's diagnosis several times as long.
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut truth = Truth::demo(&Truth::demo_rig(Shape::Cylinder), 3);
        truth.hidden = Hidden::parse(&["table_tilt"]).unwrap();
        fs::create_dir(folder.path().join("logs")).unwrap();
        fs::write(folder.path().join("rig.toml"), truth.rig.to_toml()).unwrap();
        Self { truth, folder }
    }

    /// The strikes of one night, in one log: commands and starts go through their ranges.
    fn night(&self, number: usize, strikes: usize) {
        let (truth, logs) = (&self.truth, self.folder.path().join("logs"));
        let mut sim = Sim::from(truth.clone()).unwrap();
        sim = sim.after(100 * number).in_session(number);
        let path = logs.join(format!("night_{number}.mcap"));
        let mut writer = RecordingWriter::create(&path, &truth.rig.topics).unwrap();
        for strike in 0..strikes {
            // Steps of the golden ratio and of its square fill a square evenly.
            let part = |step: f64| ((strike + 31 * number) as f64 * step).fract();
            let (along, across) = (part(0.618_034), part(0.381_966 * 1.7));
            let from = Point::new(
                0.22 + 0.14 * part(0.754_878),
                -0.12 + 0.24 * part(0.569_840),
            );
            let command = Command::new(0.5 + 0.4 * along, -0.35 + 0.7 * across);
            let samples = sim.strike(from, command).samples;
            writer.write(&samples).unwrap();
        }
        writer.finish().unwrap();
    }

    fn run(&self) -> PathBuf {
        self.folder.path().join("run")
    }

    /// The command that decides on a night.
    fn line(&self) -> String {
        let dir = self.folder.path().display();
        format!("nightly {dir}/logs --rig {dir}/rig.toml --out {dir}/run")
    }
}

#[test]
fn friction_that_rises_for_good_is_followed_the_same_night_and_learnt_from_after() {
    let mut lab = Lab::new();
    let line = lab.line();
    let nightly = || done(&line);
    lab.night(0, 100);
    assert_eq!(nightly()["status"], "promoted");
    let steady = json(&lab.run(), "nightly.json");
    assert_eq!(steady["change"], serde_json::Value::Null);

    lab.truth.friction *= 1.12;
    lab.night(1, 25);
    let changed = nightly();
    assert_eq!(changed["status"], "promoted", "{changed}");
    assert_eq!(changed["quarantined"], false);
    let what = changed["change"]["what"].as_str().unwrap();
    assert!(what.ends_with("changed beyond chance: friction"), "{what}");
    let gate = &changed["beats"];
    let mean = |of: &str| gate[of].as_f64().unwrap();
    assert!(
        mean("candidate_mean") < 0.3 * mean("current_mean"),
        "{gate}"
    );
    // What learnt from all nights waits for strikes that it did not learn from.
    assert!(changed["waiting"].is_string(), "{changed}");

    // The table stays as it is now: nothing is to be looked at.
    lab.night(2, 25);
    let next = nightly();
    assert!(
        next["status"] == "promoted" || next["status"] == "kept",
        "{next}"
    );
    assert_eq!(next["change"]["what"], changed["change"]["what"]);

    // It was a shift of two days: what was known before is right again.
    lab.truth.friction /= 1.12;
    lab.night(3, 25);
    let back = nightly();
    assert_eq!(back["status"], "promoted", "{back}");
    let why = back["why"][0].as_str().unwrap();
    assert!(
        why.starts_with("from v0001 from before the last change: not worse"),
        "{why}"
    );
    assert_eq!(back["change"]["version"], "v0001");
}

#[test]
fn of_two_logs_of_a_night_only_the_one_whose_strikes_scatter_is_set_aside() {
    let mut lab = Lab::new();
    let line = lab.line();
    let nightly = || carom(&line).unwrap().json;
    lab.night(0, 100);
    assert_eq!(nightly()["status"], "promoted");

    lab.night(1, 25);
    let steady = std::mem::replace(&mut lab.truth.scatter.speed, 0.1);
    lab.night(2, 25);
    lab.truth.scatter.speed = steady;
    let bad = nightly();
    assert_eq!(bad["status"], "refused", "{bad}");
    assert_eq!(
        bad["set_aside"],
        serde_json::json!(["night_2.mcap"]),
        "{bad}"
    );

    // The other one is learnt from.
    lab.night(3, 25);
    let next = nightly();
    let logs = serde_json::json!(["night_1.mcap", "night_3.mcap"]);
    assert_eq!(next["new_logs"], logs, "{next}");
    assert!(next["new_strikes"].as_u64().is_some_and(|new| new > 40));
    assert_eq!(next["set_aside"], bad["set_aside"]);
}

#[test]
fn an_object_that_goes_half_as_far_is_followed_the_same_night() {
    let mut lab = Lab::new();
    let line = lab.line();
    let nightly = || done(&line);
    lab.night(0, 100);
    assert_eq!(nightly()["status"], "promoted");
    let versions = lab.run().join("versions");
    let region = |version: &str| {
        let manifest = json(&versions.join(version), "manifest.json");
        manifest["trained_region"]["distance"][0].as_f64().unwrap()
    };

    lab.truth.friction *= 1.6;
    lab.truth.restitution *= 0.7;
    lab.night(1, 25);
    let changed = nightly();
    assert_eq!(changed["status"], "promoted", "{changed}");
    let gate = &changed["beats"];
    let mean = |of: &str| gate[of].as_f64().unwrap();
    assert!(
        mean("candidate_mean") < 0.2 * mean("current_mean"),
        "{gate}"
    );
    // Its paths are shorter than any before.
    assert!(region("v0002") < 0.8 * region("v0001"));
}
