//! Strike by strike: a strike that judged a model once need not again.

use rayon::prelude::*;
use serde::Serialize;
use stage::{ItemStage, Progress};
use store::ResidualModel;
use values::Strike;
use world::{Observation, Observer, Simulator, Worker};

use crate::{HeldOut, JudgeError, Model, Predicted, Slopes, predict};

/// A model's prediction of each strike.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Predict;

impl ItemStage for Predict {
    const NAME: &'static str = "predict";
    const VERSION: u32 = 7;
    type Shared = Model;
    type Item = HeldOut;
    type Output = Predicted;
    type Error = JudgeError;

    fn run_items(
        &self,
        model: &Model,
        strikes: &[&HeldOut],
        progress: &Progress,
    ) -> Result<Vec<Predicted>, JudgeError> {
        let networks = model.residual.as_ref().and_then(ResidualModel::networks);
        each(model, strikes, progress, |worker, strike| {
            predict(worker, networks, strike)
        })
    }
}

/// How each strike's stop moves with its launch in a model's world; none where that cannot simulate it. The noise floor
/// follows.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Repeat;

impl ItemStage for Repeat {
    const NAME: &'static str = "repeat";
    const VERSION: u32 = 5;
    type Shared = Model;
    type Item = HeldOut;
    type Output = Option<Slopes>;
    type Error = JudgeError;

    fn run_items(
        &self,
        model: &Model,
        strikes: &[&HeldOut],
        progress: &Progress,
    ) -> Result<Vec<Option<Slopes>>, JudgeError> {
        each(model, strikes, progress, Slopes::of)
    }
}

/// What each strike shows of the table beside a model that does not know its session; none where its track shows no free slide.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Observe;

impl ItemStage for Observe {
    const NAME: &'static str = "observe";
    const VERSION: u32 = 2;
    type Shared = Model;
    type Item = Strike;
    type Output = Option<Observation>;
    type Error = JudgeError;

    fn run_items(
        &self,
        model: &Model,
        strikes: &[&Strike],
        progress: &Progress,
    ) -> Result<Vec<Option<Observation>>, JudgeError> {
        let residual = model.residual.as_ref();
        let alone = Simulator::new(&model.rig, &model.world)?;
        let observer = Observer::about(&model.simulator()?);
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
    strikes: &[&HeldOut],
    progress: &Progress,
    answer: impl Fn(&mut Worker<'_>, &HeldOut) -> T + Sync,
) -> Result<Vec<T>, JudgeError> {
    Ok(model.simulator()?.map(strikes, |worker, strike| {
        let answer = answer(worker, strike);
        progress.inc(1);
        answer
    }))
}
