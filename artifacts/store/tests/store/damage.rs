//! Every kind of damage is refused by name.

use std::fs;
use std::path::Path;

use durable::sha256;
use proptest::prelude::*;
use serde_json::json;
use store::*;

use crate::fixture::{contents, names, published, with_effect};

/// A store whose one version was damaged, and how it is refused.
fn refusal(damage: impl FnOnce(&Path)) -> ArtifactError {
    let (_dir, store) = published(&with_effect());
    damage(&store.version_dir("v0001"));
    let error = store.load(None).expect_err("damaged");
    let verified = store.verify(Some("v0001")).expect_err("damaged");
    assert_eq!(verified.to_string(), error.to_string());
    error
}

/// Changes the manifest's JSON and gives it its true hash: what its own hash does not find.
fn manifest(change: impl FnOnce(&mut serde_json::Value)) -> impl FnOnce(&Path) {
    |dir| {
        let path = dir.join("manifest.json");
        let mut value: serde_json::Value =
            serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
        change(&mut value);
        let mut text = |hash: String| {
            value["sha256"] = hash.into();
            serde_json::to_string_pretty(&value).unwrap()
        };
        let hash = sha256(text("0".repeat(64)).as_bytes());
        fs::write(path, text(hash)).unwrap();
    }
}

/// Gives a file another content and the manifest its true hash: what hashes alone do not find.
fn forged(name: &'static str, content: impl FnOnce(Vec<u8>) -> Vec<u8>) -> impl FnOnce(&Path) {
    move |dir| {
        let path = dir.join(name);
        let bytes = content(fs::read(&path).unwrap());
        fs::write(&path, &bytes).unwrap();
        let sha256 = sha256(&bytes);
        manifest(|value| {
            value["files"][name] = json!({"sha256": sha256, "size": bytes.len()});
        })(dir);
    }
}

fn replace(from: &'static str, to: &'static str) -> impl FnOnce(Vec<u8>) -> Vec<u8> {
    move |bytes| {
        let text = String::from_utf8(bytes).unwrap();
        assert!(text.contains(from), "{text}");
        text.replace(from, to).into_bytes()
    }
}

fn refused(damage: impl FnOnce(&Path), said: &str) {
    let error = refusal(damage).to_string();
    assert!(
        error.starts_with("load v0001: ") && error.contains(said),
        "{said}: {error}"
    );
}

#[test]
fn every_kind_of_damage_is_refused_by_name() {
    let write = |name: &'static str, content: &'static str| {
        move |dir: &Path| fs::write(dir.join(name), content).unwrap()
    };
    let remove = |name: &'static str| move |dir: &Path| fs::remove_file(dir.join(name)).unwrap();
    let unlisted = |name: &'static str| {
        manifest(move |m| drop(m["files"].as_object_mut().unwrap().remove(name)))
    };
    let bad = "manifest.json is damaged";

    refused(remove("manifest.json"), "it has no manifest.json");
    refused(write("manifest.json", ""), &format!("{bad} (EOF"));
    let (cut, few) = ("{\"schema\": 2", "{\"schema\": 2}");
    refused(write("manifest.json", cut), &format!("{bad} (EOF"));
    refused(
        write("manifest.json", few),
        &format!("{bad} (missing field"),
    );
    let sd_changed = |dir: &Path| {
        let path = dir.join("manifest.json");
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains("0.03"), "{text}");
        fs::write(path, text.replacen("0.03", "0.02", 1)).unwrap();
    };
    refused(sd_changed, "manifest.json was changed");
    let set = |key: &'static str, value: serde_json::Value| manifest(move |m| m[key] = value);
    refused(
        set("colour", 1.into()),
        &format!("{bad} (unknown field `colour`"),
    );
    refused(set("schema", 9.into()), "its layout is schema 9");
    refused(set("carom", "9.0.0".into()), "carom 9.0.0 wrote it");
    refused(set("carom", "".into()), "carom  wrote it");
    refused(
        set("mujoco", "3.0.0".into()),
        "identified with MuJoCo 3.0.0",
    );
    let lists = "its manifest lists [residual.safetensors, residual_sysid";
    refused(unlisted("rig.toml"), lists);
    let outside = manifest(|m| m["files"]["../rig.toml"] = m["files"]["rig.toml"].clone());
    refused(outside, "its manifest lists [../rig.toml");
    let holds = "a version holds [residual.safetensors";
    refused(unlisted("world_sysid.toml"), holds);
    for name in ["notes.txt", ".world.toml.partial"] {
        refused(write(name, ""), &format!("{name} is no part of it"));
    }
    let more = |dir: &Path| fs::create_dir(dir.join("more")).unwrap();
    refused(more, "more is no part of it");
    let no_part = "residual.safetensors is no part of it";
    refused(unlisted("residual.safetensors"), no_part);
    for name in ["residual.safetensors", "world_sysid.toml"] {
        refused(remove(name), &format!("{name} is missing"));
    }
    let long = |dir: &Path| claim_length(dir, "world.toml", 1 << 40);
    refused(long, "world.toml has 1099511627776 bytes, more than");
    refused(write("world.toml", ""), "world.toml has 0 bytes instead of");
    let flipped = |dir: &Path| {
        let path = dir.join("residual.safetensors");
        let mut bytes = fs::read(&path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(path, bytes).unwrap();
    };
    refused(flipped, "residual.safetensors was changed");
    let exchanged = |dir: &Path| {
        let from = dir.join("residual_sysid.safetensors");
        fs::copy(from, dir.join("residual.safetensors")).unwrap();
    };
    refused(exchanged, "residual.safetensors was changed");
    for (mass, said) in [("mas = 0.1", "object.mas"), ("mass = 0.2", "another rig's")] {
        refused(forged("rig.toml", replace("mass = 0.1", mass)), said);
    }
    refused(set("rig", "00".into()), "instead of 00");
    let no_text = forged("world.toml", |_| vec![0xff]);
    refused(no_text, "world.toml makes no sense (");
    for (name, from, to, said) in [
        ("world.toml", "friction", "fiction", "fiction"),
        ("world_sysid.toml", "0.25", "nan", "NaN"),
        ("world_sysid.toml", "0.5", "inf", "not finite"),
        ("world.toml", "viscous_drag", "sticky_drag", "sticky_drag"),
    ] {
        let error = refusal(forged(name, replace(from, to))).to_string();
        let is_of_it = error.contains(&format!("{name} makes no sense (failed to "));
        assert!(is_of_it && error.contains(said), "{said}: {error}");
    }
    let cut = forged("residual.safetensors", |bytes| bytes[..99].to_vec());
    refused(cut, "residual.safetensors makes no sense (failed to ");
    let endless = forged("residual.safetensors", |mut bytes| {
        let end = bytes.len();
        bytes[end - 4..].copy_from_slice(&f32::INFINITY.to_le_bytes());
        bytes
    });
    refused(endless, "not finite");
    let renamed = forged("residual_sysid.safetensors", |mut bytes| {
        // Same length, another name in the header.
        let mut names = bytes.windows(6);
        let at = names.position(|window| window == b"layer0").unwrap();
        bytes[at] = b'L';
        bytes
    });
    refused(
        renamed,
        "residual_sysid.safetensors makes no sense (failed to ",
    );
    refused(set("default_model", "best".into()), "best");
    let residual = "/explained/sysid_residual";
    for (path, wrong, said) in [
        (
            format!("{residual}/d_speed"),
            json!([0.9, 0.5]),
            "explained.sysid_residual.d_speed",
        ),
        (
            format!("{residual}/displacement"),
            json!(-0.1),
            "displacement",
        ),
        (
            "/trained_region/stop_x".into(),
            json!([0.9, 0.5]),
            "trained_region.stop_x",
        ),
        (
            "/metrics/nominal/mean".into(),
            json!(-0.1),
            "metrics.nominal",
        ),
    ] {
        let wrong = manifest(|m| *m.pointer_mut(&path).unwrap() = wrong);
        refused(wrong, &format!("{said} of its manifest"));
    }
    refused(
        manifest(|m| m["trained_region"]["stop_x"] = json!([null, 0.5])),
        "null",
    );
}

