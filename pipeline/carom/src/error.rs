//! How a command ends: what it has to print, or what went wrong.

use std::error::Error as StdError;
use std::path::Path;

use serde_json::Value;
use stage::{RunError, StageError};
use tables::TableError;

/// Any error of a crate below.
pub type Source = Box<dyn StdError + Send + Sync>;

/// Why a command did not do what it was asked. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum Error {
    #[error(transparent)]
    Input(Source),
    #[error(transparent)]
    Busy(Source),
    #[error("{0}")]
    Refused(String),
    #[error(transparent)]
    Failed(Source),
}

impl Error {
    /// Bad input, by an error of a crate below or a sentence of one's own.
    pub fn input(source: impl Into<Source>) -> Self {
        Self::Input(source.into())
    }

    /// Failed work.
    pub fn failed(source: impl Into<Source>) -> Self {
        Self::Failed(source.into())
    }

    /// A file that was given and could not be read.
    pub fn unreadable(path: &Path, source: &std::io::Error) -> Self {
        Self::input(format!("read {}: {source}", path.display()))
    }

    /// How the program ends.
    pub fn outcome(&self) -> Outcome {
        match self {
            Self::Input(_) => Outcome::BadInput,
            Self::Busy(_) => Outcome::Busy,
            Self::Refused(_) => Outcome::Refused,
            Self::Failed(_) => Outcome::Failed,
        }
    }
}

impl From<StageError> for Error {
    fn from(error: StageError) -> Self {
        match error {
            StageError::Busy { .. } => Self::Busy(error.into()),
            _ => Self::Failed(error.into()),
        }
    }
}

impl<E: StdError + Send + Sync + 'static> From<RunError<E>> for Error {
    fn from(error: RunError<E>) -> Self {
        match error {
            RunError::Stage(error) => Self::failed(error),
            RunError::Store(error) => error.into(),
        }
    }
}

impl From<TableError> for Error {
    fn from(error: TableError) -> Self {
        Self::failed(error)
    }
}

impl From<durable::Error> for Error {
    fn from(error: durable::Error) -> Self {
        Self::failed(error)
    }
}

/// How a command ended; the numbers are the exit codes of the contract, section 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Done.
    Done = 0,
    /// Failed.
    Failed = 1,
    /// Wrong usage or bad input.
    BadInput = 2,
    /// Done, but some input was rejected.
    Rejected = 3,
    /// Refused by a gate or a safety limit.
    Refused = 4,
    /// Another run works there; try again.
    Busy = 75,
}

/// A command's result, for machines and for people; `main` prints one of the two.
#[derive(Debug)]
pub struct Output {
    /// How the command ended.
    pub outcome: Outcome,
    /// For `--json`.
    pub json: Value,
    /// For people, ending in a line break.
    pub text: String,
}

impl Outcome {
    /// Done, with or without input that was rejected.
    pub fn of(is_clean: bool) -> Self {
        if is_clean { Self::Done } else { Self::Rejected }
    }
}

impl Output {
    /// Done, with nothing to complain of.
    pub fn done(json: Value, text: String) -> Self {
        Self::ended(Outcome::Done, json, text)
    }

    /// Ended otherwise.
    pub fn ended(outcome: Outcome, json: Value, text: String) -> Self {
        Self {
            outcome,
            json,
            text,
        }
    }
}

pub fn to_json<T: serde::Serialize>(value: &T) -> Result<Value, Error> {
    serde_json::to_value(value).map_err(Error::failed)
}
