//! A small artifact, published and loaded as the pipeline does it.

use std::path::Path;
use std::sync::Arc;

use store::network::{LAYERS, Layer, SIZES};
use store::{
    Artifact, Calibrated, Contents, Logged, Model, Network, Provenance, Store, TrainedRegion,
};
use strike::{Plan, Planner, Refusal};
use tempfile::TempDir;
use values::{Point, Rig, Shape, StopErrors};
use world::{AddedEffect, World};

#[path = "../../../../artifacts/store/tests/store/signing.rs"]
mod signing;

pub use signing::Signing;

pub const FROM: Point = Point::new(0.3, 0.05);
/// A target that breaks no limit.
pub const TO: Point = Point::new(0.6, 0.1);
/// What sysid's residual adds, whatever the path.
pub const SYSID_RESIDUAL: [f64; 2] = [0.0625, -0.03125];
/// What the effect's residual adds.
pub const EFFECT_RESIDUAL: [f64; 2] = [-0.015625, 0.0078125];
/// Mean stop error of sysid in the manifest, in m.
pub const SYSID_MEAN: f64 = 0.02;
/// The artifact's best model.
pub const DEFAULT: Model = Model::EffectResidual;

pub fn rig() -> Rig {
    Rig::demo(Shape::Cylinder)
}

pub fn constant(answer: [f64; 2]) -> Network {
    let mut layers: Vec<_> = (0..LAYERS)
        .map(|layer| Layer {
            weight: vec![0.0; SIZES[layer] * SIZES[layer + 1]],
            bias: vec![0.0; SIZES[layer + 1]],
        })
        .collect();
    layers[LAYERS - 1].bias = answer.map(|value| value as f32).to_vec();
    Network::new(layers).unwrap()
}

fn sysid() -> World {
    World::nominal()
        .with("friction", 0.25)
        .with("restitution", 0.5)
}

fn effect() -> World {
    let mut world = sysid();
    let drag = AddedEffect::fixed("viscous_drag", &[("rate", 0.3)]);
    world.effects.push(drag);
    world
}

fn contents(seed: u64) -> Contents {
    let metrics = |mean| StopErrors {
        mean,
        sd: 0.01,
        median: mean,
        p95: 2.0 * mean,
        n: 50,
        failed: 0,
    };
    Contents {
        rig: rig(),
        sysid: Calibrated {
            world: sysid(),
            residual: Some(constant(SYSID_RESIDUAL).into()),
        },
        effect: Some(Calibrated {
            world: effect(),
            residual: Some(constant(EFFECT_RESIDUAL).into()),
        }),
        provenance: Provenance {
            default_model: DEFAULT,
            metrics: [
                (Model::Sysid, metrics(SYSID_MEAN)),
                (DEFAULT, metrics(0.002)),
            ]
            .into(),
            noise_floor: None,
            explained: [].into(),
            varies: [].into(),
            trained_region: TrainedRegion {
                distance: [0.05, 0.65].into(),
                bearing: [-1.0, 1.0].into(),
                stop_x: [0.2, 0.95].into(),
                stop_y: [-0.55, 0.55].into(),
                start_x: Some([0.1, 0.45].into()),
                start_y: Some([-0.58, 0.58].into()),
            },
            strikes: Some(Logged {
                count: 500,
                last: 1.7e9,
            }),
            moved: None,
            without_effects: false,
            seeds: [("split".to_string(), seed)].into(),
            inputs: Vec::new(),
            stages: Vec::new(),
        },
    }
}

/// Publishes into a folder; another seed makes another version.
pub fn publish(dir: &Path, seed: u64) {
    Store::open(dir).publish(&contents(seed)).unwrap();
}

/// Publishes a signed version into a folder; gives its name.
pub fn publish_signed(dir: &Path, seed: u64, signing: &Arc<Signing>) -> String {
    let store = Store::open(dir).signed_by(signing.clone());
    store.publish(&contents(seed)).unwrap()
}

pub fn published() -> TempDir {
    let dir = tempfile::tempdir().unwrap();
    publish(dir.path(), 1);
    dir
}

pub fn artifact() -> Artifact {
    Store::open(published().path()).load(None).unwrap()
}

/// The plan of a model from [`FROM`] to [`TO`].
pub fn plan(model: Model) -> Plan {
    let planner = Planner::new(&artifact(), model).unwrap();
    planner.plan(FROM, TO).unwrap()
}

/// Why a model makes no plan.
pub fn refusal(artifact: &Artifact, model: Model, from: Point, to: Point) -> Refusal {
    let planner = Planner::new(artifact, model).unwrap();
    planner.plan(from, to).expect_err("refused")
}
