//! With a key configured: what the program refuses before any robot is touched, of what [`store`] refuses two examples.

use std::fs;
use std::path::Path;

use store::{SIGNATURE, Signer};

use crate::commands::{stderr, stdout, strike};
use crate::computer::{Computer, forge, manifest, replace};
use crate::fixture::Signing;

/// A name; how the program ends; what it says; what is done to v0002, the version in use.
type Damage = (&'static str, i32, &'static str, fn(&Computer, &Path));

const SIGNED: &str = "carom v0002 sequence 2";
const UNSOUND: &str = "signature does not hold";
const UNVERIFIED: &str = "verification failed";

const DAMAGES: &[Damage] = &[
    ("unsigned", 4, "not signed", |_, dir| {
        fs::remove_file(dir.join(SIGNATURE)).unwrap();
    }),
    ("signed by another key", 4, "different key", |_, dir| {
        let manifest = fs::read(dir.join("manifest.json")).unwrap();
        let signed = Signing::new().sign(&manifest, SIGNED).unwrap();
        fs::write(dir.join(SIGNATURE), signed).unwrap();
    }),
    ("signature cut off", 4, UNSOUND, |_, dir| {
        halve(&dir.join(SIGNATURE))
    }),
    ("signature emptied", 4, UNSOUND, |_, dir| {
        fs::write(dir.join(SIGNATURE), "").unwrap();
    }),
    (
        "signature of other bytes",
        4,
        UNVERIFIED,
        |computer, dir| {
            let other = computer.version("v0001").join(SIGNATURE);
            fs::copy(other, dir.join(SIGNATURE)).unwrap();
        },
    ),
    ("count of the signature raised", 4, UNVERIFIED, |_, dir| {
        let text = fs::read_to_string(dir.join(SIGNATURE)).unwrap();
        let text = text.replace("sequence 2", "sequence 9");
        fs::write(dir.join(SIGNATURE), text).unwrap();
    }),
    (
        "comment without version",
        4,
        "names no version",
        |computer, _| {
            computer.sign("v0002", "timestamp:1700000000");
        },
    ),
    (
        "an old one under a new name",
        4,
        "made for v0001",
        |computer, dir| {
            fs::remove_dir_all(dir).unwrap();
            fs::rename(computer.version("v0001"), dir).unwrap();
        },
    ),
    ("world forged with its hash", 4, UNVERIFIED, |_, dir| {
        forge(dir, "world.toml", replace("0.25", "0.05"));
    }),
    ("another default model", 4, UNVERIFIED, |_, dir| {
        manifest(dir, |m| m["default_model"] = "nominal".into());
    }),
    ("manifest cut off", 4, UNVERIFIED, |_, dir| {
        halve(&dir.join("manifest.json"))
    }),
    (
        "a flipped bit",
        2,
        "residual.safetensors was changed",
        |_, dir| {
            let mut bytes = fs::read(dir.join("residual.safetensors")).unwrap();
            let middle = bytes.len() / 2;
            bytes[middle] ^= 1;
            fs::write(dir.join("residual.safetensors"), bytes).unwrap();
        },
    ),
    ("another schema", 2, "schema 9", |computer, dir| {
        manifest(dir, |m| m["schema"] = 9.into());
        computer.sign("v0002", SIGNED);
    }),
    (
        "latest set back",
        4,
        "v0001: it is older than v0002",
        |computer, _| {
            let config = computer.own("strike.toml");
            let plan = ["--to", "0.6", "0.1", "--config", config.to_str().unwrap()];
            let seen = strike(computer.store.path(), &plan);
            assert_eq!(seen.status.code(), Some(0), "{}", stderr(&seen));
            fs::write(computer.store.path().join("latest"), "v0001\n").unwrap();
        },
    ),
    (
        "a damaged record of what was seen",
        2,
        "carom.seen",
        |computer, _| {
            fs::write(computer.own("carom.seen"), "{}").unwrap();
        },
    ),
    ("a key that is none", 2, "carom.pub", |computer, _| {
        fs::write(computer.own("carom.pub"), "").unwrap();
    }),
    ("the key missing", 2, "carom.pub", |computer, _| {
        fs::remove_file(computer.own("carom.pub")).unwrap();
    }),
    (
        "a configuration that is none",
        2,
        "strike.toml",
        |computer, _| {
            fs::write(computer.own("strike.toml"), "kye = 1").unwrap();
        },
    ),
];

fn halve(file: &Path) {
    let bytes = fs::read(file).unwrap();
    fs::write(file, &bytes[..bytes.len() / 2]).unwrap();
}

#[test]
fn every_kind_of_damage_is_refused_by_name_before_a_robot_is_touched() {
    for (name, code, said, damage) in DAMAGES {
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
