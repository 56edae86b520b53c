//! Training and its learning curve as stages.

use residual::Residual;
use serde::Serialize;
use stage::{Progress, Stage};

use crate::{CurvePoint, Epoch, Settings, TrainError, Trained, fit, learning_curve};

/// Trains the residual model; its input is the residuals. The answer is none where the rows are too few to train on
/// ([`TrainError::TooFewRows`]): the world then serves without a residual.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Train {
    /// How to train.
    pub settings: Settings,
}

impl Stage for Train {
    const NAME: &'static str = "train";
    const VERSION: u32 = 1;
    type Input = Vec<Residual>;
    type Output = Option<Trained>;
    type Error = TrainError;

    fn run(&self, rows: &Vec<Residual>, progress: &Progress) -> Result<Self::Output, TrainError> {
        progress.items(self.settings.epochs);
        let mut show = |epoch: &Epoch| {
            progress.inc(1);
            progress.set_message(format!(
                "epoch {} loss {:.4} validation {:.4} rate {:.1e}",
                epoch.epoch, epoch.train_loss, epoch.validation_mae, epoch.rate
            ));
        };
        match fit(rows, &self.settings, &mut show) {
            Ok(trained) => Ok(Some(trained)),
            Err(TrainError::TooFewRows { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }
}

/// Trains on the first so many strikes; its input is the residuals, in the order in which the strikes were made.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LearningCurve {
    /// How to train.
    pub settings: Settings,
    /// Numbers of strikes.
    pub sizes: Vec<usize>,
}

impl Default for LearningCurve {
    fn default() -> Self {
        Self {
            settings: Settings::default(),
            sizes: vec![25, 50, 100, 200, 500],
        }
    }
}

impl Stage for LearningCurve {
    const NAME: &'static str = "learning_curve";
    const VERSION: u32 = 1;
    type Input = Vec<Residual>;
    type Output = Vec<CurvePoint>;
    type Error = TrainError;

    fn run(&self, rows: &Vec<Residual>, progress: &Progress) -> Result<Self::Output, TrainError> {
        progress.items(self.sizes.len());
        learning_curve(rows, &self.sizes, &self.settings, &mut |point| {
            progress.inc(1);
            progress.set_message(format!(
                "{} strikes: validation {:.4}",
                point.strikes, point.trained.validation.scaled
            ));
        })
    }
}
