//! What is asked and judged.

use std::collections::BTreeSet;

use serde::Serialize;
use store::ResidualModel;
use values::Rig;
use world::{Simulator, World, WorldError};

/// A world on a rig, and what is added to its commands.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Model {
    /// The set-up.
    pub rig: Rig,
    /// The world.
    pub world: World,
    /// What is added to the world's solution; none for a world alone.
    pub residual: Option<ResidualModel>,
}

/// A model with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Name of the model, such as `sysid_residual`.
    pub name: String,
    /// The model.
    pub model: Model,
}

impl Model {
    /// A world alone.
    pub fn of_world(rig: &Rig, world: &World) -> Self {
        Self {
            rig: rig.clone(),
            world: world.clone(),
            residual: None,
        }
    }

    /// This model as if it had never seen a session: effects by session take their mean over the other sessions there.
    pub(crate) fn without_session(&self, session: &str) -> Self {
        Self {
            world: self.world.clone().without_session(session),
            ..self.clone()
        }
    }

    /// Whether what it learnt is of these sessions together, and of none by itself.
    pub(crate) fn has_learnt_their_mean(&self, sessions: &BTreeSet<&str>) -> bool {
        let is_alike = |session: &&str| self.without_session(session).world == self.world;
        !self.world.parameters.is_empty() && sessions.iter().all(is_alike)
    }

    /// The simulator in which it predicts; a launch map acts in it.
    pub(crate) fn simulator(&self) -> Result<Simulator, WorldError> {
        ResidualModel::simulator(&self.rig, &self.world, self.residual.as_ref())
    }
}
