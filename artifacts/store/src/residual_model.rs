//! What is added to a world's command: one of two kinds, in one file.
//!
//! A *launch map* says what the arm delivers beside the world, as a function of the command ([`LaunchMap`]). *Networks* say what to
//! add to the world's command for a path (paper, section 3.4): the mean of a few of them, each trained on other strikes.

use std::sync::Arc;

use safetensors::SafeTensors;
use safetensors::tensor::{Dtype, TensorView};
use serde::{Deserialize, Serialize};
use values::{Command, Point, Rig};
use world::{Simulator, World, WorldError};

use crate::launch_map::{FEATURES, LaunchMap, LaunchMapError, Parts, SmoothMap};
use crate::network::{Network, NetworkError};

/// Most networks whose mean is taken.
pub const MOST_NETWORKS: usize = 16;

/// What is added to a world's command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ResidualModel {
    /// What the arm delivers beside the world.
    Launch(LaunchMap),
    /// What to add to the world's command.
    Networks(Networks),
}

/// Networks whose answers are averaged: one at least, [`MOST_NETWORKS`] at most.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<Network>", into = "Vec<Network>")]
pub struct Networks(Vec<Network>);

/// Why a file holds no residual model. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum ResidualModelError {
    /// Of a network.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// Of a launch map.
    #[error(transparent)]
    LaunchMap(#[from] LaunchMapError),
    /// Other than from one to sixteen networks.
    #[error(
        "read the residual's weights: they are of {found} networks, there must be 1 to {MOST_NETWORKS}"
    )]
    Count {
        /// How many.
        found: usize,
    },
}

impl ResidualModel {
    /// The world in which this residual model plans and predicts: with a launch map the arm delivers what that says. Errors if the
    /// world does not compile.
    pub fn simulator(
        rig: &Rig,
        world: &World,
        residual: Option<&Self>,
    ) -> Result<Simulator, WorldError> {
        let simulator = Simulator::new(rig, world)?;
        Ok(match residual {
            Some(Self::Launch(map)) => simulator.with_delivery(Arc::new(map.clone())),
            Some(Self::Networks(_)) | None => simulator,
        })
    }

    /// Its networks; none for a launch map, which acts within the world ([`ResidualModel::simulator`]).
    pub fn networks(&self) -> Option<&Networks> {
        match self {
            Self::Launch(_) => None,
            Self::Networks(networks) => Some(networks),
        }
    }

    /// What it adds to the world's command for a path (m): speed in m/s and angle in rad. Of a launch map, what the arm delivers
    /// otherwise at the command `sent`, with its sign turned: that much more has to be sent.
    pub fn added(&self, path: Point, simulated: Command, sent: Command) -> [f64; 2] {
        match self {
            Self::Launch(map) => {
                let offset = map.offset(sent);
                [sent.speed * (1.0 - offset.speed.exp()), -offset.angle]
            }
            Self::Networks(networks) => {
                networks.predict([path.x, path.y, simulated.speed, simulated.angle])
            }
        }
    }

    /// The content of `residual.safetensors`. The same model always gives the same bytes.
    pub fn to_safetensors(&self) -> Vec<u8> {
        match self {
            Self::Networks(networks) => networks.to_safetensors(),
            Self::Launch(map) => map_to_safetensors(map),
        }
    }

    /// Reads what [`ResidualModel::to_safetensors`] wrote, of either kind; everything is checked.
    pub fn from_safetensors(bytes: &[u8]) -> Result<Self, ResidualModelError> {
        let file = SafeTensors::deserialize(bytes).map_err(NetworkError::Format)?;
        if file.names().iter().any(|name| name.starts_with("launch.")) {
            Ok(Self::Launch(map_from_safetensors(&file)?))
        } else {
            Ok(Self::Networks(Networks::from_safetensors(&file)?))
        }
    }
}

impl From<Network> for ResidualModel {
    fn from(network: Network) -> Self {
        Self::Networks(Networks(vec![network]))
    }
}

impl From<LaunchMap> for ResidualModel {
    fn from(map: LaunchMap) -> Self {
        Self::Launch(map)
    }
}

impl Networks {
    /// The mean of these; refuses none, and more than [`MOST_NETWORKS`].
    pub fn new(networks: Vec<Network>) -> Result<Self, ResidualModelError> {
        match networks.len() {
            1..=MOST_NETWORKS => Ok(Self(networks)),
            found => Err(ResidualModelError::Count { found }),
        }
    }

