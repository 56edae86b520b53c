//! What a command has to print.

use serde_json::Value;

use crate::Error;
use crate::error::Outcome;

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

impl Output {
    /// Done, with nothing to complain of.
    pub fn done(json: Value, text: String) -> Self {
        Self {
            outcome: Outcome::Done,
            json,
            text,
        }
    }
}

/// A result for machines.
pub fn to_json<T: serde::Serialize>(value: &T) -> Result<Value, Error> {
    serde_json::to_value(value).map_err(Error::failed)
}
