//! Strike by strike: a strike that judged a model once need not again.

use rayon::prelude::*;
use serde::Serialize;
use stage::{ItemStage, Progress};
use store::ResidualModel;
use values::Strike;
use world::{Observation, Observer, Simulator, Worker};

use crate::{EvaluateError, Judge, Model, Predicted, Slopes, predict};

/// A model's prediction of each strike.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Predict;

impl ItemStage for Predict {
    const NAME: &'static str = "predict";
    const VERSION: u32 = 6;
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

/// What each strike shows of the table beside a model that does not know its session; none where its track shows no free slide.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Observe;

impl ItemStage for Observe {
    const NAME: &'static str = "observe";
    const VERSION: u32 = 1;
    type Shared = Model;
    type Item = Strike;
    type Output = Option<Observation>;
    type Error = EvaluateError;

    fn run_items(
        &self,
        model: &Model,
        strikes: &[&Strike],
        progress: &Progress,
    ) -> Result<Vec<Option<Observation>>, EvaluateError> {
        let residual = model.residual.as_ref();
        let alone = Simulator::new(&model.rig, &model.world)?;
        let observer = Observer::about(&ResidualModel::simulator(
            &model.rig,
            &model.world,
            residual,
        )?);
        let observe = |strike: &&Strike| {
            let (initial, sent) = (strike.initial, strike.command);
            let sent = match residual {
                Some(residual) => {
                    residual.without_added(&alone, initial, sent, &strike.conditions)?
                }
                None => sent,
            };
            observer.observe(strike, sent)
        };
        Ok(strikes
            .par_iter()
            .map(|strike| {
                let observation = observe(strike);
                progress.inc(1);
                observation
            })
            .collect())
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
