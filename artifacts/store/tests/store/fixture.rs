//! Versions to publish, and what lies in a folder.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use store::network::{LAYERS, Layer, SIZES};
use store::*;
use values::{Point, Rig, Shape, StopErrors};
use world::{AddedEffect, Estimate, World};

pub fn network(scale: f32) -> Network {
    let numbers = |count: usize| {
        (0..count)
            .map(|i| (i % 13) as f32 * scale)
            .collect::<Vec<_>>()
    };
    let layer = |i: usize| Layer {
        weight: numbers(SIZES[i] * SIZES[i + 1]),
        bias: numbers(SIZES[i + 1]),
    };
    Network::new((0..LAYERS).map(layer).collect()).unwrap()
}

fn explained() -> TrainingExtent {
    let about_zero = |most: f64| [-most, most].into();
    TrainingExtent {
        strikes: 40,
        d_speed: about_zero(0.1),
        d_angle: about_zero(0.05),
        displacement: 0.3,
        miss: 0.05,
        miss_p95: 0.1,
        calibration: 1.1,
    }
}

pub fn contents(friction: f64) -> Contents {
    let rig = Rig::demo(Shape::Cylinder);
    let mut world = World::nominal();
    world.parameters.insert(
        "friction".into(),
        Estimate::with_interval(friction, 0.1, 0.5),
    );
    let metrics = |mean| StopErrors {
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
            residual: Some(network(0.01).into()),
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
            explained: [(Model::SysidResidual, explained())].into(),
            varies: [].into(),
            trained_region: region.unwrap(),
            strikes: Some(Logged {
                count: 2,
                last: 1.7e9,
            }),
            moved: None,
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

pub fn with_effect() -> Contents {
    let mut contents = contents(0.25);
    let mut world = contents.sysid.world.clone();
    world
        .effects
        .push(AddedEffect::fixed("viscous_drag", &[("rate", 0.2)]));
    contents.effect = Some(Calibrated {
        world,
        residual: Some(network(0.02).into()),
    });
    contents.provenance.default_model = Model::EffectResidual;
    contents
}

pub fn published(contents: &Contents) -> (tempfile::TempDir, Store) {
    let dir = tempfile::tempdir().unwrap();
    let store = Store::open(dir.path());
    store.publish(contents).unwrap();
    (dir, store)
}

pub fn names(dir: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(dir).unwrap();
    entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect()
}

pub fn bytes(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    names(dir)
        .into_iter()
        .map(|name| (name.clone(), fs::read(dir.join(name)).unwrap()))
        .collect()
}

/// What is wrong with a version that is refused.
pub fn fault<T: std::fmt::Debug>(refused: Result<T, ArtifactError>) -> Fault {
    match refused {
        Err(ArtifactError::Unsound { fault, .. }) => fault,
        other => panic!("{other:?}"),
    }
}
