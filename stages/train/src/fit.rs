//! The training loop.

use burn::{
    nn::loss::{MseLoss, Reduction},
    optim::{AdamConfig, GradientsParams},
    tensor::{Device, Tensor, TensorData},
};
use rand::{RngExt, SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;
use residual::Residual;
use serde::{Deserialize, Serialize};
use store::network::Network;
use values::Split;

use crate::{
    Settings, TrainError,
    model::Model,
    scaling::{Scaling, inputs, targets},
    schedule::{Schedule, Verdict},
};

/// With fewer rows to learn from, 11,042 weights say nothing.
const LEAST_TRAIN: usize = 10;
/// With no row to stop by, nothing distinguishes learning from memorising.
const LEAST_VALIDATION: usize = 1;
/// Units that dropout may silence: the last hidden layer's.
const DROPPED: usize = 32;

/// One pass over the rows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Epoch {
    /// Its number, from 1.
    pub epoch: usize,
    /// Mean squared error over its batches, of scaled targets.
    pub train_loss: f64,
    /// Mean absolute error on the validation rows, of scaled targets: what the schedule follows.
    pub validation_mae: f64,
    /// Adam's rate.
    pub rate: f64,
}

/// Mean absolute errors on a set of rows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mae {
    /// Over both outputs, Δspeed in m/s and Δangle in rad: the number of which the paper reports 0.015.
    pub raw: f64,
    /// Of Δspeed, in m/s.
    pub d_speed: f64,
    /// Of Δangle, in rad.
    pub d_angle: f64,
    /// Over both outputs, in units of the targets' deviation on the rows that learnt.
    pub scaled: f64,
    /// Number of rows.
    pub rows: usize,
}

/// A trained residual model and how it came about.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trained {
    /// The model, with the weights of the best epoch.
    pub network: Network,
    /// Every epoch.
    pub history: Vec<Epoch>,
    /// The epoch whose weights were kept, from 1.
    pub best_epoch: usize,
    /// Number of rows that it learnt from.
    pub train_rows: usize,
    /// Errors on the rows that chose when to stop.
    pub validation: Mae,
    /// Errors on the rows that took no part; none where there is no such row.
    pub test: Option<Mae>,
}

/// Trains on the rows of split `train`, stops by those of `validation`, and measures, at the end, on those of `test`.
/// `on_epoch` sees every epoch as it ends.
pub fn fit(
    rows: &[Residual],
    settings: &Settings,
    on_epoch: &mut dyn FnMut(&Epoch),
) -> Result<Trained, TrainError> {
    settings.check()?;
    let train = part(rows, Split::Train)?;
    let validation = part(rows, Split::Validation)?;
    if train.len() < LEAST_TRAIN || validation.len() < LEAST_VALIDATION {
        return Err(TrainError::TooFewRows {
            train: train.len(),
            validation: validation.len(),
            least_train: LEAST_TRAIN,
            least_validation: LEAST_VALIDATION,
        });
    }

    let scaling = Scalings::fit(&train);
    let mut trainer = Trainer::new(&train, &scaling, settings);
    let mut schedule = Schedule::new(settings);
    let mut history = Vec::new();
    let mut best = None;
    for epoch in 1..=settings.epochs {
        let diverged = TrainError::Diverged {
            epoch,
            rate: settings.rate,
        };
        let rate = schedule.rate();
        let train_loss = trainer.epoch(rate, settings);
        let Ok(network) = trainer.model.fold(&scaling.inputs, &scaling.targets) else {
            return Err(diverged);
        };
        let mae = scaling.mae(&network, &validation);
        if !(train_loss.is_finite() && mae.scaled.is_finite()) {
            return Err(diverged);
        }
        history.push(Epoch {
            epoch,
            train_loss,
            validation_mae: mae.scaled,
            rate,
        });
        on_epoch(&history[epoch - 1]);
        match schedule.epoch(mae.scaled) {
            Verdict::Best => best = Some((epoch, network, mae)),
            Verdict::Continue => {}
            Verdict::Stop => break,
        }
    }

    let (best_epoch, network, mae) = best.expect("the first epoch is the best so far");
    let test = part(rows, Split::Test)?;
    Ok(Trained {
        best_epoch,
        train_rows: train.len(),
        validation: mae,
        test: (!test.is_empty()).then(|| scaling.mae(&network, &test)),
        network,
        history,
    })
}

/// Inputs and targets of one row, in SI units.
type Pair = ([f64; 4], [f64; 2]);

fn part(rows: &[Residual], split: Split) -> Result<Vec<Pair>, TrainError> {
    rows.iter()
        .filter(|row| row.split == split)
        .map(|row| {
            let pair = (inputs(row), targets(row));
            if pair.0.iter().chain(&pair.1).all(|value| value.is_finite()) {
                Ok(pair)
            } else {
                Err(TrainError::NotFinite {
                    strike_id: row.strike_id.clone(),
                })
            }
        })
        .collect()
}

struct Scalings {
    inputs: Scaling<4>,
    targets: Scaling<2>,
}

impl Scalings {
    fn fit(pairs: &[Pair]) -> Self {
        let (inputs, targets): (Vec<_>, Vec<_>) = pairs.iter().copied().unzip();
        Self {
            inputs: Scaling::fit(&inputs),
            targets: Scaling::fit(&targets),
        }
    }

