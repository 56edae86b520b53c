//! What the executor is not built from: it runs on the robot's own computer.

use std::process::Command;

/// Every package that it is built from, with these flags.
fn packages(flags: &[&str]) -> Vec<String> {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--offline", "--locked", "--package", "strike"])
        .args(["--edges", "normal,build", "--prefix", "none"])
        .args(flags)
        .args(["--format", "{p}"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let tree = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{:?}", output.stderr);
    let names: Vec<String> = tree
        .lines()
        .filter_map(|line| line.split(' ').next())
        .map(String::from)
        .collect();
    assert!(
        names.iter().any(|name| name == "strike") && names.iter().any(|name| name == "mujoco-rs"),
        "{tree}"
    );
    names
}

#[test]
fn what_is_shipped_has_no_embedded_rig_and_no_renderer() {
    let has = |flags: &[&str], name: &str| packages(flags).iter().any(|package| package == name);
    assert!(has(&[], "rig") && has(&[], "render"));
    for absent in ["rig", "render"] {
        assert!(!has(&["--no-default-features"], absent), "{absent}");
    }
}

#[test]
fn no_tables_and_no_learning_are_linked() {
    let (names, plain) = (packages(&[]), packages(&["--no-default-features"]));
    assert!(
        names.iter().all(|name| name != "minisign"),
        "it checks signatures and makes none"
    );
    let is_it =
        |name: &&String, absent: &str| **name == absent || name.starts_with(&format!("{absent}-"));
    for absent in ["polars", "arrow", "parquet", "burn", "openssl", "rusqlite"] {
        assert_eq!(names.iter().find(|name| is_it(name, absent)), None);
    }
    // Object stores alone need them (feature `url`).
    for absent in ["tokio", "rustls", "ureq", "object_store"] {
        assert_eq!(plain.iter().find(|name| is_it(name, absent)), None);
    }
}
