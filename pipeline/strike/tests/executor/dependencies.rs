//! What the executor is not built from: it runs on the robot's own computer.

use std::process::Command;

#[test]
fn no_tables_and_no_learning_are_linked() {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--offline", "--locked", "--package", "strike"])
        .args(["--edges", "normal,build", "--prefix", "none"])
        .args(["--format", "{p}"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let tree = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{:?}", output.stderr);
    let names: Vec<&str> = tree
        .lines()
        .filter_map(|line| line.split(' ').next())
        .collect();
    assert!(
        names.contains(&"strike") && names.contains(&"mujoco-rs"),
        "{tree}"
    );
    assert!(
        !names.contains(&"minisign"),
        "it checks signatures and makes none"
    );
    for absent in [
        "polars", "arrow", "parquet", "burn", "tokio", "rustls", "openssl", "rusqlite",
    ] {
        let is_it = |name: &&&str| **name == absent || name.starts_with(&format!("{absent}-"));
        assert_eq!(names.iter().find(is_it), None);
    }
}
