//! What is added to a world's command: one of two kinds, in one file.
//!
//! A *launch map* says what the arm delivers beside the world, as a function of the command ([`LaunchMap`]). *Networks* say what to
//! add to the world's command for a path (paper, section 3.4): the mean of a few of them, each trained on other strikes.

use std::sync::Arc;

use safetensors::SafeTensors;
use serde::{Deserialize, Serialize};
use values::{Command, Conditions, Point, Rig};
use world::{Simulator, World, WorldError};

use self::launch_map_file::{map_from_safetensors, map_to_safetensors};
use crate::launch_map::LaunchMap;
use crate::network::{Network, NetworkError};

pub use networks::{MOST_NETWORKS, Networks, ResidualModelError};

mod launch_map_file;
mod networks;
#[cfg(test)]
mod tests;

/// Passes in which networks and path agree to a tenth of a millimetre: a residual changes little.
const MOST_PASSES: usize = 3;

/// What is added to a world's command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ResidualModel {
    /// What the arm delivers beside the world.
    Launch(LaunchMap),
    /// What to add to the world's command.
    Networks(Networks),
}

impl ResidualModel {
    /// The world in which this residual model plans and predicts: with a launch map the arm delivers what that says. Errors if the
    /// world does not compile.
    pub fn simulator(
        rig: &Rig,
        world: &World,
        residual: Option<&Self>,
    ) -> Result<Simulator, WorldError> {
        let simulator = Simulator::new(rig, world)?;
        Ok(match residual {
            Some(Self::Launch(map)) => simulator.with_delivery(Arc::new(map.clone())),
            Some(Self::Networks(_)) | None => simulator,
        })
    }

    /// The command for which the world alone does what it does for the command that was sent to an object at `initial` (m): networks
    /// add to it what they add for its path. A launch map acts within the world, and takes nothing off. None where the world cannot
    /// simulate it.
    pub fn without_added(
        &self,
        alone: &Simulator,
        initial: Point,
        sent: Command,
        conditions: &Conditions,
    ) -> Option<Command> {
        let Self::Networks(networks) = self else {
            return Some(sent);
        };
        let mut worker = alone.worker();
        let mut command = sent;
        for _ in 0..MOST_PASSES {
            let path = worker.strike(initial, command, conditions).ok()?.stop - initial;
            let [d_speed, d_angle] =
                networks.predict([path.x, path.y, command.speed, command.angle]);
            command = Command::new(sent.speed - d_speed, sent.angle - d_angle);
        }
        Some(command)
    }

    /// Its networks; none for a launch map, which acts within the world ([`ResidualModel::simulator`]).
    pub fn networks(&self) -> Option<&Networks> {
        match self {
            Self::Launch(_) => None,
            Self::Networks(networks) => Some(networks),
        }
    }

    /// What it adds to the world's command for a path (m): speed in m/s and angle in rad. Of a launch map, what the arm delivers
    /// otherwise at the command `sent`, with its sign turned: that much more has to be sent.
    pub fn added(&self, path: Point, simulated: Command, sent: Command) -> [f64; 2] {
        match self {
            Self::Launch(map) => map.added(sent),
            Self::Networks(networks) => {
                networks.predict([path.x, path.y, simulated.speed, simulated.angle])
            }
        }
    }

    /// The content of `residual.safetensors`. The same model always gives the same bytes.
    pub fn to_safetensors(&self) -> Vec<u8> {
        match self {
            Self::Networks(networks) => networks.to_safetensors(),
            Self::Launch(map) => map_to_safetensors(map),
        }
    }

    /// Reads what [`ResidualModel::to_safetensors`] wrote, of either kind; everything is checked.
    pub fn from_safetensors(bytes: &[u8]) -> Result<Self, ResidualModelError> {
        let file = SafeTensors::deserialize(bytes).map_err(NetworkError::Format)?;
        if file.names().iter().any(|name| name.starts_with("launch.")) {
            Ok(Self::Launch(map_from_safetensors(&file)?))
        } else {
            Ok(Self::Networks(Networks::from_safetensors(&file)?))
        }
    }
}

impl From<Network> for ResidualModel {
    fn from(network: Network) -> Self {
        Self::Networks(Networks(vec![network]))
    }
}

impl From<LaunchMap> for ResidualModel {
    fn from(map: LaunchMap) -> Self {
        Self::Launch(map)
    }
}
