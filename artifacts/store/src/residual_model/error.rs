//! Why a file holds no residual model.

use crate::launch_map::LaunchMapError;
use crate::network::NetworkError;

/// Most networks whose mean is taken.
pub const MOST_NETWORKS: usize = 16;

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
