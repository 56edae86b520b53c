//! Where a model says a logged strike stops.

use artifacts::network::Network;
use serde::{Deserialize, Serialize};
use values::{Point, Strike};
use world::Worker;

use crate::inverse;

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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predicted {
    /// Where the object comes to rest, in m; none when the simulation diverged.
    pub stop: Option<Point>,
    /// Simulations used.
    pub evaluations: u32,
    /// How it ended.
    pub status: PredictionStatus,
}

/// The stop that a model predicts for the command that was sent: the worker's world alone, or with a residual.
pub fn predict(worker: &mut Worker<'_>, residual: Option<&Network>, strike: &Strike) -> Predicted {
    if let Some(network) = residual {
        return inverse::meant_by(worker, network, strike.initial, strike.command);
    }
    let simulated = worker.strike(strike.initial, strike.command, &strike.conditions);
    let status = match simulated {
        Ok(_) => PredictionStatus::Simulated,
        Err(_) => PredictionStatus::Diverged,
    };
    Predicted {
        stop: simulated.ok().map(|simulated| simulated.stop),
        evaluations: 1,
        status,
    }
}
