//! Faults on purpose: each step that changes a disk asks here first.
//!
//! A fault is set for one thread, or for the whole program. After a kill every step of that thread fails, as if the program had
//! ended there: nothing is cleaned up either. A failed step fails alone, as on a full disk, and the program lives on.

use std::cell::Cell;
use std::io;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

#[derive(Clone, Copy, PartialEq, Eq)]
enum Fault {
    Kill,
    Fail,
}

thread_local! {
    /// Steps until the fault strikes, none left once it has; `None` where no fault is set.
    static LEFT: Cell<Option<(u64, Fault)>> = const { Cell::new(None) };
}

/// Steps that the program took.
static TAKEN: AtomicU64 = AtomicU64::new(0);
/// At which of them what happens.
static EVERYWHERE: OnceLock<(u64, fn() -> io::Error)> = OnceLock::new();

/// Runs `body`, whose `steps`-th step and all after it fail; gives what it returned and whether it came so far.
pub fn after<T>(steps: u64, body: impl FnOnce() -> T) -> (T, bool) {
    with(steps, Fault::Kill, body)
}

/// Runs `body`, whose `steps`-th step alone fails for want of space; gives what it returned and whether it came so far.
pub fn once<T>(steps: u64, body: impl FnOnce() -> T) -> (T, bool) {
    with(steps, Fault::Fail, body)
}

/// At the `step`-th step of the whole program, on whatever thread, `fault` is called: it ends the program, or gives the error
/// that the step fails with. The first call counts.
pub fn everywhere(step: u64, fault: fn() -> io::Error) {
    // A second fault would find the first set.
    let _ = EVERYWHERE.set((step, fault));
}

/// Steps that the program took so far, on all threads.
pub fn taken() -> u64 {
    TAKEN.load(Ordering::Relaxed)
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

/// One step: an error where the fault strikes, after `torn` has done what a kill in its middle leaves.
pub(crate) fn step_torn(torn: impl FnOnce() -> io::Result<()>) -> io::Result<()> {
    let taken = TAKEN.fetch_add(1, Ordering::Relaxed) + 1;
    if let Some((_, fault)) = EVERYWHERE.get().filter(|(step, _)| *step == taken) {
        torn()?;
        return Err(fault());
    }
    let Some((left, fault)) = LEFT.get() else {
        return Ok(());
    };
    LEFT.set(Some((left.saturating_sub(1), fault)));
    let error = match (left, fault) {
        (0 | 1, Fault::Kill) => io::Error::other("a fault set on purpose"),
        (1, Fault::Fail) => io::ErrorKind::StorageFull.into(),
        _ => return Ok(()),
    };
    // The dead write nothing.
    if left > 0 {
        torn()?;
    }
    Err(error)
}

/// One step that nothing is left of where the fault strikes.
pub(crate) fn step() -> io::Result<()> {
    step_torn(|| Ok(()))
}