    /// What to add to the simulated command: the mean of the networks' answers ([`Network::predict`]).
    pub fn predict(&self, inputs: [f64; 4]) -> [f64; 2] {
        let answers = self.0.iter().map(|network| network.predict(inputs));
        let sum = answers.fold([0.0; 2], |sum, answer| {
            [sum[0] + answer[0], sum[1] + answer[1]]
        });
        sum.map(|sum| sum / self.0.len() as f64)
    }

    /// Each of them.
    pub fn each(&self) -> &[Network] {
        &self.0
    }

    /// A single network's tensors have the names that they had before there were several.
    fn prefix(&self, member: usize) -> String {
        prefix(member, self.0.len())
    }

    fn to_safetensors(&self) -> Vec<u8> {
        let tensors: Vec<_> = self
            .0
            .iter()
            .enumerate()
            .flat_map(|(member, network)| network.tensors(&self.prefix(member)))
            .collect();
        let views = tensors.iter().map(|(name, shape, data)| {
            let view = TensorView::new(Dtype::F32, shape.clone(), data);
            (name, view.expect("a network's shapes are checked"))
        });
        safetensors::serialize(views, None).expect("a header of a few tensors can be written")
    }

    fn from_safetensors(file: &SafeTensors) -> Result<Self, ResidualModelError> {
        let count = network_count(file);
        if !(1..=MOST_NETWORKS).contains(&count) {
            return Err(ResidualModelError::Count { found: count });
        }
        let prefixes: Vec<String> = (0..count).map(|member| prefix(member, count)).collect();
        Network::check_names(file, &prefixes)?;
        let networks = prefixes
            .iter()
            .map(|prefix| Network::from_tensors(file, prefix))
            .collect::<Result<_, _>>()?;
        Self::new(networks)
    }
}

fn prefix(member: usize, count: usize) -> String {
    if count == 1 {
        String::new()
    } else {
        format!("network{member:02}.")
    }
}

/// By the tensors that each network has one of.
fn network_count(file: &SafeTensors) -> usize {
    let names = file.names();
    let firsts = names
        .iter()
        .filter(|name| name.starts_with("network") && name.ends_with(".layer0.weight"));
    firsts.count().max(1)
}

impl TryFrom<Vec<Network>> for Networks {
    type Error = ResidualModelError;
    fn try_from(networks: Vec<Network>) -> Result<Self, ResidualModelError> {
        Self::new(networks)
    }
}

impl From<Networks> for Vec<Network> {
    fn from(networks: Networks) -> Self {
        networks.0
    }
}

/// Version of a launch map's tensors; raised when one changes its name or meaning.
const LAUNCH_VERSION: f64 = 2.0;
/// Its tensors, all f64, and their shapes.
const LAUNCH_TENSORS: [(&str, &[usize]); 11] = [
    ("launch.version", &[1]),
    ("launch.centre", &[2]),
    ("launch.half_width", &[2]),
    ("launch.speed.weights", &[FEATURES]),
    ("launch.speed.covariance", &[FEATURES, FEATURES]),
    ("launch.speed.prior", &[FEATURES]),
    ("launch.speed.scatter", &[1]),
    ("launch.angle.weights", &[FEATURES]),
    ("launch.angle.covariance", &[FEATURES, FEATURES]),
    ("launch.angle.prior", &[FEATURES]),
    ("launch.angle.scatter", &[1]),
];

fn map_to_safetensors(map: &LaunchMap) -> Vec<u8> {
    let Parts {
        centre,
        half_width,
        speed,
        angle,
    } = map.parts();
    let of = |map: &SmoothMap| {
        [
            map.weights.clone(),
            map.covariance.clone(),
            map.prior.clone(),
            vec![map.scatter],
        ]
    };
    let mut numbers = vec![vec![LAUNCH_VERSION], centre.to_vec(), half_width.to_vec()];
    numbers.extend(of(speed));
    numbers.extend(of(angle));
    let bytes: Vec<Vec<u8>> = numbers
        .iter()
        .map(|numbers| numbers.iter().flat_map(|x| x.to_le_bytes()).collect())
        .collect();
    let views = LAUNCH_TENSORS
        .iter()
        .zip(&bytes)
        .map(|((name, shape), data)| {
            let view = TensorView::new(Dtype::F64, shape.to_vec(), data);
            (*name, view.expect("a map's lengths are checked"))
        });
    safetensors::serialize(views, None).expect("a header of eleven tensors can be written")
}

