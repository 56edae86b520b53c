//! The training loop.

use burn::{
    module::Module,
    nn::loss::{MseLoss, Reduction},
    tensor::{Device, Tensor, TensorData},
};
use rand::{RngExt, SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use store::network::Network;
use values::{Residual, Split};

use crate::{
    Settings, TrainError,
    adam::Adam,
    model::{Model, Scaling, inputs, targets},
    schedule::{Schedule, Verdict},
};

/// With fewer rows to learn from, 11,042 weights say nothing.
const LEAST_TRAIN: usize = 10;
/// With no row to stop by, nothing distinguishes learning from memorising.
const LEAST_VALIDATION: usize = 1;
/// More rows than these follow the schedule no better, and would take longer than what they end.
const MOST_VALIDATION: usize = 400;
/// Units that dropout may silence: the last hidden layer's.
const DROPPED: usize = 32;

/// The result of one epoch of [`Settings::steps`] steps.
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
    /// Mean absolute error of Δspeed, in m/s.
    pub d_speed: f64,
    /// Mean absolute error of Δangle, in rad.
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
    let mut validation = part(rows, Split::Validation)?;
    let every = validation.len().div_ceil(MOST_VALIDATION).max(1);
    validation = validation.into_iter().step_by(every).collect();
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
    let followed = Scaled::of(&validation, &scaling);
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
        let validation_mae = trainer.mae(&followed);
        if !(train_loss.is_finite() && validation_mae.is_finite()) {
            return Err(diverged);
        }
        history.push(Epoch {
            epoch,
            train_loss,
            validation_mae,
            rate,
        });
        on_epoch(&history[epoch - 1]);
        match schedule.epoch(validation_mae) {
            Verdict::Best => {
                let Ok(network) = trainer.model.fold(&scaling.inputs, &scaling.targets) else {
                    return Err(diverged);
                };
                best = Some((epoch, network));
            }
            Verdict::Continue => {}
            Verdict::Stop => break,
        }
    }

    let (best_epoch, network) = best.expect("the first epoch is the best so far");
    let test = part(rows, Split::Test)?;
    Ok(Trained {
        best_epoch,
        train_rows: train.len(),
        validation: scaling.mae(&network, &validation),
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

/// Rows in units of the deviations of those that learn.
struct Scaled {
    inputs: Vec<[f32; 4]>,
    targets: Vec<[f32; 2]>,
}

impl Scaled {
    fn of(pairs: &[Pair], scaling: &Scalings) -> Self {
        let pair = |(inputs, targets): &Pair| {
            let inputs = scaling.inputs.scale(inputs).map(|x| x as f32);
            (inputs, scaling.targets.scale(targets).map(|x| x as f32))
        };
        let (inputs, targets) = pairs.iter().map(pair).unzip();
        Self { inputs, targets }
    }
}

/// Model, optimiser and the rows that learn.
struct Trainer {
    model: Model,
    optimiser: Adam,
    rows: Scaled,
    /// Rows of this pass that no step has seen yet, the next one last.
    waiting: Vec<usize>,
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
            optimiser: Adam::default(),
            rows: Scaled::of(pairs, scaling),
            waiting: Vec::new(),
            shuffles: rng(1),
            dropouts: rng(2),
            device,
        }
    }

    /// Takes one epoch's steps, and returns the mean squared error over their batches.
    fn epoch(&mut self, rate: f64, settings: &Settings) -> f64 {
        let (mut loss, mut rows) = (0.0, 0);
        for _ in 0..settings.steps {
            let batch = self.batch(settings.batch);
            loss += self.step(&batch, rate, settings.dropout) * batch.len() as f64;
            rows += batch.len();
        }
        loss / rows as f64
    }

    /// The next rows of a pass in random order; passes follow one another, whatever epochs do. A single row that would be left over joins
    /// the last batch, for batch norm needs two.
    fn batch(&mut self, size: usize) -> Vec<usize> {
        if self.waiting.is_empty() {
            self.waiting = (0..self.rows.inputs.len()).collect();
            self.waiting.shuffle(&mut self.shuffles);
        }
        let left = self.waiting.len().saturating_sub(size);
        self.waiting.split_off(if left == 1 { 0 } else { left })
    }

    /// Mean absolute error of scaled targets, as the network answers that would be kept.
    fn mae(&self, rows: &Scaled) -> f64 {
        let numbers = |numbers: Vec<f32>, columns: usize| {
            let shape = [rows.inputs.len(), columns];
            Tensor::<2>::from_data(TensorData::new(numbers, shape), &Device::flex())
        };
        let inputs = numbers(rows.inputs.iter().copied().flatten().collect(), 4);
        let targets = numbers(rows.targets.iter().copied().flatten().collect(), 2);
        let answers = self.model.valid().forward(inputs);
        (answers - targets).abs().mean().into_scalar::<f64>()
    }

    /// One step of Adam; the batch's mean squared error before it.
    fn step(&mut self, batch: &[usize], rate: f64, dropout: f64) -> f64 {
        let inputs = self.tensor(
            batch
                .iter()
                .flat_map(|&row| self.rows.inputs[row])
                .collect(),
            batch.len(),
        );
        let targets = self.tensor(
            batch
                .iter()
                .flat_map(|&row| self.rows.targets[row])
                .collect(),
            batch.len(),
        );
        let mask = self.mask(batch.len(), dropout);
        let outputs = self.model.learn(inputs, mask);
        let loss = MseLoss::new().forward(outputs, targets, Reduction::Mean);
        let (gradients, value) = (loss.backward(), loss.into_scalar::<f64>());
        self.model = self.optimiser.step(rate, self.model.clone(), &gradients);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_batch_holds_a_single_row_and_a_pass_holds_each_once() {
        for (count, sizes) in [
            (64, vec![32, 32]),
            (66, vec![32, 32, 2]),
            (65, vec![32, 33]),
            (33, vec![33]),
            (10, vec![10]),
        ] {
            let pairs: Vec<Pair> = (0..count).map(|i| ([f64::from(i); 4], [0.0; 2])).collect();
            let scaling = Scalings::fit(&pairs);
            let mut trainer = Trainer::new(&pairs, &scaling, &Settings::default());
            for _pass in 0..2 {
                let batches: Vec<Vec<usize>> = sizes.iter().map(|_| trainer.batch(32)).collect();
                assert_eq!(batches.iter().map(Vec::len).collect::<Vec<_>>(), sizes);
                let mut seen: Vec<usize> = batches.concat();
                seen.sort_unstable();
                assert_eq!(seen, (0..count as usize).collect::<Vec<_>>());
            }
        }
    }
}
