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
    /// Nearly every object is pushed on its way, and what slides freely is too little to fit.
    #[error(
        "diagnose: in {pushed} strikes the object speeds up again after it slowed down, and of others there are only {strikes}, where {needed} are needed; look whether the arm goes on behind the object, or the table moves (a vibration), and log again"
    )]
    PushedAgain {
        /// Strikes that may be used.
        strikes: usize,
        /// Strikes left out.
        pushed: usize,
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
