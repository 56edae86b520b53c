//! Nights that go wrong: killed at every step, a disk that is full, two at once. What was in use stays in use, or the new
//! version is; the next night ends as if nothing had happened.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use artifacts::Store;
use carom::{Cli, Error, Outcome, Said, execute};
use clap::Parser;
use serde_json::Value;

use crate::carom;

fn attempt(line: &str) -> Result<Said, Error> {
    let words = ["carom", "--quiet"]
        .into_iter()
        .chain(line.split_whitespace());
    execute(&Cli::try_parse_from(words).unwrap_or_else(|error| panic!("{line}: {error}")))
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder") {
        let entry = entry.expect("an entry");
        let (from, to) = (entry.path(), to.join(entry.file_name()));
        if from.is_dir() {
            copy(&from, &to);
        } else {
            fs::copy(&from, &to).expect("copied");
        }
    }
}

/// What a night leaves for others: versions, `latest` and tables.
fn left(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![dir.join("versions")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(dir).expect("below").display().to_string();
                files.insert(name, fs::read(path).expect("a file"));
            }
        }
    }
    for name in [
        "latest",
        "strikes.parquet",
        "tracks.parquet",
        "solutions.parquet",
        "world.toml",
        "evaluation.json",
    ] {
        files.insert(name.into(), fs::read(dir.join(name)).expect(name));
    }
    files
}

/// A rig's logs, and a run after a first night on one of them.
struct Nights {
    folder: tempfile::TempDir,
}

impl Nights {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let nights = Self { folder };
        let rig = nights.path("rig");
        carom(&format!("demo --strikes 90 --seed 3 --out {rig}"));
        // The first night has too few strikes to learn a residual from.
        let early = nights.path("early");
        carom(&format!("demo --strikes 8 --seed 4 --out {early}"));
        fs::copy(
            format!("{early}/logs/session_000.mcap"),
            format!("{rig}/logs/early.mcap"),
        )
        .expect("copied");
        carom(&format!("key new --out {}", nights.path("carom.key")));
        let first = carom(&nights.line("first", "/early.mcap"));
        assert_eq!(first.json["status"], "promoted", "{}", first.text);
        nights
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).display().to_string()
    }

    fn line(&self, out: &str, log: &str) -> String {
        let [rig, key, out] = ["rig", "carom.key", out].map(|name| self.path(name));
        format!("nightly {rig}/logs{log} --rig {rig}/rig.toml --out {out} --key {key}")
    }

    /// A folder as the first night left it, with all that the second computes in its cache.
    fn ready(&self, out: &str, second: &str) -> std::path::PathBuf {
        let [first, second, out] = ["first", second, out].map(|name| self.folder.path().join(name));
        let _ = fs::remove_dir_all(&out);
        copy(&first, &out);
        copy(&second.join("cache"), &out.join("cache"));
        out
    }
}

#[test]
fn a_night_promotes_what_beats_the_version_in_use_and_survives_every_fault() {
    let nights = Nights::new();
    copy(
        &nights.folder.path().join("first"),
        &nights.folder.path().join("second"),
    );
    let second = carom(&nights.line("second", ""));
    assert_eq!(second.outcome, Outcome::Done, "{}", second.text);
    assert_eq!(second.json["status"], "promoted", "{}", second.text);
    assert_eq!(second.json["latest"], "v0002");
    assert!(second.json["beats"]["interval"][0].as_f64() > Some(0.0));
    assert!(second.json["executor"]["planned"].as_u64() > Some(4));
    assert!(second.json["drift"]["z"].is_number());
    assert!(second.json["missing"].is_array());
    let folder = nights.folder.path();
    let report = fs::read_to_string(folder.join("second/report.html")).expect("a report");
    assert!(report.contains("The last night") && report.contains("v0002 is in use from now on"));
    let whole = left(&folder.join("second"));
    assert!(whole.contains_key("versions/v0002/manifest.json.minisig"));

    // The same again, with the logs found where they were: nothing to decide.
    let again = carom(&format!(
        "nightly --out {} --key {}",
        nights.path("second"),
        nights.path("carom.key")
    ));
    assert_eq!(
        (again.outcome, &again.json["status"]),
        (Outcome::Done, &"nothing_new".into())
    );
    assert_eq!(left(&folder.join("second")), whole);
    // Robots that check signatures would not take what is not signed.
    let error = attempt(&format!("nightly --out {}", nights.path("second"))).err();
    let text = error.map(|error| error.to_string()).unwrap_or_default();
    assert!(text.contains("give the secret key"), "{text}");

    killed_at_any_step(&nights, &whole);
    failing_at_any_step(&nights);
    two_at_once(&nights);
    refused_by_a_gate(&nights);
}

