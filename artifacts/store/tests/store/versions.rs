//! What is loaded, listed and shown.

use std::fs;
use std::path::PathBuf;

use store::*;
use world::World;

use crate::fixture::{bytes, contents, fault, names, published, with_effect};

#[test]
fn what_is_loaded_is_what_was_published() {
    for (contents, models) in [(contents(0.2), 3), (with_effect(), 5)] {
        let (_dir, store) = published(&contents);
        let artifact = store.load(None).unwrap();
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
    let artifact = store.load(None).unwrap();
    let effect = contents.effect.as_ref().unwrap();
    let part = |model| artifact.model(model).unwrap();
    assert_eq!(part(Model::Nominal), (World::nominal(), None));
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
    contents.provenance.explained.clear();
    contents.provenance.default_model = Model::Sysid;
    let (_dir, store) = published(&contents);
    let artifact = store.load(None).unwrap();
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
    assert_eq!(store.publish(&with_effect()).unwrap(), "v0001");
    assert_eq!(store.publish(&contents(0.3)).unwrap(), "v0002");
    assert_eq!(store.publish(&with_effect()).unwrap(), "v0001");
    assert_eq!(store.latest().unwrap(), "v0001");
    // A damaged version is not taken for the same.
    fs::write(store.version_dir("v0002").join("rig.toml"), "").unwrap();
    assert_eq!(store.publish(&contents(0.3)).unwrap(), "v0003");
}

#[test]
fn the_store_lists_shows_and_rolls_back() {
    let (_dir, store) = published(&contents(0.2));
    store.publish(&contents(0.3)).unwrap();
    store.publish(&contents(0.4)).unwrap();
    let list = store.list().unwrap();
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
        store.show(Some("v0002")).unwrap().provenance.seeds["split"],
        7
    );
    assert_eq!(store.rollback(None).unwrap(), "v0002");
    assert_eq!(store.load(None).unwrap().version, "v0002");
    assert_eq!(store.rollback(Some("v0003")).unwrap(), "v0003");
    // Over a damaged version to a whole one; never to a damaged one.
    fs::remove_file(store.version_dir("v0002").join("rig.toml")).unwrap();
    assert!(matches!(
        fault(store.rollback(Some("v0002"))),
        Fault::MissingFile(_)
    ));
    assert_eq!(store.latest().unwrap(), "v0003");
    assert_eq!(store.rollback(None).unwrap(), "v0001");
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
fn an_empty_store_says_what_to_do() {
    let store = Store::open(&PathBuf::from("/nowhere/at/all"));
    let error = store.load(None).expect_err("empty").to_string();
    assert!(error.contains("carom run"), "{error}");
    assert!(store.list().unwrap().is_empty());
}

#[test]
fn a_copy_of_versions_and_latest_is_a_store() {
    let (dir, store) = published(&with_effect());
    let copy = tempfile::tempdir().unwrap();
    fs::create_dir_all(copy.path().join("versions/v0001")).unwrap();
    for (name, content) in bytes(&store.version_dir("v0001")) {
        fs::write(copy.path().join("versions/v0001").join(name), content).unwrap();
    }
    fs::copy(dir.path().join("latest"), copy.path().join("latest")).unwrap();
    assert_eq!(
        Store::open(copy.path()).load(None).unwrap(),
        store.load(None).unwrap()
    );
}

#[test]
fn a_latest_that_leads_nowhere_is_reported() {
    let (dir, store) = published(&contents(0.2));
    let latest = |content: &str| {
        fs::write(dir.path().join("latest"), content).unwrap();
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
    fs::write(dir.path().join("latest"), [0xff, 0xfe]).unwrap();
    assert!(matches!(
        store.load(None),
        Err(ArtifactError::BadLatest { .. })
    ));
    fs::remove_file(dir.path().join("latest")).unwrap();
    assert!(matches!(
        store.load(None),
        Err(ArtifactError::NoLatest { .. })
    ));
    assert!(matches!(
        store.load(Some("../v0001")),
        Err(ArtifactError::NoVersion { .. })
    ));
    assert_eq!(store.load(Some("v0001")).unwrap().version, "v0001");
    assert_eq!(store.rollback(Some("v0001")).unwrap(), "v0001");
}
