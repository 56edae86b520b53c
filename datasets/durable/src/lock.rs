//! One writer at a time.

use std::fs::{File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};

use crate::Error;

/// Held while it lives. The system frees it when the program ends, however it ends: no lock is ever stale.
#[derive(Debug)]
pub struct Lock {
    file: File,
}

/// Why a lock was not had. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Another program holds it.
    #[error("lock {}: another run works in that folder; try again when it has ended", path.display())]
    Busy {
        /// The lock's file.
        path: PathBuf,
    },
    /// The lock's file could not be used.
    #[error(transparent)]
    Io(#[from] Error),
}

impl Lock {
    /// Takes the lock of that file, which is made where there is none, or reports at once that another holds it.
    pub fn acquire(path: &Path) -> Result<Self, LockError> {
        let file = OpenOptions::new()
            .create(true)
            .truncate(false)
            .write(true)
            .open(path)
            .map_err(|source| Error::new("open the lock", path, source))?;
        match file.try_lock() {
            Ok(()) => Ok(Self { file }),
            Err(TryLockError::WouldBlock) => Err(LockError::Busy { path: path.into() }),
            Err(TryLockError::Error(source)) => Err(Error::new("lock", path, source).into()),
        }
    }
}

impl Drop for Lock {
    /// Unlocks outright: closing alone would leave it to a program that is just being started from here, which holds copies of
    /// all open files until it runs.
    fn drop(&mut self) {
        // A lock that cannot be freed here is freed when the file is closed.
        let _ = self.file.unlock();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_holder_is_refused_and_a_third_succeeds_after_the_first() {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("lock");
        let first = Lock::acquire(&path).expect("free");
        assert!(matches!(Lock::acquire(&path), Err(LockError::Busy { .. })));
        drop(first);
        Lock::acquire(&path).expect("free again");
    }
}