/// Signatures differ from run to run, by the library's own randomness; all else is the same.
fn same(left: &BTreeMap<String, Vec<u8>>, whole: &BTreeMap<String, Vec<u8>>) {
    let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(left), names(whole));
    for (name, bytes) in left {
        assert!(
            name.ends_with(".minisig") || whole[name] == *bytes,
            "{name} differs"
        );
    }
}

/// Whether the store is one that a robot can strike with.
fn is_sound(dir: &Path, what: &str) {
    let store = Store::open(dir);
    let latest = store
        .load(None)
        .unwrap_or_else(|error| panic!("{what}: failed to {error}"));
    assert!(
        ["v0001", "v0002"].contains(&latest.version.as_str()),
        "{what}"
    );
    for listing in store.list().expect("a list") {
        store
            .verify(Some(&listing.version))
            .unwrap_or_else(|error| panic!("{what}: failed to {error}"));
    }
}

fn killed_at_any_step(nights: &Nights, whole: &BTreeMap<String, Vec<u8>>) {
    let line = nights.line("killed", "");
    // All of some 160 steps take minutes, and hold; those within a store are all gone through in the store's own tests.
    for step in (1..).step_by(31) {
        let dir = nights.ready("killed", "second");
        let (result, struck) = durable::faults::after(step, || attempt(&line));
        is_sound(&dir, &format!("killed at step {step}"));
        if !struck {
            result.unwrap_or_else(|error| panic!("failed to {error}"));
            assert!(step > 50, "only {step} steps");
            break;
        }
        if step % 3 == 0 {
            carom(&line);
            same(&left(&dir), whole);
        }
    }
    same(&left(&nights.folder.path().join("killed")), whole);
}

/// As on a full disk, or where a sync fails.
fn failing_at_any_step(nights: &Nights) {
    let line = nights.line("full", "");
    for step in (1..).step_by(47) {
        let dir = nights.ready("full", "second");
        let (result, struck) = durable::faults::once(step, || attempt(&line));
        is_sound(&dir, &format!("step {step} failed"));
        if !struck {
            break;
        }
        let error = match result {
            Ok(said) => panic!("step {step}: {}", said.text),
            Err(error) => error,
        };
        assert_eq!(error.outcome(), Outcome::Failed, "step {step}: {error}");
    }
}

fn two_at_once(nights: &Nights) {
    nights.ready("twice", "second");
    let line = nights.line("twice", "");
    let outcomes = std::thread::scope(|scope| {
        let night = || match attempt(&line) {
            Ok(said) => said.outcome,
            Err(error) => error.outcome(),
        };
        [scope.spawn(night), scope.spawn(night)].map(|night| night.join().expect("ends"))
    });
    // Where one ends before the other begins, that one has nothing to do.
    assert!(outcomes.contains(&Outcome::Done), "{outcomes:?}");
    assert!(
        outcomes
            .iter()
            .all(|outcome| [Outcome::Done, Outcome::Busy].contains(outcome)),
        "{outcomes:?}"
    );
    let held = stage::Run::open(
        &nights.folder.path().join("twice"),
        stage::Options::default(),
    );
    let outcome = attempt(&line).map_or_else(|error| error.outcome(), |said| said.outcome);
    assert_eq!(outcome, Outcome::Busy);
    drop(held);
    let versions = Store::open(&nights.folder.path().join("twice")).list();
    assert_eq!(versions.expect("a list").len(), 2);
}

/// A version that is as good stays: chance alone does not move a robot.
fn refused_by_a_gate(nights: &Nights) {
    let (folder, out) = (nights.folder.path(), nights.path("second"));
    let logs = nights.path("rig/logs");
    carom(&format!(
        "demo --strikes 3 --seed 99 --out {}",
        nights.path("more")
    ));
    fs::copy(
        folder.join("more/logs/session_000.mcap"),
        format!("{logs}/tonight.mcap"),
    )
    .expect("copied");
    let night = carom(&format!(
        "nightly --out {out} --key {}",
        nights.path("carom.key")
    ));
    assert_eq!(night.outcome, Outcome::Refused, "{}", night.text);
    assert_eq!(night.json["latest"], "v0002");
    assert_eq!(night.json["new_logs"], serde_json::json!(["tonight.mcap"]));
    assert_eq!(night.json["new_strikes"], 3);
    let text = fs::read_to_string(folder.join("second/nightly.json")).expect("kept");
    assert_eq!(
        serde_json::from_str::<Value>(&text).expect("JSON"),
        night.json
    );
    let report = fs::read_to_string(folder.join("second/report.html")).expect("a report");
    assert!(report.contains("a gate refused what came out: v0002 stays in use"));
    assert_eq!(
        Store::open(&folder.join("second"))
            .list()
            .expect("a list")
            .len(),
        2
    );
}
