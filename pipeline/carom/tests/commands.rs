//! The commands in the order in which a person gives them, on a small demo.

use std::path::Path;

use carom::{Cli, Error, Outcome, Output, execute};
use clap::Parser;
use serde_json::Value;

fn carom(line: &str) -> Result<Output, Error> {
    let words = line.split_whitespace();
    let cli = Cli::try_parse_from(["carom", "--quiet"].into_iter().chain(words));
    execute(&cli.unwrap_or_else(|error| panic!("{line}: {error}")))
}

fn done(line: &str) -> Value {
    match carom(line) {
        Ok(said) => {
            assert_eq!(said.outcome, Outcome::Done, "{line}: {}", said.text);
            said.json
        }
        Err(error) => panic!("{line}: failed to {error}"),
    }
}

fn computed(said: &Value) -> Vec<(String, u64)> {
    let stages = said["stages"].as_array().expect("stages");
    let row = |stage: &Value| {
        let name = stage["name"].as_str().expect("a name");
        (name.into(), stage["computed"].as_u64().expect("a count"))
    };
    stages.iter().map(row).collect()
}

/// The outcome of a command that fails, and what it says.
fn refusal(line: &str) -> (Outcome, String) {
    match carom(line) {
        Ok(said) => panic!("{line}: {}", said.text),
        Err(error) => (error.outcome(), error.to_string()),
    }
}

#[test]
fn a_demo_becomes_a_version_that_strikes_and_can_be_rebuilt() {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path().display();
    done(&format!("demo --strikes 80 --seed 3 --out {dir}/rig"));
    let first = format!("run {dir}/rig/logs/session_000.mcap {dir}/rig/logs/session_001.mcap");
    let options = format!("--rig {dir}/rig/rig.toml --out {dir}");
    let said = done(&format!("{first} {options}"));
    assert_eq!(said["version"], "v0001");
    for file in [
        "strikes.parquet",
        "tracks.parquet",
        "rejects.parquet",
        "world.toml",
        "diagnosis.json",
        "solutions.parquet",
        "residuals.parquet",
        "evaluation.json",
        "report.html",
        "versions/v0001/manifest.json",
        "latest",
    ] {
        assert!(folder.path().join(file).is_file(), "{file}");
    }

    // Nothing new: nothing is computed, and no version is made.
    let said = done(&format!("{first} {options}"));
    assert!(computed(&said).iter().all(|(_, count)| *count == 0));
    assert_eq!(said["version"], "v0001");
    let said = done(&format!("solve --out {dir}"));
    assert!(computed(&said).iter().all(|(_, count)| *count == 0));

    // Another log: only it is read. A version is published that holds it.
    let said = done(&format!(
        "{first} {dir}/rig/logs/session_002.mcap {options}"
    ));
    assert!(computed(&said).contains(&("ingest".into(), 1)));
    assert_eq!(said["version"], "v0002");

    let trial = done(&format!(
        "trial --artifacts {dir} --robot sim --targets 4 --repeats 2"
    ));
    for model in ["nominal", "sysid"] {
        for (outcome, struck_at) in [(&trial[model], 4), (&trial["figure_8"][model], 16)] {
            let count = |key: &str| outcome[key].as_array().expect("a list").len();
            assert_eq!(count("strikes") + count("refusals"), struck_at, "{model}");
        }
    }
    let report = std::fs::read_to_string(folder.path().join("report.html")).expect("a report");
    assert!(report.contains("Closed loop") && report.contains("v0002"));
    assert!(only_namespaces(&report), "the page fetches nothing");

    let score = done(&format!(
        "score {dir}/rig/logs/session_003.mcap --artifacts {dir}"
    ));
    assert_eq!(
        score["sysid"]["n"].as_u64(),
        score["sysid"]["strikes"]
            .as_array()
            .map(|all| all.len() as u64)
    );

    assert_eq!(
        done(&format!("rebuild v0002 --artifacts {dir}"))["same"],
        true
    );
    let rolled = done(&format!("artifacts rollback --artifacts {dir}"));
    assert_eq!(rolled["latest"], "v0001");
    assert_eq!(
        done(&format!("artifacts verify --artifacts {dir}"))["whole"],
        true
    );

    // What was rolled back is not brought back in silence.
    let line = format!("publish --out {dir}");
    let said = carom(&line).unwrap_or_else(|error| panic!("failed to {error}"));
    assert_eq!(
        (&said.json["version"], &said.json["latest"]),
        (&Value::from("v0002"), &Value::from("v0001"))
    );
    assert!(
        said.text.contains("v0001 stays in use")
            && said.text.contains("carom artifacts rollback v0002"),
        "{}",
        said.text
    );
    signs(&dir);
}

