//! With a key configured: what the program refuses before any robot is touched, and how a person goes back.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::Arc;

use durable::sha256;
use serde_json::{Value, json};
use store::{SIGNATURE, Signer, Store};
use tempfile::TempDir;

use crate::commands::{stderr, stdout, strike};
use crate::fixture::{self, Signing};

/// A robot's computer: a store with v0001 and v0002, both signed, and the public key in a folder of its own.
struct Computer {
    store: TempDir,
    own: TempDir,
    signing: Arc<Signing>,
}

impl Computer {
    fn new() -> Self {
        let signing = Signing::new();
        let (store, own) = (TempDir::new().unwrap(), TempDir::new().unwrap());
        fixture::publish_signed(store.path(), 1, &signing);
        fixture::publish_signed(store.path(), 2, &signing);
        fs::write(own.path().join("carom.pub"), signing.public()).unwrap();
        fs::write(own.path().join("rig.toml"), fixture::rig().to_toml()).unwrap();
        let config = "key = \"carom.pub\"\nrig = \"rig.toml\"\n";
        fs::write(own.path().join("strike.toml"), config).unwrap();
        Self {
            store,
            own,
            signing,
        }
    }

    fn version(&self, name: &str) -> PathBuf {
        self.store.path().join("versions").join(name)
    }

    fn own(&self, name: &str) -> PathBuf {
        self.own.path().join(name)
    }

    fn strike(&self, arguments: &[&str]) -> Output {
        let config = self.own("strike.toml");
        let config = config.to_str().unwrap();
        let usual = ["--to", "0.6", "0.1", "--robot", "sim", "--config", config];
        strike(self.store.path(), &[usual.as_slice(), arguments].concat())
    }

    /// Signs a version anew after its manifest was changed: what only the holder of the key can do.
    fn sign(&self, version: &str, comment: &str) {
        let manifest = fs::read(self.version(version).join("manifest.json")).unwrap();
        let text = self.signing.sign(&manifest, comment).unwrap();
        fs::write(self.version(version).join(SIGNATURE), text).unwrap();
    }
}

/// Changes the manifest and gives it its true hash.
fn manifest(dir: &Path, change: impl FnOnce(&mut Value)) {
    let path = dir.join("manifest.json");
    let mut value: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    change(&mut value);
    let mut text = |hash: String| {
        value["sha256"] = hash.into();
        serde_json::to_string_pretty(&value).unwrap()
    };
    let hash = sha256(text("0".repeat(64)).as_bytes());
    fs::write(path, text(hash)).unwrap();
}

/// Changes a file and gives the manifest its true hash.
fn forge(dir: &Path, name: &str, change: impl FnOnce(Vec<u8>) -> Vec<u8>) {
    let bytes = change(fs::read(dir.join(name)).unwrap());
    fs::write(dir.join(name), &bytes).unwrap();
    let sha256 = sha256(&bytes);
    manifest(dir, |value| {
        value["files"][name] = json!({"sha256": sha256, "size": bytes.len()});
    });
}

fn replace(from: &'static str, to: &'static str) -> impl FnOnce(Vec<u8>) -> Vec<u8> {
    move |bytes| {
        let text = String::from_utf8(bytes).unwrap();
        assert!(text.contains(from), "{text}");
        text.replace(from, to).into_bytes()
    }
}

/// What is done to v0002, the version in use; how the program ends; what it says.
type Damage = (&'static str, fn(&Computer, &Path), i32, &'static str);

const SIGNED: &str = "carom v0002 sequence 2";

