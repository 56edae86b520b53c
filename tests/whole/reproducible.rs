//! The same bytes with any number of threads and any order of the logs.

use std::{fs, path::Path};

use crate::carom;

const FILES: [&str; 8] = [
    "strikes.parquet",
    "tracks.parquet",
    "solutions.parquet",
    "residuals.parquet",
    "world.toml",
    "diagnosis.json",
    "evaluation.json",
    "versions/v0001/manifest.json",
];

fn bytes(dir: &Path) -> Vec<Vec<u8>> {
    FILES
        .iter()
        .map(|name| fs::read(dir.join(name)).unwrap_or_else(|error| panic!("{name}: {error}")))
        .collect()
}

#[test]
fn one_thread_and_two_give_the_same_bytes_in_any_order_of_logs() {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path().display();
    carom(&format!("demo --strikes 60 --seed 5 --out {dir}/rig"));
    let mut logs: Vec<String> = fs::read_dir(folder.path().join("rig/logs"))
        .expect("logs")
        .map(|entry| entry.expect("a log").path().display().to_string())
        .collect();
    logs.sort();
    carom(&format!(
        "--threads 1 run {} --rig {dir}/rig/rig.toml --out {dir}/one",
        logs.join(" ")
    ));
    logs.reverse();
    carom(&format!(
        "--threads 2 run {} --rig {dir}/rig/rig.toml --out {dir}/two",
        logs.join(" ")
    ));
    let (one, two) = (
        bytes(&folder.path().join("one")),
        bytes(&folder.path().join("two")),
    );
    for (name, (one, two)) in FILES.iter().zip(one.iter().zip(&two)) {
        assert!(one == two, "{name} differs");
    }
}
