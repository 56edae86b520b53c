//! What can go wrong with keeping answers.

/// Why a run could not begin, or an answer not be kept. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum StageError {
    #[error("begin: another run works in {dir}; try again when it has ended")]
    Busy { dir: String },
    #[error(transparent)]
    Io(#[from] durable::Error),
    #[error("encode {what} of stage `{stage}`: {why}")]
    Encode {
        stage: &'static str,
        what: &'static str,
        why: String,
    },
    #[error("read back the output of stage `{stage}`: {why}")]
    Decode { stage: &'static str, why: String },
    #[error("match the answers of stage `{stage}` to its items: {answers} for {items}")]
    Rows {
        stage: &'static str,
        answers: usize,
        items: usize,
    },
}

/// Why a stage gave no answer.
#[derive(Debug, thiserror::Error)]
pub enum RunError<E: std::error::Error + 'static> {
    /// The stage itself failed.
    #[error(transparent)]
    Stage(E),
    /// Its answer could not be kept.
    #[error(transparent)]
    Store(#[from] StageError),
}

impl<E: std::error::Error + 'static> From<durable::Error> for RunError<E> {
    fn from(error: durable::Error) -> Self {
        Self::Store(error.into())
    }
}
