//! The commands in the order in which a person gives them, on a small demo.

use std::collections::BTreeMap;
use std::path::Path;

use carom::Outcome;
use serde_json::Value;

use crate::fixture::{answer, bad_input, computed, demo, done, fetches_nothing, json, refusal};

#[test]
fn a_demo_becomes_a_version_that_strikes_and_can_be_rebuilt() {
    let (folder, dir) = demo("--strikes 80 --seed 3");
    let first = format!("run {dir}/rig/logs/session_000.mcap {dir}/rig/logs/session_001.mcap");
    let options = format!("--rig {dir}/rig/rig.toml --out {dir}");
    let said = done(&format!("{first} {options}"));
    assert_eq!(said["version"], "v0001");
    let files = "strikes.parquet tracks.parquet rejects.parquet world.toml diagnosis.json solutions.parquet \
        residuals.parquet evaluation.json report.html versions/v0001/manifest.json latest";
    for file in files.split(' ') {
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
            let count = |key: &str| outcome[key].as_array().unwrap().len();
            assert_eq!(count("strikes") + count("refusals"), struck_at, "{model}");
        }
    }
    // Without a truth the embedded rig is another's: the version's own world is struck, and called what it is.
    std::fs::rename(
        folder.path().join("rig/truth.json"),
        folder.path().join("rig/hidden.json"),
    )
    .unwrap();
    let why = bad_input(&format!("trial --artifacts {dir} --robot sim"));
    assert!(why.contains("--robot world"), "{why}");
    let own = done(&format!(
        "trial --artifacts {dir} --robot world --targets 6 --repeats 1 --sessions 0"
    ));
    let robot = own["robot"].as_str().unwrap();
    assert!(robot.contains("no evidence about reality"), "{robot}");
    let mean = |model: &str| own[model]["mean"].as_f64().unwrap();
    assert!(mean("sysid") < mean("nominal"), "{own}");
    let report = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(report.contains("Closed loop") && report.contains("v0002"));
    assert!(fetches_nothing(&report), "the page fetches nothing");

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
    let said = answer(&line);
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
fn signs(dir: &str) {
    done(&format!("key new --out {dir}/carom.key"));
    let artifacts = format!("--artifacts {dir}");
    let verify = format!("artifacts verify {artifacts} --key {dir}/carom.pub");
    let text = bad_input(&verify);
    assert!(text.contains("not signed"), "{text}");
    done(&format!("artifacts sign {artifacts} --key {dir}/carom.key"));
    assert_eq!(done(&verify)["sequence"], 1);
    for line in [
        format!("artifacts rollback v0002 {artifacts}"),
        format!("publish --out {dir}"),
    ] {
        let text = bad_input(&line);
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

#[test]
fn a_hidden_effect_is_named_used_kept_out_on_request_and_struck_with() {
    let folder = tempfile::tempdir().unwrap();
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
    let report = std::fs::read_to_string(path.join("report.html")).unwrap();
    assert!(report.contains("Where simulation and strikes disagree") && fetches_nothing(&report));

    let said = done(&format!("run {logs}"));
    assert!(computed(&said).contains(&("diagnose".into(), 0)));
    let mean = |table: &Value, model: &str| table[model]["mean"].as_f64().unwrap();
    let evaluation = json(path, "evaluation.json");
    assert!(mean(&evaluation, "effect") < 0.8 * mean(&evaluation, "sysid"));
    // What is added to the effects may be nothing: then the version holds no such model, and its row here is that of the effects.
    let manifest = json(path, "versions/v0001/manifest.json");
    let metrics = &manifest["metrics"];
    let has_residual = metrics["effect_residual"].is_object();
    assert!(metrics["effect"].is_object());
    let is_same = evaluation["effect_residual"] == evaluation["effect"];
    assert!(is_same || has_residual, "{evaluation}");
    assert!(path.join("world_sysid.toml").is_file());
    assert!(path.join("versions/v0001/world_sysid.toml").is_file());
    let trial = done(&format!(
        "trial --artifacts {dir} --robot sim --targets 4 --repeats 1"
    ));
    let score = done(&format!("score {dir}/rig/logs --artifacts {dir}"));
    for table in [&trial, &score] {
        assert!(mean(table, "effect") > 0.0 && mean(table, "sysid") > 0.0);
        assert_eq!(table["effect_residual"].is_object(), has_residual);
    }

    is_shown_and_exported(path);

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

    // The most informative next strikes, where there are any, are a plan for the rig.
    if path.join("next_strikes.json").is_file() {
        let line =
            format!("demo --hide table_tilt --plan {dir}/next_strikes.json --out {dir}/more");
        let planned = json(path, "next_strikes.json").as_array().map(Vec::len);
        assert_eq!(done(&line)["strikes"].as_u64().map(|n| n as usize), planned);
    }
}

/// A view of one strike has it beside both worlds, and the effect; the same bytes again. All strikes are episodes.
fn is_shown_and_exported(path: &Path) {
    let dir = path.display();
    let id = json(path, "evaluation.json")["predictions"][0]["strike_id"].clone();
    let view = format!(
        "view {dir} --strike {} -o {dir}/view.mcap",
        id.as_str().unwrap()
    );
    assert_eq!(done(&view)["shown"]["strikes"], 1);
    let bytes = std::fs::read(path.join("view.mcap")).unwrap();
    let messages = mcap::MessageStream::new(&bytes).unwrap();
    let mut topics: BTreeMap<String, usize> = BTreeMap::new();
    for message in messages {
        let channel = message.unwrap().channel;
        let schema = channel.schema.as_ref().unwrap();
        assert_eq!(
            (&*channel.message_encoding, &*schema.encoding),
            ("protobuf", "protobuf")
        );
        *topics.entry(channel.topic.clone()).or_default() += 1;
    }
    for topic in "strike measured sysid effect effects effects/points table".split(' ') {
        assert_eq!(topics[&format!("/carom/{topic}")], 1, "{topics:?}");
    }
    assert!(topics["/carom/motion"] > 10 && topics["/carom/transforms"] > 10);
    done(&view);
    assert!(bytes == std::fs::read(path.join("view.mcap")).unwrap());
    for wrong in ["--strike none -o view.mcap", "-o view.txt"] {
        let (outcome, _) = refusal(&format!("view {dir} {wrong}"));
        assert_eq!(outcome, Outcome::BadInput);
    }

    let export = format!("dataset export {dir} --lerobot {dir}/episodes --fps 50");
    let said = done(&export);
    let info = json(path, "episodes/meta/info.json");
    assert_eq!(
        (&said["episodes"], &said["frames"]),
        (&info["total_episodes"], &info["total_frames"])
    );
    assert_eq!(info["fps"], 50);
    assert_eq!(refusal(&export).0, Outcome::BadInput);
}

#[test]
fn too_few_strikes_to_diagnose_are_no_failure_of_a_run_and_publish_nothing() {
    let (folder, dir) = demo("--strikes 7 --seed 2 --hide none");
    let said = answer(&format!(
        "run {dir}/rig/logs --rig {dir}/rig/rig.toml --out {dir}"
    ));
    let why = said.json["no_diagnosis"].as_str().unwrap();
    assert!(why.contains("log more strikes"), "{why}");
    // Nothing judges what came out: it is a candidate, and no robot finds it.
    assert_eq!(said.outcome, Outcome::Refused, "{}", said.text);
    assert!(said.text.contains("v0001 is a candidate"), "{}", said.text);
    assert!(said.text.contains("record 73 more"), "{}", said.text);
    assert!(!folder.path().join("latest").exists());
    assert!(!folder.path().join("diagnosis.json").exists());
    let text = bad_input(&format!("diagnose --out {dir}"));
    assert!(text.contains("log more strikes"), "{text}");
}

#[test]
fn a_ball_is_identified_and_learnt_though_nothing_diagnoses_it() {
    let (_folder, dir) = demo("--object sphere --strikes 30 --hide none");
    let said = done(&format!(
        "run {dir}/rig/logs --rig {dir}/rig/rig.toml --out {dir}"
    ));
    assert_eq!(said["version"], "v0001");
    let why = said["no_diagnosis"].as_str().unwrap();
    assert!(why.contains("a ball rolls"), "{why}");
    bad_input(&format!("diagnose --out {dir}"));
}

#[test]
fn a_second_run_in_a_folder_is_asked_to_try_again() {
    let (folder, dir) = demo("--strikes 1 --hide none");
    let options = stage::Options::default();
    let first = stage::Run::open(&folder.path().join("run"), options).unwrap();
    let (outcome, text) = refusal(&format!(
        "ingest {dir}/rig/logs --rig {dir}/rig/rig.toml --out {dir}/run"
    ));
    assert_eq!(outcome, Outcome::Busy, "{text}");
    drop(first);
}
