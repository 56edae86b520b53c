//! What changes a store: publishing, promoting, rolling back, signing, removing, and being stopped meanwhile.

use store::*;
use world::Estimate;

use crate::fixture::{bytes, contents, fault, names, published, with_effect};
use crate::signing::Signing;

#[test]
fn what_was_rolled_back_is_not_published_again_in_silence() {
    let (_dir, store) = published(&contents(0.2));
    store.publish(&contents(0.3)).unwrap();
    store.publish(&contents(0.4)).unwrap();
    let latest = || store.latest().unwrap();
    store.rollback(Some("v0001")).unwrap();
    for (friction, version) in [(0.4, "v0003"), (0.3, "v0002")] {
        assert_eq!(store.publish(&contents(friction)).unwrap(), version);
        assert_eq!(latest(), "v0001", "{version} is withdrawn");
    }
    // What is new is used; what was withdrawn stays so until it is named.
    assert_eq!(store.publish(&contents(0.5)).unwrap(), "v0004");
    assert_eq!(latest(), "v0004");
    store.publish(&contents(0.3)).unwrap();
    assert_eq!(latest(), "v0004");
    store.rollback(Some("v0002")).unwrap();
    assert_eq!(store.publish(&contents(0.3)).unwrap(), "v0002");
    assert_eq!(latest(), "v0002");
    // A version that no rollback passed is used again where its inputs are.
    assert_eq!(store.publish(&contents(0.2)).unwrap(), "v0001");
    assert_eq!(latest(), "v0001");
}

#[test]
fn signatures_count_what_is_put_to_use() {
    let (dir, plain) = published(&contents(0.2));
    let signing = Signing::new();
    let store = plain.clone().signed_by(signing.clone());
    let sequence = |version: &str| match store.load_trusted(Some(version), signing.key()) {
        Ok((_, sequence)) => Some(sequence),
        Err(ArtifactError::Unsound {
            fault: Fault::NotSigned,
            ..
        }) => None,
        Err(error) => panic!("failed to {error}"),
    };
    // Neither the manifest's bytes nor the name change by signing.
    let before = bytes(&store.version_dir("v0001"));
    assert_eq!(sequence("v0001"), None);
    assert_eq!(store.publish(&contents(0.2)).unwrap(), "v0001");
    assert_eq!(sequence("v0001"), Some(1));
    let mut after = bytes(&store.version_dir("v0001"));
    after.remove(SIGNATURE);
    assert_eq!(before, after);
    assert_eq!(store.sign().unwrap(), "v0001");
    assert_eq!(store.publish(&contents(0.3)).unwrap(), "v0002");
    assert_eq!((sequence("v0001"), sequence("v0002")), (Some(1), Some(2)));
    assert_eq!(store.rollback(None).unwrap(), "v0001");
    assert_eq!((sequence("v0001"), sequence("v0002")), (Some(3), Some(2)));
    // Withdrawn: not signed again.
    store.publish(&contents(0.3)).unwrap();
    assert_eq!(sequence("v0002"), Some(2));
    assert_eq!(store.publish(&contents(0.4)).unwrap(), "v0003");
    assert_eq!(sequence("v0003"), Some(4));

    // Without the key nothing that is signed is replaced, nor with another; a store that is handed over counts anew.
    for changed in [plain.publish(&contents(0.5)), plain.rollback(None)] {
        assert!(matches!(changed, Err(ArtifactError::NeedsKey { .. })));
    }
    assert_eq!(plain.latest().unwrap(), "v0003");
    let other = Signing::new();
    let theirs = Store::open(dir.path()).signed_by(other.clone());
    for changed in [theirs.publish(&contents(0.5)), theirs.rollback(None)] {
        assert!(matches!(changed, Err(ArtifactError::OtherKey { .. })));
    }
    assert_eq!(theirs.sign().unwrap(), "v0003");
    assert!(matches!(
        fault(store.load_trusted(None, signing.key())),
        Fault::BadSignature(_)
    ));
    assert_eq!(theirs.load_trusted(None, other.key()).unwrap().1, 1);
}

