//! Nights that go wrong: killed at every step, a disk that is full, two at once. What was in use stays in use, or the new
//! version is; the next night ends as if nothing had happened. FAULTS.md lists every fault and its test.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use carom::{Cli, Error, Outcome, Output, execute};
use clap::Parser;
use rayon::prelude::*;
use serde_json::Value;
use store::Store;
use tests::soak::{Ended, ended};

use crate::carom;

/// Seed of the split: of the first night's 19 strikes eight are held out, as many as judge a first version.
const SPLIT: &str = "3814";

fn attempt(line: &str) -> Result<Output, Error> {
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
        carom(&format!("demo --strikes 45 --seed 3 --out {rig}"));
        // The first night has too few strikes to learn a residual from.
        let early = nights.path("early");
        carom(&format!("demo --strikes 19 --seed 4 --out {early}"));
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
        format!(
            "nightly {rig}/logs{log} --rig {rig}/rig.toml --out {out} --key {key} --seed {SPLIT}"
        )
    }

    /// A folder as the first night left it, with all that the second computes in its cache.
    fn ready(&self, out: &str) -> PathBuf {
        let [first, second, out] =
            ["first", "second", out].map(|name| self.folder.path().join(name));
        let _ = fs::remove_dir_all(&out);
        copy(&first, &out);
        copy(&second.join("cache"), &out.join("cache"));
        out
    }

    /// Each step of such a second night, with the folder that it works in; gives how many there are.
    fn each_step(&self, name: &str, strike: impl Fn(u64, &Path) + Sync) -> u64 {
        let whole = faulty("kill", 0, &self.ready(name), SPLIT);
        assert_eq!(whole.code, 0, "{whole:?}");
        (1..=whole.steps).into_par_iter().for_each(|step| {
            let dir = self.ready(&format!("{name}_{step}"));
            strike(step, &dir);
            fs::remove_dir_all(dir).expect("removed");
        });
        println!("{name}: {} steps", whole.steps);
        whole.steps
    }
}

/// A night in a folder beside its `rig/` and `carom.key`, in a program of its own with a fault at a step.
fn faulty(fault: &str, step: u64, dir: &Path, split: &str) -> Ended {
    let folder = dir.parent().expect("a folder above");
    let output = Command::new(env!("CARGO_BIN_EXE_faulty"))
        .args([fault, &step.to_string(), "nightly"])
        .args([
            folder.join("rig/logs"),
            "--rig".into(),
            folder.join("rig/rig.toml"),
        ])
        .args([
            "--out".into(),
            dir.to_path_buf(),
            "--key".into(),
            folder.join("carom.key"),
        ])
        .args(["--seed", split])
        // Many of these run at once.
        .env("RAYON_NUM_THREADS", "1")
        .output();
    ended(&output.expect("runs"), Duration::ZERO)
}

/// Of a night on strikes with nothing hidden, which computes half as long as one with effects; the same of its strikes are held out.
const SPLIT_OF_CLEAN: &str = "406";

/// A first night, with all that it computes, killed at every one of its steps by the system.
#[test]
fn a_first_night_killed_at_any_step_is_made_up_for_to_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    carom(&format!(
        "demo --strikes 19 --seed 4 --hide none --out {}",
        path("rig").display()
    ));
    carom(&format!("key new --out {}", path("carom.key").display()));
    let undisturbed = faulty("kill", 0, &path("whole"), SPLIT_OF_CLEAN);
    assert_eq!(undisturbed.code, 0, "{undisturbed:?}");
    assert!(undisturbed.steps > 150, "{undisturbed:?}");
    let whole = left(&path("whole"));
    (1..=undisturbed.steps).into_par_iter().for_each(|step| {
        let dir = path(&format!("killed_{step}"));
        let ended = faulty("kill", step, &dir, SPLIT_OF_CLEAN);
        assert_eq!(ended.code, -1, "step {step}: {ended:?}");
        let store = Store::open(&dir);
        if store.latest().is_ok() {
            store
                .verify(None)
                .unwrap_or_else(|error| panic!("step {step}: failed to {error}"));
        }
        let ended = faulty("kill", 0, &dir, SPLIT_OF_CLEAN);
        assert_eq!(ended.code, 0, "after a kill at step {step}: {ended:?}");
        same(&left(&dir), &whole);
        fs::remove_dir_all(dir).expect("removed");
    });
    println!("first night: {} steps", undisturbed.steps);
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
    let beats = |key: &str| second.json["beats"][key].as_f64().expect("a number");
    assert!(beats("at_most") <= beats("margin"), "{}", second.text);
    assert!(beats("candidate_mean") < beats("current_mean"));
    assert!(second.json["executor"]["planned"].as_u64() > Some(4));
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
    a_few_more_strikes(&nights);
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

