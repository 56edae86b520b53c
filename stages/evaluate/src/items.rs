//! Strike by strike: a strike that judged a model once need not again.

use serde::Serialize;
use stage::{ItemStage, Progress};
use store::ResidualModel;
use world::Worker;

use crate::{EvaluateError, Judge, Model, Predicted, Slopes, predict};

/// A model's prediction of each strike.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Predict;

impl ItemStage for Predict {
    const NAME: &'static str = "predict";
    const VERSION: u32 = 5;
    type Shared = Model;
    type Item = Judge;
    type Output = Predicted;
    type Error = EvaluateError;

    fn run_items(
        &self,
        model: &Model,
        judges: &[&Judge],
        progress: &Progress,
    ) -> Result<Vec<Predicted>, EvaluateError> {
        let networks = model.residual.as_ref().and_then(ResidualModel::networks);
        each(model, judges, progress, |worker, judge| {
            predict(worker, networks, judge)
        })
    }
}

/// How each strike's stop moves with its launch in a model's world; none where that cannot simulate it. The noise floor
/// follows.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Repeat;

impl ItemStage for Repeat {
    const NAME: &'static str = "repeat";
    const VERSION: u32 = 4;
    type Shared = Model;
    type Item = Judge;
    type Output = Option<Slopes>;
    type Error = EvaluateError;

    fn run_items(
        &self,
        model: &Model,
        judges: &[&Judge],
        progress: &Progress,
    ) -> Result<Vec<Option<Slopes>>, EvaluateError> {
        each(model, judges, progress, Slopes::of)
    }
}

fn each<T: Send>(
    model: &Model,
    judges: &[&Judge],
    progress: &Progress,
    answer: impl Fn(&mut Worker<'_>, &Judge) -> T + Sync,
) -> Result<Vec<T>, EvaluateError> {
    let simulator = ResidualModel::simulator(&model.rig, &model.world, model.residual.as_ref())?;
    Ok(simulator.map(judges, |worker, judge| {
        let answer = answer(worker, judge);
        progress.inc(1);
        answer
    }))
}
