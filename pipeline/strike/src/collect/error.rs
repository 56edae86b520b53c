//! Why a collection ended.

use std::path::PathBuf;

use ingest::IngestError;

use crate::last_stop::NoMemory;
use crate::{LiveError, LogError, RobotError};

/// Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum CollectError {
    /// The robot did not strike, or did not end a strike.
    #[error(transparent)]
    Robot(#[from] RobotError),
    /// The camera does not show where the object is.
    #[error(transparent)]
    Live(#[from] LiveError),
    /// A signal came while the object was waited for.
    #[error(
        "gather all strikes: it was interrupted by a signal; nothing moves, and the same command goes on"
    )]
    Interrupted,
    /// A strike could not be kept.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The log of a strike that was made could not be kept as it was to: something is wrong with the folder.
    #[error(
        "{why}; the log of the last strike is whole, lies at {}, and counts once that is the folder of --out",
        path.display()
    )]
    Moved {
        /// Where.
        path: PathBuf,
        /// Why.
        why: LogError,
    },
    /// A log in the folder cannot be read.
    #[error("read what was collected: {0}")]
    Collected(#[from] IngestError),
    /// The folder cannot be worked in.
    #[error("gather into the folder: {0}")]
    Folder(#[from] durable::Error),
    /// Another collection works in the folder.
    #[error("gather into the folder: {0}")]
    Lock(#[from] durable::LockError),
    /// Nowhere to keep where an arm's last strike left the object.
    #[error(transparent)]
    NoMemory(#[from] NoMemory),
    /// Nothing can be struck from where the object lies, or from anywhere.
    #[error("choose a strike: {0}")]
    NoStrike(String),
    /// The tip passed through the place of an object that was not moved.
    #[error("gather usable strikes: {0}")]
    Unmoved(&'static str),
    /// Strikes cannot be used.
    #[error(
        "gather usable strikes: {strikes} in a row are none, the last because {why}; look at the camera, the table and the topics"
    )]
    Useless {
        /// How many.
        strikes: usize,
        /// Why the last one is none.
        why: String,
    },
}
