//! What can keep logs from being ingested.

use std::io::Read;
use std::path::Path;

use logs::LogError;
use sha2::{Digest, Sha256};

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

/// SHA-256 of a file, in hex.
pub(crate) fn hash_file(path: &Path) -> Result<String, IngestError> {
    let io = |source| LogError::Io {
        log: path.display().to_string(),
        source,
    };
    // A pipe would be waited for without end.
    if !std::fs::metadata(path).map_err(io)?.is_file() {
        return Err(io(std::io::Error::other("it is no file")).into());
    }
    let mut file = std::fs::File::open(path).map_err(io)?;
    let mut hasher = Sha256::new();
    let mut buffer = vec![0; 256 << 10];
    loop {
        let read = file.read(&mut buffer).map_err(io)?;
        if read == 0 {
            return Ok(durable::hex(&hasher.finalize()));
        }
        hasher.update(&buffer[..read]);
    }
}
