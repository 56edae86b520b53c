//! Faults on purpose: each step that changes a disk asks here first.
//!
//! A fault is set for one thread. From the chosen step on every step of that thread fails, as if the program had
//! been killed there: nothing is cleaned up either.

use std::cell::Cell;
use std::io;

thread_local! {
    /// Steps that may still be taken; `None` where no fault is set.
    static LEFT: Cell<Option<u64>> = const { Cell::new(None) };
}

/// Runs `body` with `steps` steps allowed; tells what it returned and whether the fault struck.
pub fn after<T>(steps: u64, body: impl FnOnce() -> T) -> (T, bool) {
    LEFT.set(Some(steps));
    let result = body();
    let struck = dead();
    LEFT.set(None);
    (result, struck)
}

/// Whether the fault of this thread has struck.
pub fn dead() -> bool {
    LEFT.get() == Some(0)
}

/// One step: an error once the allowed steps are used up.
pub(crate) fn step() -> io::Result<()> {
    match LEFT.get() {
        None => Ok(()),
        Some(0 | 1) => {
            LEFT.set(Some(0));
            Err(io::Error::other("a fault set on purpose"))
        }
        Some(left) => {
            LEFT.set(Some(left - 1));
            Ok(())
        }
    }
}
