//! What is published.

use serde::{Deserialize, Serialize};
use values::Rig;
use world::World;

use crate::{Model, Provenance, ResidualModel};

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