/// What is signed stays so, and a rebuild is the same with or without it.
fn signs(dir: &std::path::Display<'_>) {
    done(&format!("key new --out {dir}/carom.key"));
    let artifacts = format!("--artifacts {dir}");
    let verify = format!("artifacts verify {artifacts} --key {dir}/carom.pub");
    let (outcome, text) = refusal(&verify);
    assert_eq!(outcome, Outcome::BadInput, "{text}");
    assert!(text.contains("not signed"), "{text}");
    done(&format!("artifacts sign {artifacts} --key {dir}/carom.key"));
    assert_eq!(done(&verify)["sequence"], 1);
    for line in [
        format!("artifacts rollback v0002 {artifacts}"),
        format!("publish --out {dir}"),
    ] {
        let (outcome, text) = refusal(&line);
        assert_eq!(outcome, Outcome::BadInput, "{text}");
        assert!(text.contains("--key FILE"), "{line}: {text}");
    }
    done(&format!(
        "artifacts rollback v0002 {artifacts} --key {dir}/carom.key"
    ));
    let verified = done(&verify);
    assert_eq!(
        (&verified["version"], &verified["sequence"]),
        (&"v0002".into(), &2.into())
    );
    assert_eq!(done(&format!("rebuild v0002 {artifacts}"))["same"], true);
}

fn json(dir: &Path, file: &str) -> Value {
    let text = std::fs::read_to_string(dir.join(file)).expect(file);
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn a_hidden_effect_is_named_used_kept_out_on_request_and_struck_with() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, dir) = (folder.path(), folder.path().display());
    done(&format!(
        "demo --strikes 120 --seed 3 --hide table_tilt=0.012,0.008 --out {dir}/rig"
    ));
    let logs = format!("{dir}/rig/logs --rig {dir}/rig/rig.toml --out {dir}");
    done(&format!("ingest {logs}"));
    let diagnosis = done(&format!("diagnose --out {dir}"))["diagnosis"].clone();
    assert_eq!(diagnosis["verdict"], "named");
    assert_eq!(diagnosis["effects"][0]["name"], "table_tilt");
    assert_eq!(json(path, "diagnosis.json"), diagnosis);
    let report = std::fs::read_to_string(path.join("report.html")).expect("a report");
    assert!(report.contains("Where simulation and strikes disagree") && only_namespaces(&report));

    let said = done(&format!("run {logs}"));
    assert!(computed(&said).contains(&("diagnose".into(), 0)));
    let mean = |table: &Value, model: &str| table[model]["mean"].as_f64().expect("a mean");
    let evaluation = json(path, "evaluation.json");
    assert!(mean(&evaluation, "effect") < 0.8 * mean(&evaluation, "sysid"));
    assert!(evaluation["effect_residual"].is_object());
    assert!(path.join("world_sysid.toml").is_file());
    assert!(path.join("versions/v0001/world_sysid.toml").is_file());
    let trial = done(&format!(
        "trial --artifacts {dir} --robot sim --targets 4 --repeats 1"
    ));
    let score = done(&format!("score {dir}/rig/logs --artifacts {dir}"));
    for table in [&trial, &score] {
        assert!(mean(table, "effect") > 0.0 && mean(table, "effect_residual") > 0.0);
    }

    // Kept out: as if nothing was named, but the diagnosis is there.
    let said = done(&format!("run {logs} --without-effects"));
    assert_eq!(said["version"], "v0002");
    assert_eq!(said["diagnosis"], diagnosis);
    assert!(json(path, "evaluation.json")["effect"].is_null());
    assert!(!path.join("world_sysid.toml").exists());
    for version in ["v0001", "v0002"] {
        let again = done(&format!("rebuild {version} --artifacts {dir}"));
        assert_eq!(again["same"], true, "{version}");
    }

    // The strikes that would tell more, where there are any, are a plan for the rig.
    if path.join("next_strikes.json").is_file() {
        let line =
            format!("demo --hide table_tilt --plan {dir}/next_strikes.json --out {dir}/more");
        let planned = json(path, "next_strikes.json").as_array().map(Vec::len);
        assert_eq!(done(&line)["strikes"].as_u64().map(|n| n as usize), planned);
    }
}

