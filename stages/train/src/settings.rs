//! What can be set.

use serde::{Deserialize, Serialize};

use crate::TrainError;

/// How to train; the default is the paper's section 3.4.1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Where initial weights, shuffles and dropout are drawn from.
    pub seed: u64,
    /// Most epochs.
    pub epochs: usize,
    /// Rows a step.
    pub batch: usize,
    /// Adam's rate to begin with.
    pub rate: f64,
    /// The rate is not halved below this.
    pub least_rate: f64,
    /// Epochs without improvement of the validation error after which the rate is halved.
    pub halve_after: usize,
    /// Epochs without improvement of the validation error after which training ends.
    pub stop_after: usize,
    /// Share of the last hidden layer's units that dropout silences in a step; the paper gives none.
    pub dropout: f64,
    /// Steps an epoch, whatever the rows: 13 are one pass over the paper's 400. `halve_after` and `stop_after` count epochs: they would end the
    /// training of a small set before it began (50 rows: a third of the error is saved), and that of a large one never.
    pub steps: usize,
    /// Whether networks are among what is tried.
    pub networks: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            seed: 0,
            epochs: 500,
            batch: 32,
            rate: 1e-3,
            least_rate: 1e-6,
            halve_after: 5,
            stop_after: 20,
            dropout: 0.05,
            steps: 13,
            networks: true,
        }
    }
}

impl Settings {
    /// Refuses what cannot be trained with, and names it.
    pub(crate) fn check(&self) -> Result<(), TrainError> {
        let demand = |name, sound: bool, must| {
            if sound {
                Ok(())
            } else {
                Err(TrainError::Setting { name, must })
            }
        };
        let positive = |rate: f64| rate > 0.0 && rate.is_finite();
        demand("epochs", self.epochs > 0, "at least 1")?;
        demand("steps", self.steps > 0, "at least 1")?;
        demand("batch", self.batch > 1, "at least 2, for batch norm")?;
        demand("rate", positive(self.rate), "above 0")?;
        demand(
            "least_rate",
            positive(self.least_rate) && self.least_rate <= self.rate,
            "above 0 and at most `rate`",
        )?;
        demand("halve_after", self.halve_after > 0, "at least 1")?;
        demand("stop_after", self.stop_after > 0, "at least 1")?;
        demand("dropout", (0.0..1.0).contains(&self.dropout), "in [0, 1)")
    }
}
