//! Why a file holds no residual model.

use crate::launch_map::LaunchMapError;
use crate::network::NetworkError;

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
