//! What can go wrong.

use polars::error::PolarsError;
use world::WorldError;

/// Why a model could not be asked or judged. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum JudgeError {
    #[error("simulate strikes in a model's world: {0}")]
    World(#[from] WorldError),
    #[error("sum up the stop errors: {0}")]
    Table(#[from] PolarsError),
}
