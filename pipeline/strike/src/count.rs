//! How often the embedded rig was struck from a folder: each strike is drawn with a scatter of its own, wherever its log goes.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;
use std::time::Duration;

use durable::{Lock, LockError};

use crate::log::{HIGHEST, highest};

const COUNT: &str = "struck";
const LOCK: &str = ".struck.lock";
/// Number of tries for the lock, and the pause between two: another executor holds it for a few milliseconds.
const TRIES: (u32, Duration) = (200, Duration::from_millis(10));

/// Takes the number of the next strike, from 0, for the embedded rig of this folder; it is not given again. Numbered logs in the
/// folder's `strikes` count too. Errors where the count cannot be kept.
pub fn take_number(folder: &Path) -> Result<usize, LockError> {
    let _lock = locked(&folder.join(LOCK))?;
    let path = folder.join(COUNT);
    let kept = match fs::read_to_string(&path) {
        Ok(text) => text.trim().parse().ok().filter(|count| *count <= HIGHEST),
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        Err(error) => return Err(durable::Error::new("read", &path, error).into()),
    };
    // A count that makes no sense is made anew from the logs.
    let number = kept.unwrap_or(0).max(highest(&folder.join("strikes")));
    durable::write_bytes(&path, format!("{}\n", number + 1).as_bytes())?;
    Ok(number)
}

/// Takes a lock that others hold for an instant only.
pub(crate) fn locked(path: &Path) -> Result<Lock, LockError> {
    let (tries, pause) = TRIES;
    for _ in 1..tries {
        match Lock::acquire(path) {
            Err(LockError::Busy { .. }) => std::thread::sleep(pause),
            taken => return taken,
        }
    }
    Lock::acquire(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_number_is_given_twice() {
        let dir = tempfile::tempdir().expect("folder");
        let take = || take_number(dir.path()).expect("counts");
        assert_eq!([take(), take()], [0, 1]);
        fs::create_dir(dir.path().join("strikes")).expect("folder");
        fs::write(dir.path().join("strikes/strike_000007.mcap"), "").expect("writes");
        assert_eq!([take(), take()], [7, 8]);
        fs::write(dir.path().join(COUNT), "99999999999999999999").expect("writes");
        assert_eq!(take(), 7);
    }

    #[test]
    fn executors_side_by_side_take_different_numbers() {
        let dir = tempfile::tempdir().expect("folder");
        let mut numbers: Vec<usize> = std::thread::scope(|scope| {
            let take = || scope.spawn(|| take_number(dir.path()).expect("counts"));
            let threads: Vec<_> = (0..8).map(|_| take()).collect();
            threads
                .into_iter()
                .map(|thread| thread.join().expect("ends"))
                .collect()
        });
        numbers.sort_unstable();
        assert_eq!(numbers, (0..8).collect::<Vec<_>>());
    }
}
