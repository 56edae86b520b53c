//! What the threads of an emulator share.

use std::io::{ErrorKind, Read};
use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::Fault;
use crate::state::State;

/// The arm, and whether its threads end.
pub(crate) struct Shared {
    pub(crate) state: Mutex<State>,
    pub(crate) ends: AtomicBool,
}

impl Shared {
    pub(crate) fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The fault that was made.
    pub(crate) fn made(&self) -> Option<Fault> {
        self.lock().made.map(|(_, fault)| fault)
    }

    pub(crate) fn ends(&self) -> bool {
        self.ends.load(Ordering::Relaxed)
    }
}

/// Whether a connection that was made before the fault is cut by it.
pub(crate) fn is_cut(shared: &Shared, since: Instant) -> bool {
    let made = shared.lock().made;
    made.is_some_and(|(at, fault)| {
        matches!(fault, Fault::Reset | Fault::Gone | Fault::Rebooted) && since <= at
    })
}

/// Whether a connection for requests that was made before the fault is cut by it.
pub(crate) fn is_shut(shared: &Shared, since: Instant) -> bool {
    let made = shared.lock().made;
    let alone = made.is_some_and(|(at, fault)| fault == Fault::ControlClosed && since <= at);
    alone || is_cut(shared, since)
}

/// Whether nothing goes through a connection, which was made at that moment.
pub(crate) fn is_dead(shared: &Shared, since: Instant) -> bool {
    let made = shared.lock().made;
    made.is_some_and(|(at, fault)| {
        fault == Fault::Dead || (fault == Fault::HalfOpen && since <= at)
    })
}

/// Whether reports are held, to come all at once.
pub(crate) fn is_held(shared: &Shared) -> bool {
    const HELD: Duration = Duration::from_millis(300);
    let made = shared.lock().made;
    made.is_some_and(|(at, fault)| fault == Fault::Burst && at.elapsed() < HELD)
}

/// What came; none where the connection is over.
pub(crate) fn more(stream: &mut TcpStream) -> Option<Vec<u8>> {
    let mut bytes = [0; 2048];
    match stream.read(&mut bytes) {
        Ok(0) => None,
        Ok(count) => Some(bytes[..count].to_vec()),
        Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
            Some(Vec::new())
        }
        Err(_) => None,
    }
}
