//! What was learnt on top of a world.

use serde::{Deserialize, Serialize};
use store::{ResidualModel, TrainingExtent};

use crate::candidate::{Kind, Score};
use crate::fit::Trained;

/// What was learnt on top of a world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Learned {
    /// What is added.
    pub kind: Kind,
    /// The model; none where nothing is added.
    pub model: Option<ResidualModel>,
    /// Every candidate that was tried.
    pub scores: Vec<Score>,
    /// Distance in m between measured and predicted stop of each strike learnt from, by what is added: predicted by a model that
    /// learnt from other commands.
    pub misses: Vec<(String, f64)>,
    /// What the training explains; none where nothing is added.
    pub explained: Option<TrainingExtent>,
    /// The first network's training; none where no network was tried.
    pub training: Option<Trained>,
    /// Number of strikes learnt from.
    pub strikes: usize,
}
