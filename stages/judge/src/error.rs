//! What can go wrong.

use polars::error::PolarsError;
use world::WorldError;

/// Why a model could not be asked or judged. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum JudgeError {
    /// Its world does not compile for the rig.
    #[error("simulate strikes in a model's world: {0}")]
    World(#[from] WorldError),
    /// The table of errors could not be summed up.
    #[error("sum up the stop errors: {0}")]
    Table(#[from] PolarsError),
}
