//! What is published: which files a version has, and what is in them.

use std::collections::BTreeMap;

use durable::sha256;
use serde::{Deserialize, Serialize};
use values::Rig;
use world::World;

use crate::{FileHash, Manifest, Model, Provenance, ResidualModel, SCHEMA_VERSION};

/// A world, and what is to be added to its commands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Calibrated {
    /// The world.
    pub world: World,
    /// The residual model on top of it; none where there were too few strikes to learn one.
    pub residual: Option<ResidualModel>,
}

/// All that goes into a version.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contents {
    /// The set-up.
    pub rig: Rig,
    /// The identified world.
    pub sysid: Calibrated,
    /// The identified world with the effects that the data named; none where they named none.
    pub effect: Option<Calibrated>,
    /// How it came to be and how good it is.
    pub provenance: Provenance,
}

impl Contents {
    /// The models that a version with these contents can be struck with, the plainest first.
    pub fn models(&self) -> Vec<Model> {
        models(&self.sysid, self.effect.as_ref())
    }
}

/// The models of a world, and of a world with effects.
pub(crate) fn models(sysid: &Calibrated, effect: Option<&Calibrated>) -> Vec<Model> {
    let has = |model: &Model| match model {
        Model::Nominal | Model::Sysid => true,
        Model::SysidResidual => sysid.residual.is_some(),
        Model::Effect => effect.is_some(),
        Model::EffectResidual => effect.is_some_and(|effect| effect.residual.is_some()),
    };
    Model::ALL.into_iter().filter(has).collect()
}

pub(crate) const MANIFEST: &str = "manifest.json";
pub(crate) const RIG: &str = "rig.toml";
/// The world to use: the effect's where there is one, else sysid's.
pub(crate) const MAIN: [&str; 2] = ["world.toml", "residual.safetensors"];
/// The plain sysid world beside an effect's.
pub(crate) const PLAIN: [&str; 2] = ["world_sysid.toml", "residual_sysid.safetensors"];

/// A version's manifest, and every other file's content by its name.
pub(crate) fn encode(contents: &Contents) -> (Manifest, BTreeMap<&'static str, Vec<u8>>) {
    let mut files = BTreeMap::new();
    files.insert(RIG, contents.rig.to_toml().into_bytes());
    match &contents.effect {
        None => insert(&mut files, MAIN, &contents.sysid),
        Some(effect) => {
            insert(&mut files, MAIN, effect);
            insert(&mut files, PLAIN, &contents.sysid);
        }
    }
    let mut provenance = contents.provenance.clone();
    for stage in &mut provenance.stages {
        // Else their order would hang on which features serde_json was built with.
        stage.settings.sort_all_objects();
    }
    let manifest = Manifest {
        sha256: String::new(),
        schema: SCHEMA_VERSION,
        carom: env!("CARGO_PKG_VERSION").into(),
        mujoco: world::mujoco_version(),
        rig: identity(&contents.rig),
        files: files
            .iter()
            .map(|(name, bytes)| {
                let hash = FileHash {
                    sha256: sha256(bytes),
                    size: bytes.len() as u64,
                };
                ((*name).to_string(), hash)
            })
            .collect(),
        provenance,
    };
    (manifest.sealed(), files)
}

fn insert(
    files: &mut BTreeMap<&'static str, Vec<u8>>,
    [world, residual]: [&'static str; 2],
    calibrated: &Calibrated,
) {
    files.insert(world, calibrated.world.to_toml().into_bytes());
    if let Some(network) = &calibrated.residual {
        files.insert(residual, network.to_safetensors());
    }
}

/// What a rig is known by: SHA-256 of its settings, comments and order aside.
pub(crate) fn identity(rig: &Rig) -> String {
    sha256(rig.to_toml().as_bytes())
}
