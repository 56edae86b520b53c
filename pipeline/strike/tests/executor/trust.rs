//! With a key configured: what is remembered, and how a person goes back.

use std::fs;
use std::process::Output;
use std::sync::Arc;

use serde_json::{Value, json};
use store::{Signer, Store};
use tempfile::TempDir;

use crate::commands::{stderr, stdout, strike};
use crate::computer::Computer;
use crate::fixture;

#[test]
fn what_is_signed_and_newest_strikes_and_is_remembered() {
    let computer = Computer::new();
    let output = computer.strike(&["--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(!stderr(&output).contains("vouches"), "{}", stderr(&output));
    let seen: Value =
        serde_json::from_slice(&fs::read(computer.own("carom.seen")).unwrap()).unwrap();
    let manifest = fs::read(computer.version("v0002").join("manifest.json")).unwrap();
    let manifest: Value = serde_json::from_slice(&manifest).unwrap();
    assert_eq!(
        seen,
        json!({"sequence": 2, "version": "v0002", "manifest": manifest["sha256"]})
    );
    // Named outright, an older one is refused too.
    let output = computer.strike(&["--version", "v0001"]);
    let printed = stderr(&output);
    assert_eq!(output.status.code(), Some(4), "{printed}");
    assert!(printed.contains("not_trusted"), "{printed}");
}

#[test]
fn two_stores_that_sign_with_one_key_are_distinguished() {
    let computer = Computer::new();
    assert_eq!(computer.strike(&[]).status.code(), Some(0));
    // The same names and counts, other contents.
    let other = TempDir::new().unwrap();
    fixture::publish_signed(other.path(), 3, &computer.signing);
    fixture::publish_signed(other.path(), 4, &computer.signing);
    let config = computer.own("strike.toml");
    let usual = ["--to", "0.6", "0.1", "--json", "--config"];
    let usual = [usual.as_slice(), &[config.to_str().unwrap()]].concat();
    let output = strike(other.path(), &usual);
    assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
    let refusal: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(refusal["refused"], "not_trusted");
    let detail = refusal["detail"].as_str().unwrap();
    assert!(
        detail.contains("counts 2") && detail.contains("another v0002"),
        "{detail}"
    );
    // Its own store still is the one that is trusted.
    assert_eq!(computer.strike(&[]).status.code(), Some(0));
}

#[test]
fn an_arm_whose_rig_file_says_too_little_is_not_connected_to() {
    let computer = Computer::new();
    let config = computer.own("strike.toml");
    let arguments = "--from 0.3 0.0 --to 0.6 0.1 --robot xarm:127.0.0.1 --json --config";
    let arguments = arguments.split(' ').chain([config.to_str().unwrap()]);
    let arguments: Vec<&str> = arguments.collect();
    let refusal = |output: Output, code: i32| -> Value {
        assert_eq!(output.status.code(), Some(code), "{}", stderr(&output));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let answer = refusal(strike(computer.store.path(), &arguments), 4);
    assert_eq!(answer["refused"], "not_ready");
    assert!(
        answer["detail"].as_str().unwrap().contains("lacks base"),
        "{answer}"
    );
    // Another rig's artifact is refused before the arm is thought of.
    let mut other = fixture::rig();
    other.object.mass = 0.3;
    fs::write(computer.own("rig.toml"), other.to_toml()).unwrap();
    let answer = refusal(strike(computer.store.path(), &arguments), 4);
    assert_eq!(answer["refused"], "other_rig");
}

#[test]
fn a_record_of_before_manifests_were_kept_is_read_and_completed() {
    let computer = Computer::new();
    let seen = computer.own("carom.seen");
    fs::write(&seen, "{\"sequence\":2,\"version\":\"v0002\"}\n").unwrap();
    assert_eq!(computer.strike(&[]).status.code(), Some(0));
    let kept: Value = serde_json::from_slice(&fs::read(&seen).unwrap()).unwrap();
    assert!(kept["manifest"].is_string(), "{kept}");
}

#[test]
fn what_was_seen_is_not_changed_while_another_executor_holds_it() {
    let computer = Computer::new();
    let lock = durable::Lock::acquire(&computer.own(".carom.seen.lock")).unwrap();
    let output = computer.strike(&[]);
    assert_eq!(output.status.code(), Some(75), "{}", stderr(&output));
    assert!(!computer.own("carom.seen").exists());
    drop(lock);
    assert_eq!(computer.strike(&[]).status.code(), Some(0));
}

#[test]
fn an_artifact_of_another_rig_is_not_remembered() {
    let computer = Computer::new();
    let mut other = fixture::rig();
    other.object.mass = 0.3;
    fs::write(computer.own("rig.toml"), other.to_toml()).unwrap();
    assert_eq!(computer.strike(&[]).status.code(), Some(4));
    assert!(!computer.own("carom.seen").exists());
}

#[test]
fn going_back_is_a_signed_act_and_what_was_left_does_not_return() {
    let computer = Computer::new();
    assert_eq!(computer.strike(&[]).status.code(), Some(0));
    let signing: Arc<dyn Signer> = computer.signing.clone();
    let store = Store::open(computer.store.path());
    let error = store.rollback(None).expect_err("needs the key").to_string();
    assert!(error.contains("--key"), "{error}");
    let store = store.signed_by(signing);
    assert_eq!(store.rollback(None).unwrap(), "v0001");
    let output = computer.strike(&[]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stdout(&output).contains("v0001"));
    fs::write(computer.store.path().join("latest"), "v0002\n").unwrap();
    let output = computer.strike(&[]);
    assert_eq!(output.status.code(), Some(4));
    let printed = stderr(&output);
    assert!(
        printed.contains("v0002: it is older than v0001"),
        "{printed}"
    );
    // Forward again, signed again.
    assert_eq!(store.rollback(Some("v0002")).unwrap(), "v0002");
    assert_eq!(computer.strike(&[]).status.code(), Some(0));
}
