//! The perceptron in burn, and its folding into plain weights.

use burn::module::{Module, Param};
use burn::nn::Linear;
use burn::tensor::activation::relu;
use burn::tensor::module::{batch_norm, batch_norm_train};
use burn::tensor::{Device, Tensor, TensorData};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use store::network::{LAYERS, Layer, Network, NetworkError, SIZES};
use values::Residual;

/// Constants of batch norm: how fast its running mean and variance follow the batches, and what is added to variances.
const MOMENTUM: f64 = 0.1;
const EPSILON: f64 = 1e-5;

/// 4 → 128 → 64 → 32 → 2 with ReLU; batch norm before the first ReLU, dropout after the last.
///
/// The paper names the layers, not their places. Error against a known residual under label noise of 0.005, mean of
/// four sets of 500 rows: dropout of 5 % after the last hidden layer 0.00123, after the second 0.00126, after the
/// first 0.00142, of 10 % after the last 0.00135, none 0.00132. Batch norm stands first, where few features are
/// mixed; without it the error is 0.00108, so it costs little and buys nothing here but the paper's architecture.
#[derive(Module, Debug)]
pub(crate) struct Model {
    dense: Vec<Linear>,
    norm: Norm,
}

impl Model {
    /// Initial weights after Glorot and Bengio (2010), biases zero.
    pub(crate) fn new(rng: &mut ChaCha8Rng, device: &Device) -> Self {
        let dense = (0..LAYERS)
            .map(|index| {
                let (inputs, outputs) = (SIZES[index], SIZES[index + 1]);
                let limit = (6.0 / (inputs + outputs) as f32).sqrt();
                let weights: Vec<f32> = (0..inputs * outputs)
                    .map(|_| rng.random_range(-limit..limit))
                    .collect();
                Linear {
                    weight: Param::from_data(TensorData::new(weights, [inputs, outputs]), device),
                    bias: Some(Param::from_data(
                        TensorData::new(vec![0.0f32; outputs], [outputs]),
                        device,
                    )),
                }
            })
            .collect();
        Self {
            dense,
            norm: Norm::new(SIZES[1], device),
        }
    }

    /// Scaled outputs, rows × 2, of scaled inputs, rows × 4.
    pub(crate) fn forward(&self, inputs: Tensor<2>) -> Tensor<2> {
        let values = self.norm.forward(self.dense[0].forward(inputs));
        self.after_norm(values, None)
    }

    /// Scaled outputs of a batch that is learnt from, by its own mean and variance, which are remembered. `mask` (rows × 32, zero or 1/(1 − dropout))
    /// silences units.
    pub(crate) fn learn(&mut self, inputs: Tensor<2>, mask: Option<Tensor<2>>) -> Tensor<2> {
        let values = self.norm.learn(self.dense[0].forward(inputs));
        self.after_norm(values, mask)
    }

    fn after_norm(&self, values: Tensor<2>, mask: Option<Tensor<2>>) -> Tensor<2> {
        let [_, second, third, last] = &self.dense[..] else {
            unreachable!("a model is made with {LAYERS} layers")
        };
        let values = relu(third.forward(relu(second.forward(relu(values)))));
        last.forward(match mask {
            Some(mask) => values * mask,
            None => values,
        })
    }

    /// This network with batch norm and both scalings folded into plain weights: it takes and gives SI units. Errors where the weights make no valid
    /// network.
    pub(crate) fn fold(
        &self,
        inputs: &Scaling<4>,
        targets: &Scaling<2>,
    ) -> Result<Network, NetworkError> {
        let mut layers: Vec<DenseF64> = self.dense.iter().map(DenseF64::of).collect();
        layers[0].normalise(&self.norm);
        layers[0].take_scaled(inputs);
        layers[LAYERS - 1].give_unscaled(targets);
        Network::new(layers.into_iter().map(DenseF64::narrow).collect())
    }
}

