//! A version that was checked.

use values::Rig;
use world::World;

use crate::files::models;
use crate::{Calibrated, Contents, Manifest, Model, ResidualModel};

/// A version, every part of which was checked when it was loaded.
#[derive(Clone, Debug, PartialEq)]
pub struct Artifact {
    /// Name of the version, such as `v0003`.
    pub version: String,
    /// What it holds and how it came to be.
    pub manifest: Manifest,
    /// The set-up that it is for.
    pub rig: Rig,
    /// The identified world.
    pub sysid: Calibrated,
    /// The identified world with the effects that the data named.
    pub effect: Option<Calibrated>,
}

impl From<Artifact> for Contents {
    fn from(artifact: Artifact) -> Self {
        Self {
            rig: artifact.rig,
            sysid: artifact.sysid,
            effect: artifact.effect,
            provenance: artifact.manifest.provenance,
        }
    }
}

impl Artifact {
    /// Number of strikes that the version knows: the order of the next one.
    pub fn next_order(&self) -> f64 {
        let strikes = self.manifest.provenance.strikes;
        strikes.map_or(0.0, |strikes| strikes.count as f64)
    }

    /// The models that it can be struck with, the plainest first.
    pub fn models(&self) -> Vec<Model> {
        models(&self.sysid, self.effect.as_ref())
    }

    /// The world of a model and the residual on top of it; none where it does not hold the model.
    pub fn model(&self, model: Model) -> Option<(World, Option<&ResidualModel>)> {
        let with_residual = |calibrated: &'_ Calibrated| calibrated.residual.is_some();
        match model {
            Model::Nominal => Some((World::nominal(), None)),
            Model::Sysid => Some((self.sysid.world.clone(), None)),
            Model::Effect => self
                .effect
                .as_ref()
                .map(|effect| (effect.world.clone(), None)),
            Model::SysidResidual => Some(&self.sysid)
                .filter(|sysid| with_residual(sysid))
                .map(|sysid| (sysid.world.clone(), sysid.residual.as_ref())),
            Model::EffectResidual => self
                .effect
                .as_ref()
                .filter(|effect| with_residual(effect))
                .map(|effect| (effect.world.clone(), effect.residual.as_ref())),
        }
    }
}