fn map_from_safetensors(file: &SafeTensors) -> Result<LaunchMap, ResidualModelError> {
    let mut found: Vec<String> = file.names().into_iter().map(String::from).collect();
    let mut expected: Vec<String> = LAUNCH_TENSORS.map(|(name, _)| name.to_string()).to_vec();
    found.sort();
    expected.sort();
    if found != expected {
        return Err(NetworkError::Names {
            found: found.join(", "),
            expected: expected.join(", "),
        }
        .into());
    }
    let mut numbers = LAUNCH_TENSORS
        .iter()
        .map(|(name, shape)| read(file, name, shape))
        .collect::<Result<Vec<_>, _>>()?
        .into_iter();
    let mut next = || numbers.next().unwrap_or_default();
    if next() != [LAUNCH_VERSION] {
        return Err(LaunchMapError {
            name: "launch.version",
            why: "is another than this program reads",
        }
        .into());
    }
    let pair = |numbers: Vec<f64>| [numbers[0], numbers[1]];
    let (centre, half_width) = (pair(next()), pair(next()));
    let mut map = || {
        let (weights, covariance, prior) = (next(), next(), next());
        SmoothMap {
            weights,
            covariance,
            prior,
            scatter: next()[0],
        }
    };
    let parts = Parts {
        centre,
        half_width,
        speed: map(),
        angle: map(),
    };
    Ok(LaunchMap::new(parts)?)
}

