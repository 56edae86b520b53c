//! `--watch`: the object where the camera sees it, before and after the strike.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use strike::{Live, Received, Resting};
use values::{Point, Rig};

use super::show::Answer;
use super::{Args, Failure};

/// The object is waited for so long to be seen at rest: before a strike, after one, and after one that was not finished.
const BEFORE: Duration = Duration::from_secs(3);
const AFTER: Duration = Duration::from_secs(15);
const AFTER_FAILURE: Duration = Duration::from_secs(2);

/// The live topics, and when the strike began.
pub struct Watching {
    live: Arc<Live>,
    begun: Arc<Mutex<Option<Instant>>>,
}

impl Watching {
    /// Connects where `--watch` is given.
    pub fn open(args: &Args, rig: &Rig) -> Result<Option<Self>, Failure> {
        let Some(url) = &args.watch else {
            return Ok(None);
        };
        Ok(Some(Self {
            live: Arc::new(Live::connect(url, rig)?),
            begun: Arc::default(),
        }))
    }

    /// Where the object rests.
    pub fn rest(&self) -> Result<Resting, Failure> {
        Ok(self.live.wait_for_rest(BEFORE, &AtomicBool::new(false))?)
    }

    /// What is checked right before the strike: that the object still lies at a place (m). From then on everything is recorded.
    pub fn last_check(&self, place: Point) -> impl FnMut() -> Result<(), String> + Send + use<> {
        let (live, begun) = (self.live.clone(), self.begun.clone());
        move || {
            live.is_still_at(place)
                .map_err(|error| format!("failed to {error}"))?;
            live.record();
            *begun.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
            Ok(())
        }
    }

    /// Waits until the object rests again, and gives all messages. `is_over` says that the strike was made as planned.
    pub fn ended(&self, is_over: bool, answer: &mut Answer) -> Vec<Received> {
        let begun = *self.begun.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(begun) = begun else {
            return Vec::new();
        };
        let patience = if is_over { AFTER } else { AFTER_FAILURE };
        // A signal that comes now ends the program's motion, of which there is none any more, and not the recording.
        let rest = self
            .live
            .wait_for_stop(begun, patience, &AtomicBool::new(false));
        answer.came_to_rest(rest);
        let (received, left_out) = self.live.recorded();
        if let Some(left_out) = left_out {
            answer.warn(&left_out);
        }
        received
    }
}
