//! A robot's computer with a key configured, and changes that keep a version's hashes true.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::Arc;

use durable::sha256;
use serde_json::{Value, json};
use store::{SIGNATURE, Signer};
use tempfile::TempDir;

use crate::commands::strike;
use crate::fixture::{self, Signing};

/// A robot's computer: a store with v0001 and v0002, both signed, and the public key in a folder of its own.
pub struct Computer {
    pub store: TempDir,
    pub own: TempDir,
    pub signing: Arc<Signing>,
}

impl Computer {
    pub fn new() -> Self {
        let signing = Signing::new();
        let (store, own) = (TempDir::new().unwrap(), TempDir::new().unwrap());
        fixture::publish_signed(store.path(), 1, &signing);
        fixture::publish_signed(store.path(), 2, &signing);
        let public = signing.pair.pk.to_box().unwrap().into_string();
        fs::write(own.path().join("carom.pub"), public).unwrap();
        fs::write(own.path().join("rig.toml"), fixture::rig().to_toml()).unwrap();
        let config = "key = \"carom.pub\"\nrig = \"rig.toml\"\n";
        fs::write(own.path().join("strike.toml"), config).unwrap();
        Self {
            store,
            own,
            signing,
        }
    }

    pub fn version(&self, name: &str) -> PathBuf {
        self.store.path().join("versions").join(name)
    }

    pub fn own(&self, name: &str) -> PathBuf {
        self.own.path().join(name)
    }

    pub fn strike(&self, arguments: &[&str]) -> Output {
        let config = self.own("strike.toml");
        let config = config.to_str().unwrap();
        let usual = ["--to", "0.6", "0.1", "--robot", "sim", "--config", config];
        strike(self.store.path(), &[usual.as_slice(), arguments].concat())
    }

    /// Signs a version anew after its manifest was changed: what only the holder of the key can do.
    pub fn sign(&self, version: &str, comment: &str) {
        let manifest = fs::read(self.version(version).join("manifest.json")).unwrap();
        let text = self.signing.sign(&manifest, comment).unwrap();
        fs::write(self.version(version).join(SIGNATURE), text).unwrap();
    }
}

/// Changes the manifest and gives it its true hash.
pub fn manifest(dir: &Path, change: impl FnOnce(&mut Value)) {
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
pub fn forge(dir: &Path, name: &str, change: impl FnOnce(Vec<u8>) -> Vec<u8>) {
    let bytes = change(fs::read(dir.join(name)).unwrap());
    fs::write(dir.join(name), &bytes).unwrap();
    let sha256 = sha256(&bytes);
    manifest(dir, |value| {
        value["files"][name] = json!({"sha256": sha256, "size": bytes.len()});
    });
}

pub fn replace(from: &'static str, to: &'static str) -> impl FnOnce(Vec<u8>) -> Vec<u8> {
    move |bytes| {
        let text = String::from_utf8(bytes).unwrap();
        assert!(text.contains(from), "{text}");
        text.replace(from, to).into_bytes()
    }
}