    fn mae(&self, network: &Network, pairs: &[Pair]) -> Mae {
        let errors = pairs.iter().map(|(inputs, targets)| {
            let [d_speed, d_angle] = network.predict(*inputs);
            [(d_speed - targets[0]).abs(), (d_angle - targets[1]).abs()]
        });
        let sum = errors.fold([0.0; 2], |sum, error| {
            [sum[0] + error[0], sum[1] + error[1]]
        });
        let [d_speed, d_angle] = sum.map(|sum| sum / pairs.len() as f64);
        Mae {
            raw: 0.5 * (d_speed + d_angle),
            d_speed,
            d_angle,
            scaled: 0.5
                * (d_speed / self.targets.deviation[0] + d_angle / self.targets.deviation[1]),
            rows: pairs.len(),
        }
    }
}

/// Model, optimiser and the scaled rows.
struct Trainer {
    model: Model,
    optimiser: burn::optim::ModuleOptimizer,
    inputs: Vec<[f32; 4]>,
    targets: Vec<[f32; 2]>,
    shuffles: ChaCha8Rng,
    dropouts: ChaCha8Rng,
    device: Device,
}

impl Trainer {
    fn new(pairs: &[Pair], scaling: &Scalings, settings: &Settings) -> Self {
        let rng = |stream| {
            let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
            rng.set_stream(stream);
            rng
        };
        let device = Device::flex().autodiff();
        Self {
            model: Model::new(&mut rng(0), &device),
            optimiser: AdamConfig::new().init(),
            inputs: pairs
                .iter()
                .map(|(inputs, _)| scaling.inputs.scale(inputs).map(|x| x as f32))
                .collect(),
            targets: pairs
                .iter()
                .map(|(_, targets)| scaling.targets.scale(targets).map(|x| x as f32))
                .collect(),
            shuffles: rng(1),
            dropouts: rng(2),
            device,
        }
    }

    /// One pass, or as many as make `least_steps` steps; the mean squared error over its batches.
    fn epoch(&mut self, rate: f64, settings: &Settings) -> f64 {
        let steps_a_pass = self.inputs.len().div_ceil(settings.batch);
        let passes = settings.least_steps.div_ceil(steps_a_pass).max(1);
        let (mut loss, mut rows) = (0.0, 0);
        for _ in 0..passes {
            let mut order: Vec<usize> = (0..self.inputs.len()).collect();
            order.shuffle(&mut self.shuffles);
            for batch in batches(&order, settings.batch) {
                loss += self.step(batch, rate, settings.dropout) * batch.len() as f64;
                rows += batch.len();
            }
        }
        loss / rows as f64
    }

    /// One step of Adam; the batch's mean squared error before it.
    fn step(&mut self, batch: &[usize], rate: f64, dropout: f64) -> f64 {
        let inputs = self.tensor(
            batch.iter().flat_map(|&row| self.inputs[row]).collect(),
            batch.len(),
        );
        let targets = self.tensor(
            batch.iter().flat_map(|&row| self.targets[row]).collect(),
            batch.len(),
        );
        let mask = self.mask(batch.len(), dropout);
        let outputs = self.model.forward(inputs, mask);
        let loss = MseLoss::new().forward(outputs, targets, Reduction::Mean);
        let gradients = GradientsParams::from_grads(loss.backward(), &self.model);
        let value = loss.into_scalar::<f64>();
        self.model = self.optimiser.step(rate, self.model.clone(), gradients);
        value
    }

    /// Dropout's mask, drawn here because burn draws its own from a source that the whole process shares.
    fn mask(&mut self, rows: usize, dropout: f64) -> Option<Tensor<2>> {
        (dropout > 0.0).then(|| {
            let kept = (1.0 / (1.0 - dropout)) as f32;
            let rng = &mut self.dropouts;
            let draw = |_| if rng.random_bool(dropout) { 0.0 } else { kept };
            let mask = (0..rows * DROPPED).map(draw).collect();
            self.tensor(mask, rows)
        })
    }

    fn tensor(&self, numbers: Vec<f32>, rows: usize) -> Tensor<2> {
        let columns = numbers.len() / rows;
        Tensor::from_data(TensorData::new(numbers, [rows, columns]), &self.device)
    }
}

/// Slices of `size`; a single row left over joins the last, for batch norm needs two.
fn batches(order: &[usize], size: usize) -> impl Iterator<Item = &[usize]> {
    let whole = if order.len() % size == 1 {
        order.len() - size - 1
    } else {
        order.len()
    };
    let (even, rest) = order.split_at(whole);
    even.chunks(size).chain((!rest.is_empty()).then_some(rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_batch_holds_a_single_row() {
        let sizes = |count: usize| -> Vec<usize> {
            batches(&(0..count).collect::<Vec<_>>(), 32)
                .map(<[usize]>::len)
                .collect()
        };
        assert_eq!(sizes(64), [32, 32]);
        assert_eq!(sizes(66), [32, 32, 2]);
        assert_eq!(sizes(65), [32, 33]);
        assert_eq!(sizes(33), [33]);
        assert_eq!(sizes(10), [10]);
    }
}
