//! A model that is judged.

use serde::{Deserialize, Serialize};
use store::ResidualModel;
use values::Rig;
use world::World;

/// A model to be judged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Its name, such as `sysid_residual`.
    pub name: String,
    /// Its world.
    pub world: World,
    /// What it adds to the world's solution.
    pub residual: Option<ResidualModel>,
}

/// A model without its name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Model {
    pub(crate) rig: Rig,
    pub(crate) world: World,
    pub(crate) residual: Option<ResidualModel>,
}

impl Model {
    /// A candidate on this rig.
    pub fn of(rig: &Rig, candidate: &Candidate) -> Self {
        Self {
            rig: rig.clone(),
            world: candidate.world.clone(),
            residual: candidate.residual.clone(),
        }
    }

    /// The same without its residual.
    pub fn world_alone(self) -> Self {
        Self {
            residual: None,
            ..self
        }
    }
}
