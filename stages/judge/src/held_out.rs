//! Strikes that judge, and what a model says of where one stops.

use serde::{Deserialize, Serialize};
use values::{Command, Conditions, Point, Strike};
use world::{Worker, WorldError};

/// How a prediction ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PredictionStatus {
    /// A world's forward simulation.
    Simulated,
    /// The path for which solve + residual would have sent the command.
    Converged,
    /// Solve + residual would never send exactly this command; the path of the nearest that it would send.
    NotConverged,
    /// The simulation did not come to rest; there is no stop.
    Diverged,
}

/// A predicted stop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Predicted {
    /// Where the object comes to rest, in m; none when the simulation diverged.
    pub stop: Option<Point>,
    /// Number of simulations used.
    pub evaluations: u32,
    /// How the prediction ended.
    pub status: PredictionStatus,
}

/// A strike that took no part in a model, by whose stop it is judged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// The strike.
    pub strike_id: String,
    /// Where the object rested before, in m.
    pub initial: Point,
    /// Where the object came to rest, in m; where it did not, the track's end.
    pub stop: Point,
    /// Seconds from the impact to that end; none of a strike that came to rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ends: Option<f64>,
    /// What was commanded.
    pub command: Command,
    /// When and in which session.
    pub conditions: Conditions,
}

impl From<&Strike> for HeldOut {
    fn from(strike: &Strike) -> Self {
        Self {
            strike_id: strike.id.clone(),
            initial: strike.initial,
            stop: strike.stop,
            ends: strike.ends(),
            command: strike.command,
            conditions: strike.conditions.clone(),
        }
    }
}

/// Last place, in m, of a strike's object in a worker's world, struck with this command: at its stop, or at the track's end.
pub(crate) fn last_place(
    worker: &mut Worker<'_>,
    strike: &HeldOut,
    command: Command,
) -> Result<Point, WorldError> {
    let (initial, conditions) = (strike.initial, &strike.conditions);
    match strike.ends {
        None => Ok(worker.strike(initial, command, conditions)?.stop),
        Some(ends) => {
            let simulated = worker.strike_until(initial, command, conditions, ends)?;
            Ok(simulated.at(ends))
        }
    }
}
