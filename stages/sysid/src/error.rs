//! What can go wrong.

use world::WorldError;

/// Why nothing was identified. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum SysidError {
    /// Fewer strikes than parameters need.
    #[error(
        "identify {parameters} parameters from {strikes} strikes: at least {needed} are needed; log more strikes"
    )]
    TooFewStrikes {
        /// Strikes that learn.
        strikes: usize,
        /// Parameters freed.
        parameters: usize,
        /// Strikes needed.
        needed: usize,
    },
    /// The world could not be simulated.
    #[error(transparent)]
    World(#[from] WorldError),
    /// The data do not determine the freed parameters at all.
    #[error("identify {names}: these strikes do not distinguish them; free fewer parameters")]
    Singular {
        /// The parameters freed.
        names: String,
    },
}