const DAMAGES: &[Damage] = &[
    (
        "unsigned",
        |_, dir| fs::remove_file(dir.join(SIGNATURE)).unwrap(),
        4,
        "not signed",
    ),
    (
        "signed by another key",
        |_, dir| {
            let manifest = fs::read(dir.join("manifest.json")).unwrap();
            fs::write(
                dir.join(SIGNATURE),
                Signing::new().sign(&manifest, SIGNED).unwrap(),
            )
            .unwrap();
        },
        4,
        "different key",
    ),
    (
        "signature cut off",
        |_, dir| {
            let text = fs::read(dir.join(SIGNATURE)).unwrap();
            fs::write(dir.join(SIGNATURE), &text[..text.len() / 2]).unwrap();
        },
        4,
        "signature does not hold",
    ),
    (
        "signature emptied",
        |_, dir| fs::write(dir.join(SIGNATURE), "").unwrap(),
        4,
        "signature does not hold",
    ),
    (
        "signature of other bytes",
        |computer, dir| {
            fs::copy(
                computer.version("v0001").join(SIGNATURE),
                dir.join(SIGNATURE),
            )
            .unwrap();
        },
        4,
        "verification failed",
    ),
    (
        "count of the signature raised",
        |_, dir| {
            let text = fs::read_to_string(dir.join(SIGNATURE)).unwrap();
            fs::write(
                dir.join(SIGNATURE),
                text.replace("sequence 2", "sequence 9"),
            )
            .unwrap();
        },
        4,
        "verification failed",
    ),
    (
        "comment that names no version",
        |computer, _| computer.sign("v0002", "timestamp:1700000000"),
        4,
        "names no version",
    ),
    (
        "an old version under a new name",
        |computer, dir| {
            fs::remove_dir_all(dir).unwrap();
            fs::rename(computer.version("v0001"), dir).unwrap();
        },
        4,
        "made for v0001",
    ),
    (
        "world forged with its hash",
        |_, dir| forge(dir, "world.toml", replace("0.25", "0.05")),
        4,
        "verification failed",
    ),
    (
        "another default model",
        |_, dir| manifest(dir, |m| m["default_model"] = "nominal".into()),
        4,
        "verification failed",
    ),
    (
        "manifest cut off",
        |_, dir| {
            let bytes = fs::read(dir.join("manifest.json")).unwrap();
            fs::write(dir.join("manifest.json"), &bytes[..bytes.len() / 2]).unwrap();
        },
        4,
        "verification failed",
    ),
    (
        "no manifest",
        |_, dir| fs::remove_file(dir.join("manifest.json")).unwrap(),
        2,
        "no manifest.json",
    ),
    (
        "a flipped bit",
        |_, dir| {
            let mut bytes = fs::read(dir.join("residual.safetensors")).unwrap();
            let middle = bytes.len() / 2;
            bytes[middle] ^= 1;
            fs::write(dir.join("residual.safetensors"), bytes).unwrap();
        },
        2,
        "residual.safetensors was changed",
    ),
    (
        "a file cut off",
        |_, dir| fs::write(dir.join("world.toml"), "").unwrap(),
        2,
        "world.toml has 0 bytes",
    ),
    (
        "a file missing",
        |_, dir| fs::remove_file(dir.join("rig.toml")).unwrap(),
        2,
        "rig.toml is missing",
    ),
    (
        "a file too many",
        |_, dir| fs::write(dir.join("notes.txt"), "").unwrap(),
        2,
        "notes.txt",
    ),
    (
        "a folder too many",
        |_, dir| fs::create_dir(dir.join("more")).unwrap(),
        2,
        "more",
    ),
    (
        "a link in place of a file",
        |computer, dir| {
            fs::rename(dir.join("rig.toml"), computer.own("elsewhere")).unwrap();
            std::os::unix::fs::symlink(computer.own("elsewhere"), dir.join("rig.toml")).unwrap();
        },
        2,
        "rig.toml",
    ),
    (
        "another schema",
        |computer, dir| {
            manifest(dir, |m| m["schema"] = 9.into());
            computer.sign("v0002", SIGNED);
        },
        2,
        "schema 9",
    ),
    (
        "another MuJoCo",
        |computer, dir| {
            manifest(dir, |m| m["mujoco"] = "3.0.0".into());
            computer.sign("v0002", SIGNED);
        },
        2,
        "MuJoCo 3.0.0",
    ),
    (
        "another carom",
        |computer, dir| {
            manifest(dir, |m| m["carom"] = "9.0.0".into());
            computer.sign("v0002", SIGNED);
        },
        2,
        "carom 9.0.0",
    ),
    (
        "a world that is no number",
        |computer, dir| {
            forge(dir, "world.toml", replace("0.25", "nan"));
            computer.sign("v0002", SIGNED);
        },
        2,
        "world.toml makes no sense",
    ),
    (
        "weights that are no numbers",
        |computer, dir| {
            forge(dir, "residual.safetensors", |mut bytes| {
                let end = bytes.len();
                bytes[end - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
                bytes
            });
            computer.sign("v0002", SIGNED);
        },
        2,
        "not finite",
    ),
    (
        "another rig",
        |computer, _| {
            let mut other = fixture::rig();
            other.striker.radius = 0.02;
            fs::write(computer.own("rig.toml"), other.to_toml()).unwrap();
        },
        4,
        "other_rig",
    ),
    (
        "latest set back",
        |computer, _| {
            let config = computer.own("strike.toml");
            let seen = strike(
                computer.store.path(),
                &["--to", "0.6", "0.1", "--config", config.to_str().unwrap()],
            );
            assert_eq!(seen.status.code(), Some(0), "{}", stderr(&seen));
            fs::write(computer.store.path().join("latest"), "v0001\n").unwrap();
        },
        4,
        "v0001: it is older than v0002",
    ),
    (
        "latest to nowhere",
        |computer, _| fs::write(computer.store.path().join("latest"), "v0007\n").unwrap(),
        2,
        "v0007",
    ),
    (
        "latest that is no name",
        |computer, _| fs::write(computer.store.path().join("latest"), "new\n").unwrap(),
        2,
        "latest",
    ),
    (
        "a damaged record of what was seen",
        |computer, _| fs::write(computer.own("carom.seen"), "{}").unwrap(),
        2,
        "carom.seen",
    ),
    (
        "a key that is none",
        |computer, _| fs::write(computer.own("carom.pub"), "").unwrap(),
        2,
        "carom.pub",
    ),
    (
        "the key missing",
        |computer, _| fs::remove_file(computer.own("carom.pub")).unwrap(),
        2,
        "carom.pub",
    ),
    (
        "a configuration that is none",
        |computer, _| fs::write(computer.own("strike.toml"), "kye = 1").unwrap(),
        2,
        "strike.toml",
    ),
];

#[test]
fn every_kind_of_damage_is_refused_by_name_before_a_robot_is_touched() {
    for (name, damage, code, said) in DAMAGES {
        let computer = Computer::new();
        damage(&computer, &computer.version("v0002"));
        let output = computer.strike(&[]);
        let told = stderr(&output);
        assert_eq!(output.status.code(), Some(*code), "{name}: {told}");
        assert!(told.contains(said), "{name}: {told}");
        assert_eq!(stdout(&output), "", "{name}");
        assert!(!computer.store.path().join("strikes").exists(), "{name}");
    }
}

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
    assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("not_trusted"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn two_stores_that_sign_with_one_key_are_told_apart() {
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
    let arguments = [
        "--to",
        "0.6",
        "0.1",
        "--robot",
        "xarm:127.0.0.1",
        "--json",
        "--config",
    ];
    let arguments = [arguments.as_slice(), &[config.to_str().unwrap()]].concat();
    let refusal = |output: Output, code: i32| -> Value {
        assert_eq!(output.status.code(), Some(code), "{}", stderr(&output));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let told = refusal(strike(computer.store.path(), &arguments), 4);
    assert_eq!(told["refused"], "not_ready");
    assert!(
        told["detail"].as_str().unwrap().contains("lacks base"),
        "{told}"
    );
    // Another rig's artifact is refused before the arm is thought of.
    let mut other = fixture::rig();
    other.object.mass = 0.3;
    fs::write(computer.own("rig.toml"), other.to_toml()).unwrap();
    let told = refusal(strike(computer.store.path(), &arguments), 4);
    assert_eq!(told["refused"], "other_rig");
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
    assert!(
        stderr(&output).contains("v0002: it is older than v0001"),
        "{}",
        stderr(&output)
    );
    // Forward again, signed again.
    assert_eq!(store.rollback(Some("v0002")).unwrap(), "v0002");
    assert_eq!(computer.strike(&[]).status.code(), Some(0));
}