#[test]
fn old_versions_are_removed_and_the_one_in_use_is_not() {
    let (_dir, store) = published(&contents(0.2));
    for friction in [0.3, 0.4, 0.5] {
        store.publish(&contents(friction)).unwrap();
    }
    assert!(store.retain(4).unwrap().is_empty());
    store.rollback(Some("v0001")).unwrap();
    for step in 1.. {
        let (result, struck) = durable::faults::after(step, || store.retain(2));
        store.verify(None).unwrap();
        for listing in store.list().unwrap() {
            store.verify(Some(&listing.version)).unwrap();
        }
        if !struck {
            result.unwrap();
            break;
        }
    }
    let left: Vec<_> = store
        .list()
        .unwrap()
        .into_iter()
        .map(|row| row.version)
        .collect();
    assert_eq!(left, ["v0001", "v0003", "v0004"]);
    assert_eq!(store.publish(&contents(0.6)).unwrap(), "v0005");
}

#[test]
fn signing_stopped_at_any_step_leaves_a_version_that_loads() {
    let signing = Signing::new();
    for step in 1.. {
        let (_dir, store) = published(&contents(0.2));
        let store = store.signed_by(signing.clone());
        store.publish(&contents(0.3)).unwrap();
        let (_, struck) = durable::faults::after(step, || store.rollback(Some("v0001")));
        let (artifact, sequence) = match store.load_trusted(None, signing.key()) {
            Ok(loaded) => loaded,
            Err(error) => panic!("step {step}: failed to {error}"),
        };
        let expected = if artifact.version == "v0001" { 2 } else { 1 };
        assert_eq!(sequence, expected, "step {step}");
        assert_eq!(store.rollback(Some("v0001")).unwrap(), "v0001");
        let (_, sequence) = store.load_trusted(None, signing.key()).unwrap();
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
fn a_second_publisher_learns_that_the_store_is_busy() {
    let (dir, store) = published(&contents(0.2));
    let held = durable::Lock::acquire(&dir.path().join("versions/.lock")).unwrap();
    assert!(matches!(
        store.publish(&contents(0.3)),
        Err(ArtifactError::Busy { .. })
    ));
    assert!(matches!(
        store.rollback(None),
        Err(ArtifactError::Busy { .. })
    ));
    assert_eq!(store.load(None).unwrap().version, "v0001");
    drop(held);
    store.publish(&contents(0.3)).unwrap();
}

#[test]
fn publishing_stopped_at_any_step_leaves_whole_versions_and_a_true_latest() {
    for step in 1.. {
        let (_dir, store) = published(&contents(0.2));
        let (result, struck) = durable::faults::after(step, || store.publish(&with_effect()));
        assert_eq!(result.is_err(), struck, "step {step}");
        let latest = store.load(None).unwrap().version;
        assert!(latest == "v0001" || latest == "v0002", "step {step}");
        for listing in store.list().unwrap() {
            store.verify(Some(&listing.version)).unwrap();
        }
        assert_eq!(
            store.publish(&with_effect()).unwrap(),
            "v0002",
            "step {step}"
        );
        assert_eq!(
            store.load(None).unwrap().effect,
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
    assert!(matches!(fault(store.publish(&wrong)), Fault::NoModel(..)));
    let mut wrong = contents(0.3);
    wrong.provenance.trained_region.distance.low = f64::NAN;
    assert!(store.publish(&wrong).is_err());
    let mut wrong = contents(0.3);
    wrong.sysid.world.parameters.insert(
        "friction".into(),
        Estimate::with_interval(0.3, f64::NAN, 0.4),
    );
    assert!(matches!(fault(store.publish(&wrong)), Fault::BadWorld(..)));
    let mut wrong = contents(0.3);
    wrong.rig.object.mass = -1.0;
    assert!(matches!(fault(store.publish(&wrong)), Fault::BadRig(_)));
    assert_eq!(store.list().unwrap().len(), 1);
    assert_eq!(store.latest().unwrap(), "v0001");
}

#[test]
fn a_promotion_against_another_version_than_is_in_use_changes_nothing() {
    let (dir, store) = published(&contents(0.2));
    store.publish(&contents(0.3)).unwrap();
    // Decided against v0002; a person rolls back meanwhile.
    store.rollback(Some("v0001")).unwrap();
    let error = store
        .promote(&contents(0.4), Some("v0002"))
        .expect_err("overtaken");
    assert!(matches!(error, ArtifactError::Overtaken { .. }), "{error}");
    assert!(error.to_string().contains("v0001 is in use now"), "{error}");
    assert_eq!(store.latest().unwrap(), "v0001");
    assert!(!store.version_dir("v0003").exists());
    assert!(store.promote(&contents(0.4), None).is_err());

    let promoted = store.promote(&contents(0.4), Some("v0001"));
    assert_eq!(promoted.unwrap(), "v0003");
    assert_eq!(store.latest().unwrap(), "v0003");
    drop(dir);
}