/// Batch norm (Ioffe and Szegedy 2015). burn's own keeps its mean and variance by thread, which needs the feature that [`crate::adam`] does without.
#[derive(Module, Debug)]
struct Norm {
    scale: Param<Tensor<1>>,
    shift: Param<Tensor<1>>,
    mean: Tensor<1>,
    variance: Tensor<1>,
}

impl Norm {
    fn new(units: usize, device: &Device) -> Self {
        let all = |number: f32| TensorData::new(vec![number; units], [units]);
        Self {
            scale: Param::from_data(all(1.0), device),
            shift: Param::from_data(all(0.0), device),
            mean: Tensor::from_data(all(0.0), device),
            variance: Tensor::from_data(all(1.0), device),
        }
    }

    fn forward(&self, values: Tensor<2>) -> Tensor<2> {
        let (scale, shift) = (self.scale.val(), self.shift.val());
        let (mean, variance) = (self.mean.clone(), self.variance.clone());
        batch_norm(values, scale, shift, mean, variance, EPSILON)
    }

    fn learn(&mut self, values: Tensor<2>) -> Tensor<2> {
        let normed = batch_norm_train(values, self.scale.val(), self.shift.val(), EPSILON);
        for (all, of_batch) in [
            (&mut self.mean, normed.mean),
            (&mut self.variance, normed.variance),
        ] {
            let kept = all.clone().mul_scalar(1.0 - MOMENTUM);
            *all = kept.add(of_batch.detach().mul_scalar(MOMENTUM)).detach();
        }
        normed.output
    }
}

/// A dense layer in double precision, so that folding costs no digits.
struct DenseF64 {
    /// One row an output.
    weight: Vec<Vec<f64>>,
    bias: Vec<f64>,
}

impl DenseF64 {
    fn of(dense: &Linear) -> Self {
        let weight = numbers(dense.weight.val());
        let [_, outputs] = dense.weight.val().dims();
        let bias = dense
            .bias
            .as_ref()
            .map(|bias| numbers(bias.val()))
            .unwrap_or_default();
        let row = |output: usize| {
            weight
                .iter()
                .skip(output)
                .step_by(outputs)
                .copied()
                .collect()
        };
        Self {
            weight: (0..outputs).map(row).collect(),
            bias,
        }
    }

    fn normalise(&mut self, norm: &Norm) {
        let (mean, variance) = (numbers(norm.mean.clone()), numbers(norm.variance.clone()));
        let (gamma, beta) = (numbers(norm.scale.val()), numbers(norm.shift.val()));
        for (output, row) in self.weight.iter_mut().enumerate() {
            let factor = gamma[output] / (variance[output] + EPSILON).sqrt();
            row.iter_mut().for_each(|weight| *weight *= factor);
            self.bias[output] = (self.bias[output] - mean[output]) * factor + beta[output];
        }
    }

    /// Folds the scaling of the inputs, which precedes.
    fn take_scaled(&mut self, scaling: &Scaling<4>) {
        for (row, bias) in self.weight.iter_mut().zip(&mut self.bias) {
            for (input, weight) in row.iter_mut().enumerate() {
                *weight /= scaling.deviation[input];
                *bias -= *weight * scaling.mean[input];
            }
        }
    }

    /// Folds the scaling of the targets, which is undone after.
    fn give_unscaled(&mut self, scaling: &Scaling<2>) {
        for (output, row) in self.weight.iter_mut().enumerate() {
            row.iter_mut()
                .for_each(|weight| *weight *= scaling.deviation[output]);
            self.bias[output] =
                self.bias[output] * scaling.deviation[output] + scaling.mean[output];
        }
    }

    fn narrow(self) -> Layer {
        Layer {
            weight: self
                .weight
                .into_iter()
                .flatten()
                .map(|weight| weight as f32)
                .collect(),
            bias: self.bias.into_iter().map(|bias| bias as f32).collect(),
        }
    }
}

fn numbers<const D: usize>(tensor: Tensor<D>) -> Vec<f64> {
    tensor.into_data().iter::<f64>().collect()
}