fn read(file: &SafeTensors, name: &str, shape: &[usize]) -> Result<Vec<f64>, NetworkError> {
    let tensor = file.tensor(name).map_err(NetworkError::Format)?;
    if tensor.dtype() != Dtype::F64 || tensor.shape() != shape {
        return Err(NetworkError::Shape {
            name: name.into(),
            found: format!("{:?} {:?}", tensor.dtype(), tensor.shape()),
            expected: format!("F64 {shape:?}"),
        });
    }
    let (numbers, _) = tensor.data().as_chunks::<8>();
    Ok(numbers
        .iter()
        .map(|bytes| f64::from_le_bytes(*bytes))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::launch_map::{LINEAR, spectrum};
    use crate::network::{LAYERS, Layer, SIZES};

    /// Networks whose weights differ from each other: −0.5 … 0.5 in steps of 1/16.
    fn model(count: usize) -> ResidualModel {
        let numbers = |count: usize, offset: usize| -> Vec<f32> {
            (0..count)
                .map(|i| ((i * 7 + offset) % 17) as f32 / 16.0 - 0.5)
                .collect()
        };
        let network = |member: usize| {
            let layers = (0..LAYERS)
                .map(|i| Layer {
                    weight: numbers(SIZES[i] * SIZES[i + 1], i + member),
                    bias: numbers(SIZES[i + 1], i + 3 + member),
                })
                .collect();
            Network::new(layers).expect("shapes are right")
        };
        let networks = Networks::new((0..count).map(network).collect());
        ResidualModel::Networks(networks.expect("a few"))
    }

    fn map() -> LaunchMap {
        let mut prior = vec![0.01; LINEAR];
        prior.extend(spectrum(0.02, [0.9, 0.7]));
        let part = |offset: usize| SmoothMap {
            weights: (0..FEATURES)
                .map(|i| ((i * 5 + offset) % 11) as f64 * 0.01 - 0.05)
                .collect(),
            covariance: (0..FEATURES * FEATURES)
                .map(|i| if i % (FEATURES + 1) == 0 { 1e-3 } else { 0.0 })
                .collect(),
            prior: prior.clone(),
            scatter: 0.001,
        };
        let parts = Parts {
            centre: [0.7, 0.0],
            half_width: [0.3, 0.8],
            speed: part(0),
            angle: part(4),
        };
        LaunchMap::new(parts).expect("a map")
    }

    #[test]
    fn weights_survive_the_file_bit_by_bit() {
        let bytes = model(1).to_safetensors();
        let read = ResidualModel::from_safetensors(&bytes).expect("own file");
        assert_eq!(read, model(1));
        assert_eq!(read.to_safetensors(), bytes);
    }

    #[test]
    fn damage_is_refused() {
        let bytes = model(1).to_safetensors();
        assert!(matches!(
            ResidualModel::from_safetensors(&bytes[..bytes.len() - 1]),
            Err(ResidualModelError::Network(NetworkError::Format(_)))
        ));
        assert!(matches!(
            ResidualModel::from_safetensors(&[]),
            Err(ResidualModelError::Network(NetworkError::Format(_)))
        ));
        let mut nan = bytes.clone();
        let end = nan.len();
        nan[end - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(matches!(
            ResidualModel::from_safetensors(&nan),
            Err(ResidualModelError::Network(NetworkError::NotFinite { .. }))
        ));
    }

    #[test]
    fn other_names_and_shapes_are_refused() {
        let data = [0u8; 16];
        let write = |name: &str, shape: Vec<usize>, dtype| {
            let view = TensorView::new(dtype, shape, &data).expect("16 bytes");
            safetensors::serialize([(name, view)], None).expect("one tensor")
        };
        let alone = write("layer0.weight", vec![4], Dtype::F32);
        assert!(matches!(
            ResidualModel::from_safetensors(&alone),
            Err(ResidualModelError::Network(NetworkError::Names { .. }))
        ));

        let whole = model(1).to_safetensors();
        let file = SafeTensors::deserialize(&whole).expect("own file");
        let swapped = file.tensors().into_iter().map(|(name, view)| {
            let shape = view.shape().iter().rev().copied().collect();
            (
                name,
                TensorView::new(Dtype::F32, shape, view.data()).expect("same count"),
            )
        });
        let transposed = safetensors::serialize(swapped, None).expect("eight tensors");
        assert!(matches!(
            ResidualModel::from_safetensors(&transposed),
            Err(ResidualModelError::Network(NetworkError::Shape { .. }))
        ));
    }

    #[test]
    fn either_kind_survives_the_file_and_answers_alike() {
        for model in [model(1), model(4), map().into()] {
            let bytes = model.to_safetensors();
            let read = ResidualModel::from_safetensors(&bytes).expect("own file");
            assert_eq!(read, model);
            assert_eq!(read.to_safetensors(), bytes);
            let text = serde_json::to_string(&model).expect("plain data");
            assert_eq!(
                serde_json::from_str::<ResidualModel>(&text).expect("own text"),
                model
            );
        }
    }

    #[test]
    fn several_networks_answer_with_their_mean() {
        let ResidualModel::Networks(networks) = model(3) else {
            panic!("networks")
        };
        let inputs = [0.3, -0.1, 0.7, 0.2];
        let mean = |i: usize| -> f64 {
            networks
                .each()
                .iter()
                .map(|one| one.predict(inputs)[i])
                .sum::<f64>()
                / 3.0
        };
        let answer = networks.predict(inputs);
        assert!((answer[0] - mean(0)).abs() < 1e-12 && (answer[1] - mean(1)).abs() < 1e-12);
        assert!(Networks::new(Vec::new()).is_err());
    }

    #[test]
    fn a_map_of_another_version_or_with_a_tensor_too_many_is_refused() {
        let bytes = ResidualModel::from(map()).to_safetensors();
        let file = SafeTensors::deserialize(&bytes).expect("own file");
        let version = (LAUNCH_VERSION + 1.0).to_le_bytes();
        let newer = file.tensors().into_iter().map(|(name, view)| {
            if name == "launch.version" {
                let view = TensorView::new(Dtype::F64, vec![1], &version).expect("8 bytes");
                (name, view)
            } else {
                (name, view)
            }
        });
        let newer = safetensors::serialize(newer, None).expect("eleven tensors");
        assert!(matches!(
            ResidualModel::from_safetensors(&newer),
            Err(ResidualModelError::LaunchMap(_))
        ));
        let extra = TensorView::new(Dtype::F64, vec![1], &version).expect("8 bytes");
        let more = file.tensors().into_iter().chain([("x".to_string(), extra)]);
        let more = safetensors::serialize(more, None).expect("twelve tensors");
        assert!(ResidualModel::from_safetensors(&more).is_err());
    }
}
