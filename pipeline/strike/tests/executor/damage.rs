//! With a key configured: every damage that the program refuses before any robot is touched.

use std::fs;
use std::path::Path;

use store::{SIGNATURE, Signer};

use crate::commands::{stderr, stdout, strike};
use crate::computer::{Computer, forge, manifest, replace};
use crate::fixture::{self, Signing};

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
        let printed = stderr(&output);
        assert_eq!(output.status.code(), Some(*code), "{name}: {printed}");
        assert!(printed.contains(said), "{name}: {printed}");
        assert_eq!(stdout(&output), "", "{name}");
        assert!(!computer.store.path().join("strikes").exists(), "{name}");
    }
}
