//! What the store promises: whole versions, refusals that name the damage, and a way back.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use durable::sha256;
use proptest::prelude::*;
use store::network::{LAYERS, Layer, SIZES};
use store::*;
use values::{Point, Rig, Shape};
use world::{AddedEffect, Estimate, World};

/// Weights that differ with their scale.
fn network(scale: f32) -> Network {
    let numbers = |count: usize| {
        (0..count)
            .map(|i| (i % 13) as f32 * scale)
            .collect::<Vec<_>>()
    };
    let layer = |i: usize| Layer {
        weight: numbers(SIZES[i] * SIZES[i + 1]),
        bias: numbers(SIZES[i + 1]),
    };
    Network::new((0..LAYERS).map(layer).collect()).expect("right shapes")
}

/// Contents that differ with their friction.
fn contents(friction: f64) -> Contents {
    let rig = Rig::demo(Shape::Cylinder);
    let mut world = World::nominal(&rig);
    world.parameters.insert(
        "friction".into(),
        Estimate::with_interval(friction, 0.1, 0.5),
    );
    let metrics = |mean| Metrics {
        mean,
        sd: 0.1 * mean,
        median: mean,
        p95: 2.0 * mean,
        n: 50,
        failed: 0,
    };
    let region = TrainedRegion::of(
        [
            (Point::new(0.2, 0.0), Point::new(0.5, 0.1)),
            (Point::new(0.3, 0.1), Point::new(0.9, -0.1)),
        ]
        .into_iter(),
    );
    Contents {
        rig,
        sysid: Calibrated {
            world,
            residual: Some(network(0.01)),
        },
        effect: None,
        provenance: Provenance {
            default_model: Model::SysidResidual,
            metrics: [
                (Model::Nominal, metrics(0.03)),
                (Model::SysidResidual, metrics(0.1 + 0.2)),
            ]
            .into(),
            noise_floor: Some(metrics(0.001)),
            trained_region: region.expect("two strikes"),
            strikes: Some(Logged {
                count: 2,
                last: 1.7e9,
            }),
            without_effects: false,
            seeds: [("split".to_string(), 7)].into(),
            inputs: vec![InputFile {
                name: "a.mcap".into(),
                sha256: "ab".repeat(32),
                size: 12,
            }],
            stages: vec![StageRecord {
                name: "train".into(),
                version: 3,
                settings: serde_json::json!({"rate": 1e-3, "batch": 32}),
            }],
        },
    }
}

fn with_effect() -> Contents {
    let mut contents = contents(0.25);
    let mut world = contents.sysid.world.clone();
    world.effects.push(AddedEffect {
        name: "viscous_drag".into(),
        parameters: [("rate".to_string(), Estimate::fixed(0.2))].into(),
    });
    contents.effect = Some(Calibrated {
        world,
        residual: Some(network(0.02)),
    });
    contents.provenance.default_model = Model::EffectResidual;
    contents
}

fn published(contents: &Contents) -> (tempfile::TempDir, Store) {
    let dir = tempfile::tempdir().expect("folder");
    let store = Store::open(dir.path());
    store.publish(contents).expect("publishes");
    (dir, store)
}

