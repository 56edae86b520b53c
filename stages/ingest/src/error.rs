//! What can keep logs from being ingested.

use std::path::Path;

use logs::LogError;

/// Why a log could not be ingested; each text completes "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum IngestError {
    /// The log could not be read or does not hold what the rig file says.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The log's content changed while it was ingested.
    #[error("ingest log {log}: its content changes; wait until it is recorded, then run again")]
    Changed {
        /// The file.
        log: String,
    },
}

impl IngestError {
    /// Whether it is the error of this log, that its content changed.
    pub fn is_of(&self, path: &Path) -> bool {
        matches!(self, Self::Changed { log } if *log == path.display().to_string())
    }
}
