//! What can go wrong.

/// Why no residual model was trained. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum TrainError {
    /// Too few rows to learn from, or none to stop by.
    #[error(
        "train the residual: {train} rows to learn from and {validation} to stop by, it takes {least_train} and {least_validation}; log more strikes or use the world without a residual"
    )]
    TooFewRows {
        /// Rows of the split `train`.
        train: usize,
        /// Rows of the split `validation`.
        validation: usize,
        /// Rows of `train` that it takes.
        least_train: usize,
        /// Rows of `validation` that it takes.
        least_validation: usize,
    },
    /// A row that is no data.
    #[error("train the residual: the row of strike {strike_id} holds a number that is not finite")]
    NotFinite {
        /// The row's strike.
        strike_id: String,
    },
    /// A setting that cannot be.
    #[error("train the residual: setting `{name}` must be {must}")]
    Setting {
        /// Its name.
        name: &'static str,
        /// What it must be.
        must: &'static str,
    },
    /// Training ran off.
    #[error(
        "train the residual: the loss is no longer finite in epoch {epoch}; set a smaller `rate` than {rate}"
    )]
    Diverged {
        /// In which epoch, from 1.
        epoch: usize,
        /// The setting.
        rate: f64,
    },
}