/// Below this deviation a column is constant, and is only shifted: its last digits are no information.
const CONSTANT: f64 = 1e-9;

/// Mean and standard deviation of each column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scaling<const N: usize> {
    pub(crate) mean: [f64; N],
    pub(crate) deviation: [f64; N],
}

impl<const N: usize> Scaling<N> {
    pub(crate) fn fit(rows: &[[f64; N]]) -> Self {
        let count = rows.len() as f64;
        let mean = std::array::from_fn(|i| rows.iter().map(|row| row[i]).sum::<f64>() / count);
        let deviation = std::array::from_fn(|i| {
            let variance = rows
                .iter()
                .map(|row| (row[i] - mean[i]).powi(2))
                .sum::<f64>()
                / count;
            if variance.sqrt() > CONSTANT {
                variance.sqrt()
            } else {
                1.0
            }
        });
        Self { mean, deviation }
    }

    pub(crate) fn scale(&self, row: &[f64; N]) -> [f64; N] {
        std::array::from_fn(|i| (row[i] - self.mean[i]) / self.deviation[i])
    }
}

/// What the network sees of a row, in SI units.
pub(crate) fn inputs(row: &Residual) -> [f64; 4] {
    [row.path.x, row.path.y, row.speed_sim, row.angle_sim]
}

/// What it must answer, in SI units.
pub(crate) fn targets(row: &Residual) -> [f64; 2] {
    [row.d_speed, row.d_angle]
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    #[test]
    fn the_folded_network_answers_as_burn_does() {
        let device = Device::flex().autodiff();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut model = Model::new(&mut rng, &device);
        let mut row = || -> [f64; 4] { std::array::from_fn(|_| rng.random_range(-2.0..2.0)) };
        let rows: Vec<[f64; 4]> = (0..64).map(|_| row()).collect();
        let flat: Vec<f32> = rows.iter().flatten().map(|value| *value as f32).collect();
        // Training passes move batch norm's running statistics away from zero and one.
        for _ in 0..50 {
            let batch = Tensor::<2>::from_data(TensorData::new(flat.clone(), [64, 4]), &device);
            model.learn(batch, None);
        }

        let inputs = Scaling {
            mean: [0.3, -0.1, 0.8, 0.2],
            deviation: [0.1, 0.2, 0.15, 0.3],
        };
        let targets = Scaling {
            mean: [0.05, -0.02],
            deviation: [0.03, 0.01],
        };
        let network = model.fold(&inputs, &targets).expect("finite");
        let still = model.valid();
        let batch = Tensor::<2>::from_data(TensorData::new(flat, [64, 4]), &Device::flex());
        let answers = numbers(still.forward(batch));
        let mut largest: f64 = 0.0;
        for (row, answer) in rows.iter().zip(answers.chunks_exact(2)) {
            let si = std::array::from_fn(|i| row[i] * inputs.deviation[i] + inputs.mean[i]);
            let folded = network.predict(si);
            for i in 0..2 {
                let burn = answer[i] * targets.deviation[i] + targets.mean[i];
                largest = largest.max((folded[i] - burn).abs());
            }
        }
        assert!(largest < 1e-5, "{largest}");
    }

    #[test]
    fn scaled_columns_have_zero_mean_and_unit_deviation() {
        let rows = [[1.0, 5.0], [2.0, 5.0], [6.0, 5.0]];
        let scaling = Scaling::fit(&rows);
        let scaled: Vec<_> = rows.iter().map(|row| scaling.scale(row)).collect();
        let sum: f64 = scaled.iter().map(|row| row[0]).sum();
        let squares: f64 = scaled.iter().map(|row| row[0] * row[0]).sum();
        assert!(sum.abs() < 1e-12 && (squares / 3.0 - 1.0).abs() < 1e-12);
        assert!(
            scaled.iter().all(|row| row[1] == 0.0),
            "a constant column is only shifted"
        );
    }
}
