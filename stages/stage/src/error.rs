//! What can go wrong with keeping answers.

/// Why a run could not begin, or an answer not be kept. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum StageError {
    /// Another run works in the folder (exit code 75).
    #[error("begin: another run works in {dir}; try again when it has ended")]
    Busy {
        /// The folder.
        dir: String,
    },
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] durable::Error),
    /// Settings, input or output cannot be written as plain data: a mistake in the stage.
    #[error("encode {what} of stage `{stage}`: {why}")]
    Encode {
        /// The stage.
        stage: &'static str,
        /// Settings, input or output.
        what: &'static str,
        /// What the encoder said.
        why: String,
    },
    /// An output does not read back: a mistake in the stage.
    #[error("read back the output of stage `{stage}`: {why}")]
    Decode {
        /// The stage.
        stage: &'static str,
        /// What the decoder said.
        why: String,
    },
    /// An item stage gave more or fewer answers than it had items: a mistake in the stage.
    #[error("match the answers of stage `{stage}` to its items: {answers} for {items}")]
    Rows {
        /// The stage.
        stage: &'static str,
        /// Answers given.
        answers: usize,
        /// Items passed.
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
