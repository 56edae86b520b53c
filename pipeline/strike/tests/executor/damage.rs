//! With a key configured: what the program refuses before any robot is touched, of what [`store`] refuses two examples.

use std::fs;
use std::path::Path;

use store::{SIGNATURE, Signer};

use crate::commands::{stderr, stdout, strike};
use crate::computer::{Computer, forge, manifest, replace};
use crate::fixture::Signing;

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
        "another schema",
        |computer, dir| {
            manifest(dir, |m| m["schema"] = 9.into());
            computer.sign("v0002", SIGNED);
        },
        2,
        "schema 9",
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
        let printed = stderr(&output);
        assert_eq!(output.status.code(), Some(*code), "{name}: {printed}");
        assert!(printed.contains(said), "{name}: {printed}");
        assert_eq!(stdout(&output), "", "{name}");
        assert!(!computer.store.path().join("strikes").exists(), "{name}");
    }
}
