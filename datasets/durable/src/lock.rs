//! One writer at a time, or several that agree.
//!
//! `flock`: over NFS the Linux client makes a byte-range lock of the whole file of it, which the server frees when the client's lease
//! ends (90 s by default) where its machine is gone.

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
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum LockError {
    #[error("lock {}: another run works in that folder; try again when it has ended", path.display())]
    Busy { path: PathBuf },
    #[error(transparent)]
    Io(#[from] Error),
}

impl Lock {
    /// Takes the lock of that file, which is made where there is none, or reports at once that another holds it.
    pub fn acquire(path: &Path) -> Result<Self, LockError> {
        Self::take(path, File::try_lock)
    }

    /// Shares the lock with others that share it: no one acquires it meanwhile.
    pub fn share(path: &Path) -> Result<Self, LockError> {
        Self::take(path, File::try_lock_shared)
    }

    fn take(
        path: &Path,
        lock: impl FnOnce(&File) -> Result<(), TryLockError>,
    ) -> Result<Self, LockError> {
        // NFS locks what is open for reading against writers, and what is open for writing against all.
        let file = OpenOptions::new()
            .create(true)
            .truncate(false)
            .read(true)
            .write(true)
            .open(path)
            .map_err(|source| Error::new("open the lock", path, source))?;
        match lock(&file) {
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
        let shared = [Lock::share(&path), Lock::share(&path)].map(|lock| lock.expect("shared"));
        assert!(matches!(Lock::acquire(&path), Err(LockError::Busy { .. })));
        drop(shared);
        let _whole = Lock::acquire(&path).expect("free once more");
        assert!(matches!(Lock::share(&path), Err(LockError::Busy { .. })));
    }
}
