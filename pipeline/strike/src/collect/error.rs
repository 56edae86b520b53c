//! Why a collection ended.

use std::path::PathBuf;

use ingest::IngestError;

use crate::last_stop::NoMemory;
use crate::{LiveError, LogError, RobotError};

/// Why a collection ended early. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum CollectError {
    #[error(transparent)]
    Robot(#[from] RobotError),
    #[error(transparent)]
    Live(#[from] LiveError),
    #[error(
        "gather all strikes: it was interrupted by a signal; nothing moves, and the same command goes on"
    )]
    Interrupted,
    #[error(transparent)]
    Log(#[from] LogError),
    #[error(
        "{why}; the log of the last strike is whole, lies at {}, and counts once that is the folder of --out",
        path.display()
    )]
    Moved { path: PathBuf, why: LogError },
    #[error("read what was collected: {0}")]
    Collected(#[from] IngestError),
    #[error("gather into the folder: {0}")]
    Folder(#[from] durable::Error),
    #[error("gather into the folder: {0}")]
    Lock(#[from] durable::LockError),
    #[error(transparent)]
    NoMemory(#[from] NoMemory),
    #[error("choose a strike: {0}")]
    NoStrike(String),
    #[error("gather usable strikes: {0}")]
    Unmoved(&'static str),
    #[error(
        "gather usable strikes: {strikes} in a row are none, the last because {why}; look at the camera, the table and the topics"
    )]
    Useless { strikes: usize, why: String },
}
