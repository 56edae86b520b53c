//! The residual model as the executor uses it: four dense layers with plain weights.
//!
//! Training folds batch norm and standard scaling into the weights, so that inputs and outputs are SI quantities and
//! a prediction is four matrix products with ReLU in between (paper, section 3.4.1). Products are summed in double
//! precision in a fixed order: the same inputs give the same bits on every machine.

use safetensors::tensor::Dtype;
use safetensors::{SafeTensorError, SafeTensors};
use serde::{Deserialize, Serialize};

/// Values that pass between the layers: inputs, three hidden layers, outputs (paper, section 3.4.1).
pub const SIZES: [usize; 5] = [4, 128, 64, 32, 2];

/// Number of dense layers.
pub const LAYERS: usize = SIZES.len() - 1;

/// One dense layer, y = W·x + b.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Layer {
    /// W, row by row: outputs × inputs.
    pub weight: Vec<f32>,
    /// b, one for each output.
    pub bias: Vec<f32>,
}

/// The residual model: \[path_x m, path_y m, speed_sim m/s, angle_sim rad\] → \[Δspeed m/s, Δangle rad\].
///
/// Whatever way it is made, its shapes are [`SIZES`] and its weights are finite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<Layer>", into = "Vec<Layer>")]
pub struct Network {
    layers: Vec<Layer>,
}

/// Why weights were not accepted. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum NetworkError {
    #[error(
        "read the residual's weights: not a whole safetensors file ({0}); restore the file or train again"
    )]
    Format(#[source] SafeTensorError),
    #[error(
        "read the residual's weights: the file holds [{found}] where [{expected}] must be; was it written by another program?"
    )]
    Names { found: String, expected: String },
    #[error("read the residual's weights: `{name}` is {found}, it must be {expected}")]
    Shape {
        name: String,
        found: String,
        expected: String,
    },
    #[error("read the residual's weights: `{name}` holds a number that is not finite; train again")]
    NotFinite { name: String },
}

impl Network {
    /// The network with these layers; refuses other shapes than [`SIZES`] and weights that are not finite.
    pub fn new(layers: Vec<Layer>) -> Result<Self, NetworkError> {
        if layers.len() != LAYERS {
            return Err(NetworkError::Shape {
                name: "layers".into(),
                found: format!("a list of {}", layers.len()),
                expected: format!("a list of {LAYERS}"),
            });
        }
        for (index, layer) in layers.iter().enumerate() {
            let [weight, bias] = specs(index);
            weight.check(&layer.weight)?;
            bias.check(&layer.bias)?;
        }
        Ok(Self { layers })
    }

    /// What to add to the simulated command: \[Δspeed m/s, Δangle rad\] for \[path_x m, path_y m, speed_sim m/s,
    /// angle_sim rad\].
    pub fn predict(&self, inputs: [f64; 4]) -> [f64; 2] {
        let mut values = inputs.to_vec();
        for (index, layer) in self.layers.iter().enumerate() {
            let last = index + 1 == LAYERS;
            values = layer
                .weight
                .chunks_exact(SIZES[index])
                .zip(&layer.bias)
                .map(|(row, bias)| {
                    let products = row.iter().zip(&values).map(|(w, x)| f64::from(*w) * x);
                    let sum = products.sum::<f64>() + f64::from(*bias);
                    if last { sum } else { sum.max(0.0) }
                })
                .collect();
        }
        [values[0], values[1]]
    }

    /// The layers, first to last.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// Its f32 tensors, `layerN.weight` (outputs × inputs) and `layerN.bias` after a prefix: name, shape and bytes.
    pub(crate) fn tensors(&self, prefix: &str) -> Vec<(String, Vec<usize>, Vec<u8>)> {
        let tensors = self.layers.iter().enumerate().flat_map(|(index, layer)| {
            let [weight, bias] = specs(index);
            [(weight, bytes(&layer.weight)), (bias, bytes(&layer.bias))]
        });
        tensors
            .map(|(spec, data)| (format!("{prefix}{}", spec.name), spec.shape, data))
            .collect()
    }

    /// Reads a network's tensors: types and shapes must be right, every weight finite.
    pub(crate) fn from_tensors(file: &SafeTensors, prefix: &str) -> Result<Self, NetworkError> {
        let layers = (0..LAYERS)
            .map(|index| {
                let [weight, bias] = specs(index).map(|spec| Spec {
                    name: format!("{prefix}{}", spec.name),
                    ..spec
                });
                Ok(Layer {
                    weight: weight.read(file)?,
                    bias: bias.read(file)?,
                })
            })
            .collect::<Result<_, NetworkError>>()?;
        Self::new(layers)
    }

    /// Whether a file's tensors are those of networks with these prefixes and no others.
    pub(crate) fn check_names(file: &SafeTensors, prefixes: &[String]) -> Result<(), NetworkError> {
        let mut found: Vec<String> = file.names().into_iter().map(String::from).collect();
        let mut expected: Vec<String> = prefixes
            .iter()
            .flat_map(|prefix| {
                (0..LAYERS)
                    .flat_map(specs)
                    .map(move |spec| format!("{prefix}{}", spec.name))
            })
            .collect();
        found.sort();
        expected.sort();
        if found == expected {
            Ok(())
        } else {
            Err(NetworkError::Names {
                found: found.join(", "),
                expected: expected.join(", "),
            })
        }
    }
}