#[test]
fn too_few_strikes_to_diagnose_are_no_failure_of_a_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path().display();
    done(&format!(
        "demo --strikes 7 --seed 2 --hide none --out {dir}/rig"
    ));
    let said = done(&format!(
        "run {dir}/rig/logs --rig {dir}/rig/rig.toml --out {dir}"
    ));
    let why = said["no_diagnosis"].as_str().expect("a reason");
    assert!(why.contains("log more strikes"), "{why}");
    assert!(!folder.path().join("diagnosis.json").exists());
    let (outcome, text) = refusal(&format!("diagnose --out {dir}"));
    assert_eq!(outcome, Outcome::BadInput, "{text}");
    assert!(text.contains("log more strikes"), "{text}");
}

#[test]
fn a_ball_is_identified_and_learnt_though_nothing_diagnoses_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path().display();
    done(&format!(
        "demo --object sphere --strikes 30 --hide none --out {dir}/rig"
    ));
    let said = done(&format!(
        "run {dir}/rig/logs --rig {dir}/rig/rig.toml --out {dir}"
    ));
    assert_eq!(said["version"], "v0001");
    let why = said["no_diagnosis"].as_str().expect("a reason");
    assert!(why.contains("a ball rolls"), "{why}");
    let (outcome, why) = refusal(&format!("diagnose --out {dir}"));
    assert_eq!(outcome, Outcome::BadInput, "{why}");
}

/// Whether every address in the page is the name of SVG's namespace, which nothing fetches.
fn only_namespaces(page: &str) -> bool {
    page.match_indices("http")
        .all(|(at, _)| page[at..].starts_with("http://www.w3.org/2000/svg"))
}

#[test]
fn a_log_that_has_grown_and_another_of_its_name_are_told_apart_at_night() {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path().display();
    done(&format!("demo --strikes 40 --hide none --out {dir}/rig"));
    let session = |number: u32| {
        let path = format!("rig/logs/session_00{number}.mcap");
        std::fs::read(folder.path().join(path)).expect("a log")
    };
    let put = |day: &str, bytes: &[u8]| {
        let day = folder.path().join("days").join(day);
        std::fs::create_dir_all(&day).expect("a folder");
        std::fs::write(day.join("session.mcap"), bytes).expect("written");
    };
    let night = |more: &str| {
        let said = carom(&format!("nightly {more} --out {dir}/run"));
        let said = said.unwrap_or_else(|error| panic!("failed to {error}"));
        let count = |key: &str| said.json[key].as_u64().expect("a count");
        (count("strikes"), count("new_strikes"))
    };
    let last = session(3);
    put("d0", &session(0));
    put("d1", &last[..last.len() / 2]);
    let (cut, _) = night(&format!("{dir}/days --rig {dir}/rig/rig.toml"));
    assert!((11..20).contains(&cut), "{cut}");
    put("d1", &last);
    assert_eq!(night(""), (20, 20 - cut), "it has grown");
    // Made before the last strike that the version knows.
    put("d1", &session(1));
    assert_eq!(night(""), (20, 10), "another of its name");
}

