//! Faults on purpose: each step that changes a disk asks here first.
//!
//! A fault is set for one thread. After a kill every step of that thread fails, as if the program had ended there: nothing
//! is cleaned up either. A failed step fails alone, as on a full disk, and the program lives on.

use std::cell::Cell;
use std::io;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Fault {
    Kill,
    Fail,
}

thread_local! {
    /// Steps until the fault strikes, none left once it has; `None` where no fault is set.
    static LEFT: Cell<Option<(u64, Fault)>> = const { Cell::new(None) };
}

/// Runs `body`, whose `steps`-th step and all after it fail; tells what it returned and whether it came so far.
pub fn after<T>(steps: u64, body: impl FnOnce() -> T) -> (T, bool) {
    with(steps, Fault::Kill, body)
}

/// Runs `body`, whose `steps`-th step alone fails for want of space; tells what it returned and whether it came so far.
pub fn once<T>(steps: u64, body: impl FnOnce() -> T) -> (T, bool) {
    with(steps, Fault::Fail, body)
}

fn with<T>(steps: u64, fault: Fault, body: impl FnOnce() -> T) -> (T, bool) {
    LEFT.set(Some((steps.max(1), fault)));
    let result = body();
    let has_struck = matches!(LEFT.get(), Some((0, _)));
    LEFT.set(None);
    (result, has_struck)
}

/// Whether this thread counts as killed.
pub fn dead() -> bool {
    LEFT.get() == Some((0, Fault::Kill))
}

/// One step: an error where the fault strikes.
pub(crate) fn step() -> io::Result<()> {
    let Some((left, fault)) = LEFT.get() else {
        return Ok(());
    };
    LEFT.set(Some((left.saturating_sub(1), fault)));
    match (left, fault) {
        (0 | 1, Fault::Kill) => Err(io::Error::other("a fault set on purpose")),
        (1, Fault::Fail) => Err(io::ErrorKind::StorageFull.into()),
        _ => Ok(()),
    }
}
