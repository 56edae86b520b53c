//! Logs that could not be read.

use serde::{Deserialize, Serialize};

/// A log of which nothing could be read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LeftOut {
    pub log: String,
    /// Why; completes "failed to …".
    pub why: String,
}

impl LeftOut {
    pub fn sentence(&self) -> String {
        format!("{} is left out: failed to {}", self.log, self.why)
    }
}
