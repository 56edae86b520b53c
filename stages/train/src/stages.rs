//! Learning as a stage: sets of strikes, each learnt from by itself, side by side.

use rayon::prelude::*;
use serde::Serialize;
use stage::{ItemStage, Progress};

use crate::{Epoch, Example, Learned, Settings, TrainError, learn};

/// Learns what to add to a world from each set of strikes ([`learn`]).
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Train {
    /// How to train.
    pub settings: Settings,
}

impl ItemStage for Train {
    const NAME: &'static str = "train";
    const VERSION: u32 = 7;
    const BLOCK: usize = 1;
    /// What the strikes were solved in: answers of another are kept apart, and forgotten together.
    type Shared = str;
    type Item = Vec<Example>;
    type Output = Learned;
    type Error = TrainError;

    fn cost(examples: &Vec<Example>) -> u64 {
        examples.len() as u64
    }

    fn run_items(
        &self,
        _shared: &str,
        sets: &[&Vec<Example>],
        progress: &Progress,
    ) -> Result<Vec<Learned>, TrainError> {
        sets.par_iter()
            .map(|examples| {
                let show = |epoch: &Epoch| {
                    progress.set_message(format!(
                        "{} strikes: epoch {} loss {:.4} validation {:.4} rate {:.1e}",
                        examples.len(),
                        epoch.epoch,
                        epoch.train_loss,
                        epoch.validation_mae,
                        epoch.rate
                    ));
                };
                let answer = learn(examples, &self.settings, &show);
                progress.inc(1);
                answer
            })
            .collect()
    }
}