impl Network {
    /// This network, whose every answer is this share of what it was: the last layer is scaled.
    pub fn scaled(&self, share: f64) -> Result<Self, NetworkError> {
        let mut layers = self.layers.clone();
        let last = &mut layers[LAYERS - 1];
        for value in last.weight.iter_mut().chain(&mut last.bias) {
            *value = (f64::from(*value) * share) as f32;
        }
        Self::new(layers)
    }
}

impl TryFrom<Vec<Layer>> for Network {
    type Error = NetworkError;
    fn try_from(layers: Vec<Layer>) -> Result<Self, NetworkError> {
        Self::new(layers)
    }
}

impl From<Network> for Vec<Layer> {
    fn from(network: Network) -> Self {
        network.layers
    }
}

/// A tensor that must be in the file.
struct Spec {
    name: String,
    shape: Vec<usize>,
}

/// Weight and bias of one layer.
fn specs(index: usize) -> [Spec; 2] {
    let (inputs, outputs) = (SIZES[index], SIZES[index + 1]);
    [
        Spec {
            name: format!("layer{index}.weight"),
            shape: vec![outputs, inputs],
        },
        Spec {
            name: format!("layer{index}.bias"),
            shape: vec![outputs],
        },
    ]
}

impl Spec {
    fn check(&self, values: &[f32]) -> Result<(), NetworkError> {
        if values.len() != self.shape.iter().product::<usize>() {
            return Err(NetworkError::Shape {
                name: self.name.clone(),
                found: format!("{} numbers", values.len()),
                expected: format!("F32 {:?}", self.shape),
            });
        }
        if values.iter().all(|value| value.is_finite()) {
            Ok(())
        } else {
            Err(NetworkError::NotFinite {
                name: self.name.clone(),
            })
        }
    }

    fn read(&self, file: &SafeTensors) -> Result<Vec<f32>, NetworkError> {
        let tensor = file.tensor(&self.name).map_err(NetworkError::Format)?;
        if tensor.dtype() != Dtype::F32 || tensor.shape() != self.shape {
            return Err(NetworkError::Shape {
                name: self.name.clone(),
                found: format!("{:?} {:?}", tensor.dtype(), tensor.shape()),
                expected: format!("F32 {:?}", self.shape),
            });
        }
        let (numbers, _) = tensor.data().as_chunks::<4>();
        Ok(numbers
            .iter()
            .map(|bytes| f32::from_le_bytes(*bytes))
            .collect())
    }
}

fn bytes(values: &[f32]) -> Vec<u8> {
    values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weights that differ from each other: −0.5 … 0.5 in steps of 1/16.
    fn network() -> Network {
        let numbers = |count: usize, offset: usize| -> Vec<f32> {
            (0..count)
                .map(|i| ((i * 7 + offset) % 17) as f32 / 16.0 - 0.5)
                .collect()
        };
        let layers = (0..LAYERS)
            .map(|i| Layer {
                weight: numbers(SIZES[i] * SIZES[i + 1], i),
                bias: numbers(SIZES[i + 1], i + 3),
            })
            .collect();
        Network::new(layers).expect("shapes are right")
    }

    #[test]
    fn weights_survive_serde() {
        let text = serde_json::to_string(&network()).expect("plain data");
        assert_eq!(
            serde_json::from_str::<Network>(&text).expect("own text"),
            network()
        );
    }

    #[test]
    fn prediction_follows_the_layers() {
        let mut layers: Vec<Layer> = (0..LAYERS)
            .map(|i| Layer {
                weight: vec![0.0; SIZES[i] * SIZES[i + 1]],
                bias: vec![0.0; SIZES[i + 1]],
            })
            .collect();
        // The first unit of each layer carries 2·path_y, the second its negative, which ReLU cuts.
        layers[0].weight[1] = 2.0;
        layers[0].weight[SIZES[0] + 1] = -2.0;
        for index in 1..LAYERS {
            layers[index].weight[0] = 1.0;
            layers[index].weight[SIZES[index] + 1] = 1.0;
        }
        layers[3].bias = vec![0.25, -0.5];
        let network = Network::new(layers).expect("shapes are right");
        assert_eq!(network.predict([9.0, 0.125, 9.0, 9.0]), [0.5, -0.5]);
        assert_eq!(network.predict([9.0, -0.125, 9.0, 9.0]), [0.25, -0.25]);
    }

    #[test]
    fn a_layer_too_few_is_refused() {
        let mut layers = network().layers().to_vec();
        layers.pop();
        assert!(matches!(
            Network::new(layers),
            Err(NetworkError::Shape { .. })
        ));
    }

    #[test]
    fn a_share_of_a_network_answers_that_share() {
        let inputs = [0.3, -0.1, 0.7, 0.2];
        let (whole, half) = (network(), network().scaled(0.5).expect("finite"));
        for (whole, half) in whole.predict(inputs).iter().zip(half.predict(inputs)) {
            assert!((0.5 * whole - half).abs() < 1e-5 * whole.abs().max(1.0));
        }
    }
}
