//! A predicted stop, and how the prediction ended.

use serde::{Deserialize, Serialize};
use values::Point;

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
    /// Simulations used.
    pub evaluations: u32,
    /// How it ended.
    pub status: PredictionStatus,
}