/// Killed at each step of a second night, in the middle of its writes.
fn killed_at_any_step(nights: &Nights, whole: &BTreeMap<String, Vec<u8>>) {
    let steps = nights.each_step("killed", |step, dir| {
        let ended = faulty("kill", step, dir, SPLIT);
        assert_eq!(ended.code, -1, "step {step}: {ended:?}");
        is_sound(dir, &format!("killed at step {step}"));
        let ended = faulty("kill", 0, dir, SPLIT);
        assert_eq!(ended.code, 0, "after a kill at step {step}: {ended:?}");
        same(&left(dir), whole);
    });
    assert!(steps > 100, "only {steps} steps");
}

/// Nights that fail at any step, as on a full disk, or where a write or a sync fails.
fn failing_at_any_step(nights: &Nights) {
    nights.each_step("failed", |step, dir| {
        let fault = if step % 2 == 0 { "full" } else { "io" };
        let ended = faulty(fault, step, dir, SPLIT);
        assert_eq!(ended.code, 1, "step {step}: {ended:?}");
        assert!(
            ended.printed.contains("failed to"),
            "step {step}: {ended:?}"
        );
        is_sound(dir, &format!("step {step} failed"));
    });
}

fn two_at_once(nights: &Nights) {
    nights.ready("twice");
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

/// A version that learnt from a few more strikes and is as good is put to use; then there is nothing more to decide.
fn a_few_more_strikes(nights: &Nights) {
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
    assert_eq!(night.outcome, Outcome::Done, "{}", night.text);
    assert_eq!(night.json["status"], "promoted", "{}", night.text);
    assert_eq!(night.json["latest"], "v0003");
    assert_eq!(night.json["new_logs"], serde_json::json!(["tonight.mcap"]));
    assert_eq!(night.json["new_strikes"], 3);
    for said in ["promised", "achieved", "in_use_for"] {
        assert!(night.json[said].is_number(), "{said}: {}", night.text);
    }
    assert!(night.text.contains("not worse: "), "{}", night.text);
    let text = fs::read_to_string(folder.join("second/nightly.json")).expect("kept");
    assert_eq!(
        serde_json::from_str::<Value>(&text).expect("JSON"),
        night.json
    );
    let report = fs::read_to_string(folder.join("second/report.html")).expect("a report");
    assert!(report.contains("v0003 is in use from now on"));
    let store = Store::open(&folder.join("second"));
    assert_eq!(store.list().expect("a list").len(), 3);

    // A night with nothing new leaves the decision to be read.
    let line = format!("nightly --out {out} --key {}", nights.path("carom.key"));
    let again = carom(&line);
    assert_eq!(again.json["status"], "nothing_new", "{}", again.text);
    assert_eq!(again.json["new_strikes"], 0, "{}", again.text);
    let kept = fs::read_to_string(folder.join("second/nightly.json")).expect("kept");
    assert_eq!(kept, text);

    // A log that is none is reported every night.
    fs::write(format!("{logs}/empty.mcap"), "").expect("written");
    for _ in 0..2 {
        let night = carom(&line);
        assert_eq!(night.json["status"], "nothing_new", "{}", night.text);
        assert_eq!(night.json["left_out"][0]["log"], "empty.mcap");
        assert_eq!(night.json["logs"], again.json["logs"]);
        assert!(
            night.text.contains("empty.mcap is left out: failed to"),
            "{}",
            night.text
        );
        assert_eq!(night.outcome, Outcome::Rejected);
    }
}
