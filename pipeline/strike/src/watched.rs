//! A strike that a camera watches: the object is looked at before the tip goes down and before it strikes, and until it rests again.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use logs::write::Received;

use crate::Plan;
use crate::live::{Live, LiveError, Resting};
use crate::robot::arm::Look;

/// The object is waited for so long to be seen at rest: after a strike, and after one that was not finished.
const AFTER: Duration = Duration::from_secs(15);
const AFTER_FAILURE: Duration = Duration::from_secs(2);

/// An object that was seen at rest, and is to be struck there.
#[derive(Debug)]
pub struct Watched {
    live: Arc<Live>,
    rest: Resting,
    begun: Arc<Mutex<Option<Instant>>>,
}

/// What the camera saw of a strike.
#[derive(Debug)]
pub struct Seen {
    /// Where the object came to rest.
    pub rest: Result<Resting, LiveError>,
    /// All messages, in order of time.
    pub received: Vec<Received>,
    /// What was left out of them, for want of memory or of one clock.
    pub left_out: Option<String>,
}

impl Watched {
    /// Of an object that was seen at rest there.
    pub fn new(live: Arc<Live>, rest: Resting) -> Self {
        Self {
            live,
            rest,
            begun: Arc::default(),
        }
    }

    /// Looks whether it still lies there. From the last look on everything is recorded.
    pub fn look(&self) -> impl FnMut(Look) -> Result<(), String> + Send + use<> {
        let (live, rest, begun) = (self.live.clone(), self.rest, self.begun.clone());
        move |when| {
            live.is_still(&rest)
                .map_err(|error| format!("failed to {error}"))?;
            if when == Look::BeforeStrike {
                live.record();
                *begun.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
            }
            Ok(())
        }
    }

    /// Waits until the object rests again; none where the strike was never looked at last. `is_struck` says that the strike was made as
    /// planned; `is_over` ends the waiting too.
    pub fn ended(&self, plan: &Plan, is_struck: bool, is_over: &AtomicBool) -> Option<Seen> {
        let begun = *self.begun.lock().unwrap_or_else(PoisonError::into_inner);
        let patience = if is_struck { AFTER } else { AFTER_FAILURE };
        let rest = self.live.wait_for_stop(begun?, patience, is_over);
        let (mut received, mut left_out) = self.live.recorded(plan.epoch());
        // Stamps of two clocks in one log would be a strike that never was.
        if let Some(set) = plan.epoch().was_set() {
            received.clear();
            left_out = Some(format!("{set}: they are left out of its log"));
        }
        Some(Seen {
            rest,
            received,
            left_out,
        })
    }
}
