//! Training as a stage: sets of rows, each trained on by itself, side by side.

use rayon::prelude::*;
use residual::Residual;
use serde::Serialize;
use stage::{ItemStage, Progress};

use crate::{Epoch, Settings, TrainError, Trained, fit};

/// Trains the residual model on each set of residuals. The answer to a set is none where its rows are too few to train on
/// ([`TrainError::TooFewRows`]): the world then serves without a residual.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Train {
    /// How to train.
    pub settings: Settings,
}

impl ItemStage for Train {
    const NAME: &'static str = "train";
    const VERSION: u32 = 2;
    /// What the rows were computed in: answers of another are kept apart, and forgotten together.
    type Shared = str;
    type Item = Vec<Residual>;
    type Output = Option<Trained>;
    type Error = TrainError;

    fn run_items(
        &self,
        _shared: &str,
        sets: &[&Vec<Residual>],
        progress: &Progress,
    ) -> Result<Vec<Self::Output>, TrainError> {
        sets.par_iter()
            .map(|rows| {
                let mut show = |epoch: &Epoch| {
                    progress.set_message(format!(
                        "{} rows: epoch {} loss {:.4} validation {:.4} rate {:.1e}",
                        rows.len(),
                        epoch.epoch,
                        epoch.train_loss,
                        epoch.validation_mae,
                        epoch.rate
                    ));
                };
                let answer = match fit(rows, &self.settings, &mut show) {
                    Ok(trained) => Ok(Some(trained)),
                    Err(TrainError::TooFewRows { .. }) => Ok(None),
                    Err(error) => Err(error),
                };
                progress.inc(1);
                answer
            })
            .collect()
    }
}
