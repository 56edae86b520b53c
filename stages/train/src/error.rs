//! What can go wrong.

/// Why no residual model was trained. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum TrainError {
    #[error(
        "train the residual: {train} rows to learn from and {validation} to stop by, it takes {least_train} and {least_validation}; log more strikes or use the world without a residual"
    )]
    TooFewRows {
        train: usize,
        validation: usize,
        least_train: usize,
        least_validation: usize,
    },
    #[error("train the residual: the row of strike {strike_id} holds a number that is not finite")]
    NotFinite { strike_id: String },
    #[error("train the residual: setting `{name}` must be {must}")]
    Setting {
        name: &'static str,
        must: &'static str,
    },
    #[error(
        "train the residual: the loss is no longer finite in epoch {epoch}; set a smaller `rate` than {rate}"
    )]
    Diverged { epoch: usize, rate: f64 },
}
