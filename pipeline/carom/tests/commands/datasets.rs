//! Datasets: pinned at first sight, the same bytes anywhere, one row for a strike whatever files hold it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use carom::Outcome;
use serde_json::Value;

use crate::fixture::{answer, bad_input, folder_and_path};

fn json(line: &str) -> Value {
    answer(line).json
}

/// A folder with the logs of some strikes and a recipe of them.
fn demo(strikes: u32) -> tempfile::TempDir {
    let (folder, dir) = folder_and_path();
    json(&format!(
        "demo --strikes {strikes} --seed 4 --hide none --out {dir}"
    ));
    recipe(folder.path(), "logs = [\"logs\"]");
    folder
}

fn recipe(folder: &Path, text: &str) {
    let text = format!("rig = \"rig.toml\"\nseed = 7\n{text}\n");
    fs::write(folder.join("set.toml"), text).unwrap();
}

fn logs(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder.join("logs")).unwrap();
    let mut logs: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    logs.sort();
    logs
}

/// A log's messages between two parts of its time, in chunks of another size and without compression.
fn rewritten(log: &Path, part: std::ops::Range<f64>) -> Vec<u8> {
    let bytes = fs::read(log).unwrap();
    let messages: Vec<_> = mcap::MessageStream::new(&bytes)
        .unwrap()
        .map(|message| message.unwrap())
        .collect();
    let times = messages.iter().map(|message| message.log_time);
    let (first, last) = (times.clone().min(), times.max());
    let (first, last) = (first.unwrap(), last.unwrap());
    let mut writer = mcap::WriteOptions::new()
        .compression(None)
        .chunk_size(Some(3_000))
        .create(std::io::Cursor::new(Vec::new()))
        .unwrap();
    for message in &messages {
        let at = (message.log_time - first) as f64 / (last - first) as f64;
        if part.contains(&at) {
            writer.write(message).unwrap();
        }
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

#[test]
fn a_dataset_is_the_same_bytes_with_any_threads_order_names_and_place() {
    let folder = demo(30);
    let dir = folder.path().display();
    let text = bad_input(&format!("dataset build {dir}/set.toml"));
    assert!(text.contains("carom dataset lock"), "{text}");

    let locked = json(&format!("dataset lock {dir}/set.toml"));
    assert_eq!(locked["strikes"], 30);
    let lock = fs::read(folder.path().join("set.lock")).unwrap();
    let built = json(&format!("dataset build {dir}/set.toml"));
    assert_eq!(built["files"], locked["files"]);
    for file in "strikes.parquet tracks.parquet rejects.parquet rig.toml".split(' ') {
        assert!(folder.path().join("set").join(file).is_file(), "{file}");
    }

    // Elsewhere, under other names and in another order; with one thread and with three.
    let elsewhere = tempfile::tempdir().unwrap();
    for file in ["set.toml", "set.lock", "rig.toml"] {
        fs::copy(folder.path().join(file), elsewhere.path().join(file)).unwrap();
    }
    let names = ["z", "y", "x", "w", "v", "u"];
    fs::create_dir(elsewhere.path().join("there")).unwrap();
    for (log, name) in logs(folder.path()).iter().zip(names) {
        let renamed = elsewhere.path().join(format!("there/{name}.mcap"));
        fs::copy(log, renamed).unwrap();
    }
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let there = elsewhere.path().display();
        let line = format!("dataset verify {there}/set.toml --logs {there}/there");
        let verified = pool.unwrap().install(|| json(&line));
        assert_eq!(verified["same"], true, "{threads} threads");
    }
    // Locked again, nothing changes.
    json(&format!("dataset lock {dir}/set.toml"));
    assert_eq!(fs::read(folder.path().join("set.lock")).unwrap(), lock);

    // Tables that were changed are reported.
    let table = folder.path().join("set/strikes.parquet");
    let mut bytes = fs::read(&table).unwrap();
    bytes[100] ^= 1;
    fs::write(&table, bytes).unwrap();
    let said = answer(&format!("dataset verify {dir}/set.toml"));
    assert_eq!(said.outcome, Outcome::Failed);
    assert!(said.text.contains("strikes.parquet"), "{}", said.text);
}

#[test]
fn copies_and_overlapping_parts_of_logs_give_one_row_for_a_strike() {
    let folder = demo(20);
    let dir = folder.path().display();
    let locked = json(&format!("dataset lock {dir}/set.toml"));
    json(&format!("dataset build {dir}/set.toml --out {dir}/before"));
    for log in logs(folder.path()) {
        let name = |ending: &str| log.with_extension(ending);
        fs::copy(&log, name("copy.mcap")).unwrap();
        for (ending, part) in [
            ("chunks.mcap", 0.0..1.1),
            ("begin.mcap", 0.0..0.6),
            ("end.mcap", 0.35..1.1),
        ] {
            fs::write(name(ending), rewritten(&log, part)).unwrap();
        }
    }
    let again = json(&format!("dataset lock {dir}/set.toml"));
    let count = |said: &Value| said["logs"].as_array().map_or(0, Vec::len);
    // A copy is no other log; what was cut or packed otherwise is.
    assert_eq!(count(&again), 4 * count(&locked));
    assert_eq!(again["strikes"], 20);
    assert!(
        again["rejected"].as_u64() > Some(20),
        "the others are duplicates"
    );
    json(&format!("dataset build {dir}/set.toml --out {dir}/after"));
    let ids = |name: &str| -> BTreeSet<String> {
        let strikes = tables::read_strikes(&folder.path().join(name)).unwrap();
        strikes.into_iter().map(|strike| strike.id).collect()
    };
    assert_eq!(ids("before"), ids("after"));
    assert_eq!(ids("after").len(), 20);
}

#[test]
fn a_flipped_bit_a_lost_log_and_a_changed_recipe_are_reported() {
    let folder = demo(20);
    let (path, dir) = (folder.path(), folder.path().display());
    let all = json(&format!("dataset lock {dir}/set.toml"));
    let log = logs(path)[0].clone();
    let whole = fs::read(&log).unwrap();
    let mut flipped = whole.clone();
    let middle = flipped.len() / 2;
    flipped[middle] ^= 4;
    fs::write(&log, &flipped).unwrap();
    for command in ["lock", "build", "verify"] {
        let text = bad_input(&format!("dataset {command} {dir}/set.toml"));
        assert!(
            text.contains("session_000.mcap") && text.contains("not what it was"),
            "{command}: {text}"
        );
    }
    fs::remove_file(&log).unwrap();
    let text = bad_input(&format!("dataset verify {dir}/set.toml"));
    assert!(
        text.contains("session_000.mcap") && text.contains("--logs"),
        "{text}"
    );
    fs::write(&log, &whole).unwrap();
    assert_eq!(
        json(&format!("dataset verify {dir}/set.toml"))["same"],
        true
    );

    // A table that was changed is written again from the logs.
    json(&format!("dataset build {dir}/set.toml"));
    fs::write(path.join("set/strikes.parquet"), "").unwrap();
    let said = answer(&format!("dataset verify {dir}/set.toml"));
    assert_eq!(said.outcome, Outcome::Failed);
    assert!(
        said.text.contains("strikes.parquet") && said.text.contains("dataset build"),
        "{}",
        said.text
    );
    json(&format!("dataset build {dir}/set.toml"));
    assert_eq!(
        json(&format!("dataset verify {dir}/set.toml"))["same"],
        true
    );

    // Filters are a part of what is locked; globs name what they match.
    recipe(
        path,
        "logs = [\"logs/*_00[0-9].mcap\"]\n[filters]\nspeed = [0.7, 1.0]\n",
    );
    let text = bad_input(&format!("dataset verify {dir}/set.toml"));
    assert!(text.contains("filters"), "{text}");
    let fewer = json(&format!("dataset lock {dir}/set.toml"));
    let count = |said: &Value, key: &str| said[key].as_u64().unwrap();
    assert_eq!(
        count(&fewer, "strikes") + count(&fewer, "filtered"),
        count(&all, "strikes")
    );
    assert!(count(&fewer, "filtered") > 0);
    recipe(
        path,
        "logs = [\"logs\"]\n[filters]\nwithout = [\"session_000.mcap\"]\n",
    );
    let without = json(&format!("dataset lock {dir}/set.toml"));
    assert!(count(&without, "strikes") < count(&all, "strikes"));

    for (text, named) in [
        ("logs = [\"none\"]", "none"),
        ("logs = [\"none/*.mcap\"]", "nothing matches"),
        ("logs = [\"logs\"]\ncolour = 1", "colour"),
        ("logs = [\"logs\"]\n[filters]\nsped = [0.1, 0.2]", "sped"),
    ] {
        recipe(path, text);
        let refused = bad_input(&format!("dataset lock {dir}/set.toml"));
        assert!(refused.contains(named), "{text}: {refused}");
    }
    fs::write(path.join("set.lock"), "schema = 1").unwrap();
    recipe(path, "logs = [\"logs\"]");
    let refused = bad_input(&format!("dataset build {dir}/set.toml"));
    assert!(refused.contains("set.lock"), "{refused}");
}
