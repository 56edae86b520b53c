//! Where a model says a logged strike stops.

use serde::{Deserialize, Serialize};
use store::Networks;
use values::{Command, Conditions, Point, Strike};
use world::Worker;

use crate::{
    inverse,
    predicted::{Predicted, PredictionStatus},
};

/// What of a logged strike a model is judged by.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Judge {
    /// The strike.
    pub strike_id: String,
    /// Where the object rested before, in m.
    pub initial: Point,
    /// Where it came to rest, in m.
    pub stop: Point,
    /// What was commanded.
    pub command: Command,
    /// When and in which session.
    pub conditions: Conditions,
}

impl From<&Strike> for Judge {
    fn from(strike: &Strike) -> Self {
        Self {
            strike_id: strike.id.clone(),
            initial: strike.initial,
            stop: strike.stop,
            command: strike.command,
            conditions: strike.conditions.clone(),
        }
    }
}

/// The stop that a model predicts for the command that was sent: the worker's world alone, in which a launch map already acts, or with
/// networks.
pub fn predict(worker: &mut Worker<'_>, networks: Option<&Networks>, judge: &Judge) -> Predicted {
    let Judge {
        initial,
        command,
        conditions,
        ..
    } = judge;
    if let Some(networks) = networks {
        return inverse::meant_by(worker, networks, *initial, *command, conditions);
    }
    let simulated = worker.strike(*initial, *command, conditions);
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
