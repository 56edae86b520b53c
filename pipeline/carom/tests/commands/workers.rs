//! Workers beside one another, what is told of them, and the run that gathers their work.

use std::fs;

use serde_json::Value;

use crate::fixture::{bad_input, bytes, computed, demo, done, refusal};

/// How many answers workers and runs computed, by stage.
fn sums(said: &[Value]) -> std::collections::BTreeMap<String, u64> {
    let mut sums = std::collections::BTreeMap::new();
    for (stage, count) in said.iter().flat_map(computed) {
        *sums.entry(stage).or_default() += count;
    }
    sums
}

#[test]
fn workers_compute_each_answer_once_and_the_run_publishes_the_bytes_of_one_machine() {
    let (folder, dir) = demo("--strikes 80 --seed 3");
    let logs = format!("{dir}/rig/logs --rig {dir}/rig/rig.toml --seed 5 --out {dir}");
    let alone = done(&format!("run {logs}/alone"));

    let why = bad_input(&format!("status {dir}/shared"));
    assert!(why.contains("carom work"), "{why}");
    let worked: Vec<Value> = std::thread::scope(|scope| {
        let shares = (1..=3).map(|share| format!("work {logs}/shared --shard {share}/3"));
        let workers: Vec<_> = shares
            .map(|line| scope.spawn(move || done(&line)))
            .collect();
        let said = workers.into_iter();
        said.map(|worker| worker.join().unwrap()).collect()
    });
    assert_eq!(sums(&worked), sums(std::slice::from_ref(&alone)));

    let status = done(&format!("status {dir}/shared"));
    let workers = status["workers"].as_array().unwrap();
    assert!(workers.len() == 3 && workers.iter().all(|worker| worker["state"] == "done"));
    let stages = status["stages"].as_array().unwrap();
    assert!(stages.iter().all(|stage| stage["left"] == 0), "{status}");
    assert_eq!(status["to_come"], serde_json::json!([]));

    let gathered = done(&format!("run {logs}/shared"));
    assert!(computed(&gathered).iter().all(|(_, count)| *count == 0));
    let version = |run: &str| bytes(&folder.path().join(run).join("versions/v0001"));
    assert_eq!(version("shared"), version("alone"));
    for file in ["strikes.parquet", "evaluation.json", "diagnosis.json"] {
        let file = |run: &str| fs::read(folder.path().join(run).join(file)).unwrap();
        assert_eq!(file("shared"), file("alone"));
    }
    let status = done(&format!("status {dir}/shared"));
    assert_eq!(status["workers"], serde_json::json!([]));
    assert_eq!(status["latest"], "v0001");
}

#[test]
fn logs_with_images_are_tracked_by_one_worker_each_and_a_worker_that_fails_says_why() {
    let (folder, dir) = demo("--strikes 3 --seed 4 --camera");
    let logs = format!("{dir}/rig/logs --rig {dir}/rig/rig.toml --out {dir}");
    let why = std::thread::scope(|scope| {
        let shares = (1..=2).map(|share| format!("work {logs}/shared --shard {share}/2"));
        let workers: Vec<_> = shares
            .map(|line| scope.spawn(move || refusal(&line)))
            .collect();
        let said = workers.into_iter();
        let said: Vec<_> = said.map(|worker| worker.join().unwrap()).collect();
        said[0].1.clone()
    });
    assert!(why.contains("were kept"), "too few strikes: {why}");
    let status = done(&format!("status {dir}/shared"));
    let workers = status["workers"].as_array().unwrap();
    let failed = |worker: &&Value| {
        worker["state"] == "failed" && worker["doing"] == format!("failed to {why}")
    };
    assert_eq!(workers.iter().filter(failed).count(), 2, "{status}");
    let stages = status["stages"].as_array().unwrap();
    let track = stages
        .iter()
        .find(|stage| stage["stage"] == "track")
        .unwrap();
    let count = fs::read_dir(folder.path().join("rig/logs"))
        .unwrap()
        .count();
    assert_eq!(track["jobs"], count);

    done(&format!("ingest {logs}/shared"));
    done(&format!("ingest {logs}/alone"));
    let strikes = |run: &str| fs::read(folder.path().join(run).join("strikes.parquet")).unwrap();
    assert_eq!(strikes("shared"), strikes("alone"));
}