fn names(dir: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(dir).expect("folder");
    entries
        .map(|entry| {
            entry
                .expect("entry")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect()
}

fn bytes(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    names(dir)
        .into_iter()
        .map(|name| (name.clone(), fs::read(dir.join(name)).expect("reads")))
        .collect()
}

#[test]
fn what_is_loaded_is_what_was_published() {
    for (contents, models) in [(contents(0.2), 3), (with_effect(), 5)] {
        let (_dir, store) = published(&contents);
        let artifact = store.load(None).expect("whole");
        assert_eq!(artifact.version, "v0001");
        assert_eq!(
            (&artifact.rig, &artifact.sysid, &artifact.effect),
            (&contents.rig, &contents.sysid, &contents.effect)
        );
        assert_eq!(
            artifact.manifest.provenance.metrics,
            contents.provenance.metrics
        );
        assert_eq!(
            artifact.manifest.provenance.trained_region,
            contents.provenance.trained_region
        );
        assert_eq!(
            (artifact.manifest.mujoco, artifact.manifest.schema),
            (world::mujoco_version(), SCHEMA_VERSION)
        );
        assert_eq!(contents.models().len(), models);
    }
}

#[test]
fn each_model_has_its_world_and_residual() {
    let contents = with_effect();
    let (_dir, store) = published(&contents);
    let artifact = store.load(None).expect("whole");
    let effect = contents.effect.as_ref().expect("an effect");
    let part = |model| artifact.model(model).expect("holds all five");
    assert_eq!(part(Model::Nominal), (World::nominal(&contents.rig), None));
    assert_eq!(part(Model::Sysid), (contents.sysid.world.clone(), None));
    assert_eq!(
        part(Model::SysidResidual),
        (
            contents.sysid.world.clone(),
            contents.sysid.residual.as_ref()
        )
    );
    assert_eq!(part(Model::Effect), (effect.world.clone(), None));
    assert_eq!(
        part(Model::EffectResidual),
        (effect.world.clone(), effect.residual.as_ref())
    );
    let files = names(&store.version_dir("v0001"));
    assert!(files.contains("world_sysid.toml") && files.contains("residual_sysid.safetensors"));
}

#[test]
fn a_version_without_residual_has_no_residual_model() {
    let mut contents = contents(0.2);
    contents.sysid.residual = None;
    contents.provenance.metrics.remove(&Model::SysidResidual);
    contents.provenance.default_model = Model::Sysid;
    let (_dir, store) = published(&contents);
    let artifact = store.load(None).expect("whole");
    assert_eq!(artifact.models(), [Model::Nominal, Model::Sysid]);
    assert_eq!(artifact.model(Model::SysidResidual), None);
    assert_eq!(artifact.model(Model::EffectResidual), None);
}

#[test]
fn the_same_contents_have_the_same_bytes_and_make_no_new_version() {
    let (_a, store) = published(&with_effect());
    let (_b, other) = published(&with_effect());
    assert_eq!(
        bytes(&store.version_dir("v0001")),
        bytes(&other.version_dir("v0001"))
    );
    assert_eq!(store.publish(&with_effect()).expect("publishes"), "v0001");
    assert_eq!(store.publish(&contents(0.3)).expect("publishes"), "v0002");
    assert_eq!(store.publish(&with_effect()).expect("publishes"), "v0001");
    assert_eq!(store.latest().expect("a version"), "v0001");
    // A damaged version is not taken for the same.
    fs::write(store.version_dir("v0002").join("rig.toml"), "").expect("writes");
    assert_eq!(store.publish(&contents(0.3)).expect("publishes"), "v0003");
}

#[test]
fn the_store_lists_shows_and_rolls_back() {
    let (_dir, store) = published(&contents(0.2));
    store.publish(&contents(0.3)).expect("publishes");
    store.publish(&contents(0.4)).expect("publishes");
    let list = store.list().expect("lists");
    let row = |row: &Listing| (row.version.clone(), row.is_latest, row.manifest.is_ok());
    assert_eq!(
        list.iter().map(row).collect::<Vec<_>>(),
        [
            ("v0001".into(), false, true),
            ("v0002".into(), false, true),
            ("v0003".into(), true, true)
        ]
    );
    assert_eq!(
        store.show(Some("v0002")).expect("shows").provenance.seeds["split"],
        7
    );
    assert_eq!(store.rollback(None).expect("rolls back"), "v0002");
    assert_eq!(store.load(None).expect("whole").version, "v0002");
    assert_eq!(
        store.rollback(Some("v0003")).expect("forward again"),
        "v0003"
    );
    // Over a damaged version to a whole one; never to a damaged one.
    fs::remove_file(store.version_dir("v0002").join("rig.toml")).expect("removes");
    assert!(matches!(
        store.rollback(Some("v0002")),
        Err(ArtifactError::MissingFile { .. })
    ));
    assert_eq!(store.latest().expect("a version"), "v0003");
    assert_eq!(store.rollback(None).expect("rolls back"), "v0001");
    assert!(matches!(
        store.rollback(None),
        Err(ArtifactError::NothingBefore { .. })
    ));
    assert!(matches!(
        store.rollback(Some("v0009")),
        Err(ArtifactError::NoVersion { .. })
    ));
}

#[test]
fn what_was_rolled_back_is_not_published_again_in_silence() {
    let (_dir, store) = published(&contents(0.2));
    store.publish(&contents(0.3)).expect("publishes");
    store.publish(&contents(0.4)).expect("publishes");
    let latest = || store.latest().expect("a version");
    store.rollback(Some("v0001")).expect("rolls back");
    for (friction, version) in [(0.4, "v0003"), (0.3, "v0002")] {
        assert_eq!(store.publish(&contents(friction)).expect("there"), version);
        assert_eq!(latest(), "v0001", "{version} is withdrawn");
    }
    // What is new is used; what was withdrawn stays so until it is named.
    assert_eq!(store.publish(&contents(0.5)).expect("publishes"), "v0004");
    assert_eq!(latest(), "v0004");
    store.publish(&contents(0.3)).expect("there");
    assert_eq!(latest(), "v0004");
    store.rollback(Some("v0002")).expect("named");
    assert_eq!(store.publish(&contents(0.3)).expect("there"), "v0002");
    assert_eq!(latest(), "v0002");
    // A version that no rollback passed is used again where its inputs are.
    assert_eq!(store.publish(&contents(0.2)).expect("there"), "v0001");
    assert_eq!(latest(), "v0001");
}

/// A key pair of minisign.
#[derive(Debug)]
struct Signing {
    pair: minisign::KeyPair,
    key: Key,
}

impl Signing {
    fn new() -> Arc<Self> {
        let pair = minisign::KeyPair::generate_unencrypted_keypair().expect("a pair");
        let key = Key::parse(&pair.pk.to_base64()).expect("a key");
        Arc::new(Self { pair, key })
    }
}

impl Signer for Signing {
    fn key(&self) -> &Key {
        &self.key
    }

    fn sign(&self, content: &[u8], trusted_comment: &str) -> Result<String, String> {
        minisign::sign(None, &self.pair.sk, content, Some(trusted_comment), None)
            .map(minisign::SignatureBox::into_string)
            .map_err(|error| error.to_string())
    }
}

#[test]
fn signatures_count_what_is_put_to_use() {
    let (dir, plain) = published(&contents(0.2));
    let signing = Signing::new();
    let store = plain.clone().signed_by(signing.clone());
    let sequence = |version: &str| match store.load_trusted(Some(version), signing.key()) {
        Ok((_, sequence)) => Some(sequence),
        Err(ArtifactError::NotSigned { .. }) => None,
        Err(error) => panic!("failed to {error}"),
    };
    // Neither the manifest's bytes nor the name change by signing.
    let before = bytes(&store.version_dir("v0001"));
    assert_eq!(sequence("v0001"), None);
    assert_eq!(store.publish(&contents(0.2)).expect("signs"), "v0001");
    assert_eq!(sequence("v0001"), Some(1));
    let mut after = bytes(&store.version_dir("v0001"));
    after.remove(SIGNATURE);
    assert_eq!(before, after);
    assert_eq!(store.sign().expect("signed already"), "v0001");
    assert_eq!(store.publish(&contents(0.3)).expect("publishes"), "v0002");
    assert_eq!((sequence("v0001"), sequence("v0002")), (Some(1), Some(2)));
    assert_eq!(store.rollback(None).expect("rolls back"), "v0001");
    assert_eq!((sequence("v0001"), sequence("v0002")), (Some(3), Some(2)));
    // Withdrawn: not signed again.
    store.publish(&contents(0.3)).expect("there");
    assert_eq!(sequence("v0002"), Some(2));
    assert_eq!(store.publish(&contents(0.4)).expect("publishes"), "v0003");
    assert_eq!(sequence("v0003"), Some(4));

    // Without the key nothing that is signed is replaced, nor with another; a store that is handed over counts anew.
    for changed in [plain.publish(&contents(0.5)), plain.rollback(None)] {
        assert!(matches!(changed, Err(ArtifactError::NeedsKey { .. })));
    }
    assert_eq!(plain.latest().expect("a version"), "v0003");
    let other = Signing::new();
    let theirs = Store::open(dir.path()).signed_by(other.clone());
    for changed in [theirs.publish(&contents(0.5)), theirs.rollback(None)] {
        assert!(matches!(changed, Err(ArtifactError::OtherKey { .. })));
    }
    assert_eq!(theirs.sign().expect("handed over"), "v0003");
    assert!(matches!(
        store.load_trusted(None, signing.key()),
        Err(ArtifactError::BadSignature { .. })
    ));
    assert_eq!(theirs.load_trusted(None, other.key()).expect("theirs").1, 1);
}

#[test]
fn old_versions_are_removed_and_the_one_in_use_is_not() {
    let (_dir, store) = published(&contents(0.2));
    for friction in [0.3, 0.4, 0.5] {
        store.publish(&contents(friction)).expect("publishes");
    }
    assert!(store.retain(4).expect("retains").is_empty());
    store.rollback(Some("v0001")).expect("rolls back");
    for step in 1.. {
        let (result, struck) = durable::faults::after(step, || store.retain(2));
        store.verify(None).expect("in use");
        for listing in store.list().expect("lists") {
            store.verify(Some(&listing.version)).expect("whole or gone");
        }
        if !struck {
            result.expect("retains");
            break;
        }
    }
    let left: Vec<_> = store
        .list()
        .expect("lists")
        .into_iter()
        .map(|row| row.version)
        .collect();
    assert_eq!(left, ["v0001", "v0003", "v0004"]);
    assert_eq!(store.publish(&contents(0.6)).expect("publishes"), "v0005");
}

#[test]
fn signing_stopped_at_any_step_leaves_a_version_that_loads() {
    let signing = Signing::new();
    for step in 1.. {
        let (_dir, store) = published(&contents(0.2));
        let store = store.signed_by(signing.clone());
        store.publish(&contents(0.3)).expect("publishes");
        let (_, struck) = durable::faults::after(step, || store.rollback(Some("v0001")));
        let (artifact, sequence) = match store.load_trusted(None, signing.key()) {
            Ok(loaded) => loaded,
            Err(error) => panic!("step {step}: failed to {error}"),
        };
        let expected = if artifact.version == "v0001" { 2 } else { 1 };
        assert_eq!(sequence, expected, "step {step}");
        assert_eq!(store.rollback(Some("v0001")).expect("again"), "v0001");
        let (_, sequence) = store.load_trusted(None, signing.key()).expect("signed");
        assert_eq!(sequence, 2, "step {step}");
        assert_eq!(
            names(&store.version_dir("").join("")),
            [".lock", "v0001", "v0002"].map(String::from).into()
        );
        if !struck {
            assert!(step > 10, "only {step} steps");
            break;
        }
    }
}

#[test]
fn a_second_publisher_is_told_that_the_store_is_busy() {
    let (dir, store) = published(&contents(0.2));
    let held = durable::Lock::acquire(&dir.path().join("versions/.lock")).expect("free");
    assert!(matches!(
        store.publish(&contents(0.3)),
        Err(ArtifactError::Busy { .. })
    ));
    assert!(matches!(
        store.rollback(None),
        Err(ArtifactError::Busy { .. })
    ));
    assert_eq!(
        store.load(None).expect("reading needs no lock").version,
        "v0001"
    );
    drop(held);
    store.publish(&contents(0.3)).expect("free again");
}

#[test]
fn publishing_stopped_at_any_step_leaves_whole_versions_and_a_true_latest() {
    for step in 1.. {
        let (_dir, store) = published(&contents(0.2));
        let (result, struck) = durable::faults::after(step, || store.publish(&with_effect()));
        assert_eq!(result.is_err(), struck, "step {step}");
        let latest = store.load(None).expect("whole").version;
        assert!(latest == "v0001" || latest == "v0002", "step {step}");
        for listing in store.list().expect("lists") {
            store
                .verify(Some(&listing.version))
                .expect("whole or absent");
        }
        assert_eq!(
            store.publish(&with_effect()).expect("publishes"),
            "v0002",
            "step {step}"
        );
        assert_eq!(
            store.load(None).expect("whole").effect,
            with_effect().effect,
            "step {step}"
        );
        let expected = [".lock", "v0001", "v0002"].map(String::from).into();
        assert_eq!(
            names(&store.version_dir("").join("")),
            expected,
            "step {step}"
        );
        if !struck {
            assert!(step > 30, "only {step} steps");
            break;
        }
    }
}

#[test]
fn contents_that_could_not_be_loaded_are_not_published() {
    let (_dir, store) = published(&contents(0.2));
    let mut wrong = contents(0.3);
    wrong.provenance.default_model = Model::Effect;
    assert!(matches!(
        store.publish(&wrong),
        Err(ArtifactError::NoModel { .. })
    ));
    let mut wrong = contents(0.3);
    wrong.provenance.trained_region.distance.low = f64::NAN;
    assert!(store.publish(&wrong).is_err());
    let mut wrong = contents(0.3);
    wrong.sysid.world.parameters.insert(
        "friction".into(),
        Estimate::with_interval(0.3, f64::NAN, 0.4),
    );
    assert!(matches!(
        store.publish(&wrong),
        Err(ArtifactError::BadWorld { .. })
    ));
    let mut wrong = contents(0.3);
    wrong.rig.object.mass = -1.0;
    assert!(matches!(
        store.publish(&wrong),
        Err(ArtifactError::BadRig { .. })
    ));
    assert_eq!(store.list().expect("lists").len(), 1);
    assert_eq!(store.latest().expect("a version"), "v0001");
}

/// A store whose one version was damaged, and how it is refused.
fn refusal(damage: impl FnOnce(&Path)) -> ArtifactError {
    let (_dir, store) = published(&with_effect());
    damage(&store.version_dir("v0001"));
    let error = store.load(None).expect_err("damaged");
    assert_eq!(
        store
            .verify(Some("v0001"))
            .expect_err("damaged")
            .to_string(),
        error.to_string()
    );
    error
}

/// Changes the manifest's JSON and gives it its true hash: what its own hash does not find.
fn manifest(change: impl FnOnce(&mut serde_json::Value)) -> impl FnOnce(&Path) {
    |dir| {
        let path = dir.join("manifest.json");
        let mut value: serde_json::Value =
            serde_json::from_slice(&fs::read(&path).expect("reads")).expect("JSON");
        change(&mut value);
        let mut text = |hash: String| {
            value["sha256"] = hash.into();
            serde_json::to_string_pretty(&value).expect("JSON")
        };
        let hash = sha256(text("0".repeat(64)).as_bytes());
        fs::write(path, text(hash)).expect("writes");
    }
}

/// Gives a file another content and the manifest its true hash: what hashes alone do not find.
fn forged(name: &'static str, content: impl FnOnce(Vec<u8>) -> Vec<u8>) -> impl FnOnce(&Path) {
    move |dir| {
        let path = dir.join(name);
        let bytes = content(fs::read(&path).expect("reads"));
        fs::write(&path, &bytes).expect("writes");
        let sha256 = sha256(&bytes);
        manifest(|value| {
            value["files"][name] = serde_json::json!({"sha256": sha256, "size": bytes.len()});
        })(dir);
    }
}

fn replace(from: &'static str, to: &'static str) -> impl FnOnce(Vec<u8>) -> Vec<u8> {
    move |bytes| {
        let text = String::from_utf8(bytes).expect("text");
        assert!(text.contains(from), "{text}");
        text.replace(from, to).into_bytes()
    }
}

macro_rules! refused {
    ($damage:expr, $kind:pat, $said:expr) => {
        let error = refusal($damage);
        assert!(matches!(error, $kind), "{error:?}");
        assert!(error.to_string().contains($said), "{error}");
    };
}

#[test]
fn every_kind_of_damage_is_refused_by_name() {
    use ArtifactError as E;
    let write = |name: &'static str, content: &'static str| {
        move |dir: &Path| fs::write(dir.join(name), content).expect("writes")
    };
    let remove =
        |name: &'static str| move |dir: &Path| fs::remove_file(dir.join(name)).expect("removes");

    refused!(
        remove("manifest.json"),
        E::NoManifest { .. },
        "no manifest.json"
    );
    refused!(write("manifest.json", ""), E::BadManifest { .. }, "EOF");
    refused!(
        write("manifest.json", "{\"schema\": 2"),
        E::BadManifest { .. },
        "EOF"
    );
    refused!(
        write("manifest.json", "{\"schema\": 2}"),
        E::BadManifest { .. },
        "missing field"
    );
    refused!(
        |dir: &Path| {
            let path = dir.join("manifest.json");
            let text = fs::read_to_string(&path).expect("reads");
            assert!(text.contains("0.03"), "{text}");
            fs::write(path, text.replacen("0.03", "0.02", 1)).expect("writes");
        },
        E::WrongHash { .. },
        "manifest.json was changed"
    );
    refused!(
        manifest(|m| m["colour"] = 1.into()),
        E::BadManifest { .. },
        "unknown field `colour`"
    );
    refused!(
        manifest(|m| m["schema"] = 9.into()),
        E::UnknownSchema { found: 9, .. },
        "schema 9"
    );
    refused!(
        manifest(|m| m["carom"] = "9.0.0".into()),
        E::OtherCarom { .. },
        "carom 9.0.0"
    );
    refused!(
        manifest(|m| m["carom"] = "".into()),
        E::OtherCarom { .. },
        "wrote it"
    );
    refused!(
        manifest(|m| m["mujoco"] = "3.0.0".into()),
        E::OtherMujoco { .. },
        "MuJoCo 3.0.0"
    );
    refused!(
        manifest(|m| drop(
            m["files"]
                .as_object_mut()
                .expect("files")
                .remove("rig.toml")
        )),
        E::FileList { .. },
        "rig.toml"
    );
    refused!(
        manifest(|m| m["files"]["../rig.toml"] = m["files"]["rig.toml"].clone()),
        E::FileList { .. },
        "../rig.toml"
    );
    refused!(
        manifest(|m| drop(
            m["files"]
                .as_object_mut()
                .expect("files")
                .remove("world_sysid.toml")
        )),
        E::FileList { .. },
        "world_sysid.toml"
    );
    refused!(write("notes.txt", ""), E::ExtraFile { .. }, "notes.txt");
    refused!(
        write(".world.toml.partial", ""),
        E::ExtraFile { .. },
        ".world.toml.partial"
    );
    refused!(
        |dir: &Path| fs::create_dir(dir.join("more")).expect("makes"),
        E::ExtraFile { .. },
        "more"
    );
    refused!(
        manifest(|m| drop(
            m["files"]
                .as_object_mut()
                .expect("files")
                .remove("residual.safetensors")
        )),
        E::ExtraFile { .. },
        "residual.safetensors"
    );
    refused!(
        remove("residual.safetensors"),
        E::MissingFile { .. },
        "residual.safetensors is missing"
    );
    refused!(
        remove("world_sysid.toml"),
        E::MissingFile { .. },
        "world_sysid.toml is missing"
    );
    refused!(
        |dir: &Path| claim_length(dir, "world.toml", 1 << 40),
        E::TooLong { .. },
        "world.toml has 1099511627776 bytes"
    );
    refused!(
        write("world.toml", ""),
        E::WrongSize { found: 0, .. },
        "world.toml has 0 bytes"
    );
    refused!(
        |dir: &Path| {
            let path = dir.join("residual.safetensors");
            let mut bytes = fs::read(&path).expect("reads");
            let middle = bytes.len() / 2;
            bytes[middle] ^= 1;
            fs::write(path, bytes).expect("writes");
        },
        E::WrongHash { .. },
        "residual.safetensors was changed"
    );
    refused!(
        |dir: &Path| {
            fs::copy(
                dir.join("residual_sysid.safetensors"),
                dir.join("residual.safetensors"),
            )
            .expect("copies");
        },
        E::WrongHash { .. },
        "residual.safetensors was changed"
    );
    refused!(
        forged("rig.toml", replace("mass = 0.1", "mas = 0.1")),
        E::BadRig { .. },
        "object.mas"
    );
    refused!(
        forged("rig.toml", replace("mass = 0.1", "mass = 0.2")),
        E::OtherRig { .. },
        "another rig's"
    );
    refused!(
        manifest(|m| m["rig"] = "00".into()),
        E::OtherRig { .. },
        "instead of 00"
    );
    refused!(
        forged("world.toml", |_| vec![0xff]),
        E::BadWorld { .. },
        "world.toml"
    );
    refused!(
        forged("world.toml", replace("friction", "fiction")),
        E::BadWorld { .. },
        "fiction"
    );
    refused!(
        forged("world_sysid.toml", replace("0.25", "nan")),
        E::BadWorld { .. },
        "NaN"
    );
    refused!(
        forged("world_sysid.toml", replace("0.5", "inf")),
        E::BadWorld { .. },
        "not finite"
    );
    refused!(
        forged("world.toml", replace("viscous_drag", "sticky_drag")),
        E::BadWorld { .. },
        "sticky_drag"
    );
    refused!(
        forged("residual.safetensors", |bytes| bytes[..99].to_vec()),
        E::BadNetwork {
            source: NetworkError::Format(_),
            ..
        },
        "residual.safetensors"
    );
    refused!(
        forged("residual.safetensors", |mut bytes| {
            let end = bytes.len();
            bytes[end - 4..].copy_from_slice(&f32::INFINITY.to_le_bytes());
            bytes
        }),
        E::BadNetwork {
            source: NetworkError::NotFinite { .. },
            ..
        },
        "not finite"
    );
    refused!(
        forged("residual_sysid.safetensors", |bytes| {
            // Same length, another name in the header.
            let mut bytes = bytes;
            let at = bytes
                .windows(6)
                .position(|window| window == b"layer0")
                .expect("its name");
            bytes[at] = b'L';
            bytes
        }),
        E::BadNetwork {
            source: NetworkError::Names { .. },
            ..
        },
        "residual_sysid.safetensors"
    );
    refused!(
        manifest(|m| m["default_model"] = "best".into()),
        E::BadManifest { .. },
        "best"
    );
    refused!(
        manifest(|m| m["trained_region"]["stop_x"] = serde_json::json!([0.9, 0.5])),
        E::BadNumber { .. },
        "trained_region.stop_x"
    );
    refused!(
        manifest(|m| m["metrics"]["nominal"]["mean"] = serde_json::json!(-0.1)),
        E::BadNumber { .. },
        "metrics.nominal"
    );
    refused!(
        manifest(|m| m["trained_region"]["stop_x"] = serde_json::json!([null, 0.5])),
        E::BadManifest { .. },
        "null"
    );
}

#[test]
fn a_default_model_that_is_not_there_is_refused() {
    let (_dir, store) = published(&contents(0.2));
    manifest(|m| m["default_model"] = "effect".into())(&store.version_dir("v0001"));
    let error = store.load(None).expect_err("damaged");
    assert!(
        matches!(
            error,
            ArtifactError::NoModel {
                model: Model::Effect,
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn a_link_in_place_of_a_file_is_refused() {
    let error = refusal(|dir| {
        let (path, elsewhere) = (dir.join("rig.toml"), dir.with_file_name("elsewhere"));
        fs::rename(&path, &elsewhere).expect("renames");
        std::os::unix::fs::symlink(elsewhere, path).expect("links");
    });
    assert!(matches!(error, ArtifactError::ExtraFile { .. }), "{error}");
}

#[test]
fn a_latest_that_leads_nowhere_is_told() {
    let (dir, store) = published(&contents(0.2));
    let latest = |content: &str| {
        fs::write(dir.path().join("latest"), content).expect("writes");
        store.load(None).expect_err("leads nowhere")
    };
    assert!(matches!(latest("v0009\n"), ArtifactError::NoVersion { .. }));
    for content in [
        "",
        "v1",
        "../v0001",
        "v0001\nv0002",
        "\u{0}",
        &"v".repeat(1000),
    ] {
        assert!(
            matches!(latest(content), ArtifactError::BadLatest { .. }),
            "{content}"
        );
    }
    fs::write(dir.path().join("latest"), [0xff, 0xfe]).expect("writes");
    assert!(matches!(
        store.load(None),
        Err(ArtifactError::BadLatest { .. })
    ));
    fs::remove_file(dir.path().join("latest")).expect("removes");
    assert!(matches!(
        store.load(None),
        Err(ArtifactError::NoLatest { .. })
    ));
    assert!(matches!(
        store.load(Some("../v0001")),
        Err(ArtifactError::NoVersion { .. })
    ));
    assert_eq!(store.load(Some("v0001")).expect("named").version, "v0001");
    assert_eq!(
        store.rollback(Some("v0001")).expect("mends latest"),
        "v0001"
    );
}

#[test]
fn an_empty_store_says_what_to_do() {
    let store = Store::open(&PathBuf::from("/nowhere/at/all"));
    let error = store.load(None).expect_err("empty").to_string();
    assert!(error.contains("carom run"), "{error}");
    assert!(store.list().expect("none").is_empty());
}

#[test]
fn a_copy_of_versions_and_latest_is_a_store() {
    let (dir, store) = published(&with_effect());
    let copy = tempfile::tempdir().expect("folder");
    fs::create_dir_all(copy.path().join("versions/v0001")).expect("makes");
    for (name, content) in bytes(&store.version_dir("v0001")) {
        fs::write(copy.path().join("versions/v0001").join(name), content).expect("writes");
    }
    fs::copy(dir.path().join("latest"), copy.path().join("latest")).expect("copies");
    assert_eq!(
        Store::open(copy.path()).load(None).expect("whole"),
        store.load(None).expect("whole")
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
        let name = names(&dir).into_iter().nth(file).expect("six files");
        let mut content = fs::read(dir.join(&name)).expect("reads");
        let at = at.index(content.len());
        if cut { content.truncate(at) } else { content[at] ^= flip }
        fs::write(dir.join(&name), content).expect("writes");
        let error = store.load(None).expect_err("damaged").to_string();
        prop_assert!(error.starts_with("load v0001"), "{}", error);
    }

    #[test]
    fn manifests_read_back(mean in 0.0..1e3, low in -1e3..1e3f64, seed: u64, name: String) {
        let mut contents = contents(0.2);
        contents.provenance.metrics.get_mut(&Model::Nominal).expect("there").mean = mean;
        contents.provenance.trained_region.bearing = [low, low + 1.0].into();
        contents.provenance.seeds.insert(name.clone(), seed);
        contents.provenance.inputs[0].name = name;
        let (_dir, store) = published(&contents);
        let manifest = store.show(None).expect("shows");
        prop_assert_eq!(manifest.provenance.metrics, contents.provenance.metrics);
        prop_assert_eq!(manifest.provenance.trained_region, contents.provenance.trained_region);
        prop_assert_eq!(manifest.provenance.seeds, contents.provenance.seeds);
        prop_assert_eq!(manifest.provenance.inputs, contents.provenance.inputs);
    }
}

/// A sparse file of so many bytes, and a manifest that claims them.
fn claim_length(dir: &Path, name: &'static str, length: u64) {
    let file = fs::File::options().write(true).open(dir.join(name));
    file.and_then(|file| file.set_len(length)).expect("grows");
    manifest(|value| value["files"][name]["size"] = length.into())(dir);
}

#[test]
fn a_promotion_against_another_version_than_is_in_use_changes_nothing() {
    let (dir, store) = published(&contents(0.2));
    store.publish(&contents(0.3)).expect("publishes");
    // Decided against v0002; a person rolls back meanwhile.
    store.rollback(Some("v0001")).expect("rolls back");
    let error = store
        .promote(&contents(0.4), Some("v0002"))
        .expect_err("overtaken");
    assert!(matches!(error, ArtifactError::Overtaken { .. }), "{error}");
    assert!(error.to_string().contains("v0001 is in use now"), "{error}");
    assert_eq!(store.latest().expect("latest"), "v0001");
    assert!(!store.version_dir("v0003").exists());
    assert!(store.promote(&contents(0.4), None).is_err());

    let promoted = store.promote(&contents(0.4), Some("v0001"));
    assert_eq!(promoted.expect("promotes"), "v0003");
    assert_eq!(store.latest().expect("latest"), "v0003");
    drop(dir);
}