#[test]
fn what_cannot_be_worked_with_is_bad_input_that_names_what_and_where() {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path().display();
    done(&format!("demo --strikes 1 --hide none --out {dir}/rig"));
    let rig = format!("--rig {dir}/rig/rig.toml --out {dir}/run");
    write(&folder.path().join("no.mcap"), "no log");
    write(&folder.path().join("bad.toml"), "[object]\nshpae = 1\n");
    std::fs::create_dir(folder.path().join("own")).expect("a folder");
    write(&folder.path().join("own/rig.toml"), "a person's");
    for (line, named) in [
        (format!("run {dir}/none {rig}"), "none"),
        (format!("run {dir}/no.mcap {rig}"), "no.mcap"),
        (
            format!("run {dir}/rig/logs --rig {dir}/bad.toml --out {dir}/run"),
            "shpae",
        ),
        (format!("run {dir}/rig/logs {rig}"), "log more strikes"),
        (format!("run {dir}/rig/logs {rig}"), "1 were kept"),
        (format!("demo --out {dir}/own"), "own/rig.toml is there"),
        (
            format!("demo --hide none --hide table_tilt --out {dir}/x"),
            "leave out one of them",
        ),
        (format!("sysid --out {dir}/nothing"), "carom ingest"),
        (format!("artifacts verify --artifacts {dir}"), "carom run"),
        (format!("demo --hide frction --out {dir}/x"), "friction"),
        (format!("rig init --out {dir}/bad.toml"), "bad.toml"),
    ] {
        let (outcome, text) = refusal(&line);
        assert_eq!(outcome, Outcome::BadInput, "{line}: {text}");
        assert!(text.contains(named), "{line}: {text}");
    }
    let own = std::fs::read_to_string(folder.path().join("own/rig.toml"));
    assert_eq!(own.expect("still there"), "a person's");
}

#[test]
fn logs_of_one_name_in_several_folders_are_other_sessions() {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path().display();
    done(&format!("demo --strikes 40 --hide none --out {dir}/rig"));
    for day in 0..4 {
        let to = folder.path().join(format!("days/d{day}"));
        std::fs::create_dir_all(&to).expect("a folder");
        let log = folder.path().join(format!("rig/logs/session_00{day}.mcap"));
        std::fs::copy(&log, to.join("session.mcap")).expect("copied");
    }
    let ingest = |logs: &str| {
        let options = format!("--rig {dir}/rig/rig.toml --out {dir}/run");
        carom(&format!("ingest {logs} {options}")).unwrap_or_else(|error| panic!("{error}"));
        let strikes = tables::read_strikes(&folder.path().join("run")).expect("a table");
        strikes
            .into_iter()
            .map(|strike| {
                assert_eq!(strike.conditions.session, strike.log);
                strike.log
            })
            .collect::<std::collections::BTreeSet<_>>()
    };
    let days = ["d0", "d1", "d2", "d3"].map(|day| format!("{day}/session.mcap"));
    assert_eq!(ingest(&format!("{dir}/days")), days.into());
    // Alone, a log is called as its file is.
    let one = ingest(&format!("{dir}/days/d1"));
    assert_eq!(one, ["session.mcap".to_string()].into());
}

#[test]
fn a_cut_off_log_gives_what_is_whole_and_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path().display();
    done(&format!("demo --strikes 10 --hide none --out {dir}/rig"));
    let log = folder.path().join("rig/logs/session_000.mcap");
    let bytes = std::fs::read(&log).expect("a log");
    std::fs::write(&log, &bytes[..bytes.len() / 2]).expect("written");
    let line = format!("ingest {dir}/rig/logs --rig {dir}/rig/rig.toml --out {dir}");
    let said = carom(&line).unwrap_or_else(|error| panic!("failed to {error}"));
    assert_eq!(said.outcome, Outcome::Rejected);
    assert!(said.json["strikes"].as_u64() < Some(10));
    assert!(said.text.contains("session_000.mcap"), "{}", said.text);

    // Cut before the first strike, it is the cut that is told of.
    std::fs::write(&log, &bytes[..bytes.len() / 12]).expect("written");
    let (outcome, text) = refusal(&line);
    assert_eq!(outcome, Outcome::BadInput);
    assert!(
        text.contains("session_000.mcap is not whole") && text.contains("truncated at byte"),
        "{text}"
    );
}

