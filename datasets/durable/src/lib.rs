//! Files that are whole or absent, whatever stops the program that writes them.
//!
//! A file is written aside under the name `.NAME.partial`, synced, renamed over its place, and its folder synced
//! (rename(2) is atomic; the order is that of "Files are hard", Pillai et al., OSDI 2014). A writer killed at any
//! point leaves the old file or the new one, and at most one `.partial` file, which the next writer of that name
//! overwrites and [`sweep`] removes. Writers of one folder hold a [`Lock`].
//!
//! [`faults`] makes any of these steps fail, for tests that loop over all of them.

mod aside;
pub mod faults;
mod hash;
mod lock;
mod write;

pub use aside::Aside;
pub use hash::{hex, sha256};
pub use lock::{Lock, LockError};
pub use write::{
    Output, append, create_dir, is_partial, remove_dir, rename, sweep, sync_dir, write, write_as,
    write_bytes,
};

use std::path::{Path, PathBuf};

/// A step on a file failed; its text completes "failed to …".
#[derive(Debug, thiserror::Error)]
#[error("{action} {}: {source}{}", path.display(), hint(source))]
pub struct Error {
    /// What was tried, such as "write".
    pub action: &'static str,
    /// The file or folder.
    pub path: PathBuf,
    /// What the system said.
    pub source: std::io::Error,
}

impl Error {
    /// The error of trying `action` on `path`.
    pub fn new(action: &'static str, path: &Path, source: std::io::Error) -> Self {
        Self {
            action,
            path: path.to_path_buf(),
            source,
        }
    }
}

fn hint(source: &std::io::Error) -> &'static str {
    use std::io::ErrorKind;
    match source.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "; free some space and run again, nothing is half-written"
        }
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "; give a folder that may be written"
        }
        _ => "",
    }
}