#[test]
fn a_default_model_that_is_not_there_is_refused() {
    let (_dir, store) = published(&contents(0.2));
    manifest(|m| m["default_model"] = "effect".into())(&store.version_dir("v0001"));
    let error = store.load(None).expect_err("damaged");
    assert!(
        error.to_string().contains("names the model effect"),
        "{error}"
    );
}

#[test]
fn a_link_in_place_of_a_file_is_refused() {
    let error = refusal(|dir| {
        let (path, elsewhere) = (dir.join("rig.toml"), dir.with_file_name("elsewhere"));
        fs::rename(&path, &elsewhere).unwrap();
        std::os::unix::fs::symlink(elsewhere, path).unwrap();
    });
    assert!(
        error.to_string().contains("rig.toml is no part of it"),
        "{error}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    #[test]
    fn any_flipped_or_cut_byte_is_refused(
        file in 0usize..6, at in any::<prop::sample::Index>(), flip in 1u8.., cut: bool,
    ) {
        let (_dir, store) = published(&with_effect());
        let dir = store.version_dir("v0001");
        let name = names(&dir).into_iter().nth(file).unwrap();
        let mut content = fs::read(dir.join(&name)).unwrap();
        let at = at.index(content.len());
        if cut { content.truncate(at) } else { content[at] ^= flip }
        fs::write(dir.join(&name), content).unwrap();
        let error = store.load(None).expect_err("damaged").to_string();
        prop_assert!(error.starts_with("load v0001"), "{}", error);
    }

    #[test]
    fn manifests_read_back(mean in 0.0..1e3, low in -1e3..1e3f64, seed: u64, name: String) {
        let mut contents = contents(0.2);
        contents.provenance.metrics.get_mut(&Model::Nominal).unwrap().mean = mean;
        contents.provenance.trained_region.bearing = [low, low + 1.0].into();
        contents.provenance.seeds.insert(name.clone(), seed);
        contents.provenance.inputs[0].name = name;
        let (_dir, store) = published(&contents);
        let manifest = store.show(None).unwrap();
        prop_assert_eq!(manifest.provenance.metrics, contents.provenance.metrics);
        prop_assert_eq!(manifest.provenance.trained_region, contents.provenance.trained_region);
        prop_assert_eq!(manifest.provenance.seeds, contents.provenance.seeds);
        prop_assert_eq!(manifest.provenance.inputs, contents.provenance.inputs);
    }
}

/// A sparse file of so many bytes, and a manifest that claims them.
fn claim_length(dir: &Path, name: &'static str, length: u64) {
    let file = fs::File::options().write(true).open(dir.join(name));
    file.and_then(|file| file.set_len(length)).unwrap();
    manifest(|value| value["files"][name]["size"] = length.into())(dir);
}