#[test]
fn strikes_that_are_rejected_are_told_with_an_example_of_each_reason() {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path().display();
    done(&format!("demo --strikes 12 --hide none --out {dir}/rig"));
    let rig = std::fs::read_to_string(folder.path().join("rig/rig.toml")).expect("a rig file");
    let ingest = |x: &str| {
        let other = rig.replace("x = [0.1, 1.0]", x);
        assert_ne!(other, rig);
        std::fs::write(folder.path().join("other.toml"), other).expect("written");
        carom(&format!(
            "ingest {dir}/rig/logs --rig {dir}/other.toml --out {dir}"
        ))
    };
    let some = ingest("x = [0.1, 0.6]").unwrap_or_else(|error| panic!("failed to {error}"));
    let told = "off_table, such as strike ";
    assert!(some.text.contains(told), "{}", some.text);
    let none = ingest("x = [2.0, 3.0]").expect_err("no strike is left");
    assert!(none.to_string().contains(told), "{none}");
    assert_eq!(none.outcome(), Outcome::BadInput);
}

#[test]
fn logs_that_are_none_are_left_out_and_told_and_the_others_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path().display();
    done(&format!("demo --strikes 12 --hide none --out {dir}/rig"));
    let line = format!("ingest {dir}/rig/logs --rig {dir}/rig/rig.toml --out {dir}");
    let before = done(&line);
    let logs = folder.path().join("rig/logs");
    let whole = std::fs::read(logs.join("session_000.mcap")).expect("a log");
    std::fs::write(logs.join("empty.mcap"), "").expect("written");
    std::fs::write(logs.join("text.mcap"), "no log").expect("written");
    std::fs::write(logs.join("magic.mcap"), &whole[..8]).expect("written");
    // The first chunk holds the schemas: without it no message makes sense.
    let mut damaged = whole.clone();
    damaged[4000] ^= 1;
    std::fs::write(logs.join("damaged.mcap"), damaged).expect("written");
    std::os::unix::fs::symlink("nowhere", logs.join("dead.mcap")).expect("a link");
    let pipe = std::process::Command::new("mkfifo")
        .arg(logs.join("pipe.mcap"))
        .status();
    assert!(pipe.expect("mkfifo").success());

    let said = carom(&line).unwrap_or_else(|error| panic!("failed to {error}"));
    assert_eq!(said.outcome, Outcome::Rejected);
    assert_eq!(said.json["strikes"], before["strikes"]);
    let left_out: Vec<_> = said.json["left_out"]
        .as_array()
        .expect("a list")
        .iter()
        .collect();
    let mut names: Vec<_> = left_out
        .iter()
        .filter_map(|log| log["log"].as_str())
        .collect();
    names.sort_unstable();
    assert_eq!(names, ["dead.mcap", "empty.mcap", "pipe.mcap", "text.mcap"]);
    for name in names.iter().chain(&["damaged.mcap", "magic.mcap"]) {
        let line = said.text.lines().find(|line| line.contains(name));
        assert!(
            line.is_some_and(|line| line.len() > 40),
            "{name}: {}",
            said.text
        );
    }

    // Where none can be read, that is bad input.
    let (outcome, text) = refusal(&format!(
        "ingest {dir}/rig/logs/empty.mcap --rig {dir}/rig/rig.toml --out {dir}/none"
    ));
    assert_eq!(outcome, Outcome::BadInput, "{text}");
    assert!(
        text.contains("empty.mcap") && text.contains("0 bytes"),
        "{text}"
    );
}

#[test]
fn a_second_run_in_a_folder_is_told_to_try_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path().display();
    done(&format!("demo --strikes 1 --hide none --out {dir}/rig"));
    let options = stage::Options::default();
    let first = stage::Run::open(&folder.path().join("run"), options).expect("a run");
    let (outcome, text) = refusal(&format!(
        "ingest {dir}/rig/logs --rig {dir}/rig/rig.toml --out {dir}/run"
    ));
    assert_eq!(outcome, Outcome::Busy, "{text}");
    drop(first);
}

fn write(path: &Path, text: &str) {
    std::fs::write(path, text).expect("written");
}
