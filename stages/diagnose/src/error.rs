//! What can go wrong.

use world::WorldError;

/// Why there is no diagnosis. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum DiagnoseError {
    /// Too few to fit anything.
    #[error(
        "diagnose {strikes} strikes that may be used for it: at least {needed} are needed; log more strikes"
    )]
    TooFewStrikes {
        /// Strikes that may be used.
        strikes: usize,
        /// Strikes needed.
        needed: usize,
    },
    /// A ball rolls: no slide to look at.
    #[error("diagnose a ball: effects are identified from slides, and a ball rolls")]
    Rolls,
    /// The world without effects cannot be fitted to these strikes.
    #[error(
        "diagnose: the world without effects fits none of it ({why}); look at the logs and the rig file"
    )]
    NoFit {
        /// What went wrong.
        why: String,
    },
    /// The world could not be simulated.
    #[error(transparent)]
    World(#[from] WorldError),
}
