//! Networks whose answers are averaged, and their file.

use safetensors::SafeTensors;
use safetensors::tensor::{Dtype, TensorView};
use serde::{Deserialize, Serialize};

use crate::launch_map::LaunchMapError;
use crate::network::{Network, NetworkError};

/// Networks whose answers are averaged: one at least, [`MOST_NETWORKS`] at most.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<Network>", into = "Vec<Network>")]
pub struct Networks(pub(super) Vec<Network>);

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

    pub(super) fn to_safetensors(&self) -> Vec<u8> {
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

    pub(super) fn from_safetensors(file: &SafeTensors) -> Result<Self, ResidualModelError> {
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

/// Most networks whose mean is taken.
pub const MOST_NETWORKS: usize = 16;

/// Why a file holds no residual model. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum ResidualModelError {
    #[error(transparent)]
    Network(#[from] NetworkError),
    #[error(transparent)]
    LaunchMap(#[from] LaunchMapError),
    #[error(
        "read the residual's weights: they are of {found} networks, there must be 1 to {MOST_NETWORKS}"
    )]
    Count { found: usize },
}
