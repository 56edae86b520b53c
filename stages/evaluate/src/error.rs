//! What can go wrong.

use polars::error::PolarsError;
use world::WorldError;

/// Why models could not be judged. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum EvaluateError {
    /// A model's world does not compile.
    #[error("evaluate in a model's world: {0}")]
    World(#[from] WorldError),
    /// Two models have one name.
    #[error("evaluate: the model `{model}` is given twice")]
    Twice {
        /// The name.
        model: String,
    },
    /// The table of errors could not be summed up.
    #[error("sum up the stop errors: {0}")]
    Table(#[from] PolarsError),
}
