//! Live topics: where the camera sees the object now, and a recording of what it saw.
//!
//! A server of the Foxglove WebSocket protocol (ROS 2's `foxglove_bridge`, or any server of Foxglove's SDK) is listened to on a
//! thread of its own. Of its topics the rig file's centroid, pose and image are subscribed to; places are read by the decoder that
//! reads logs, and every message is kept as it came for the log of the strike. Nothing that a server sends is believed: what is
//! held is bounded, and a message that makes no sense is reported.

mod channels;
mod connection;
mod error;
mod protocol;
mod recording;
mod rest;
mod seen;
mod still;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant, SystemTime};

use channels::Role;
use connection::Connection;
use logs::write::Received;
use recording::MOST_BYTES;
use rest::{FRESH, resting};
use seen::{CLOCK, Seen};
use still::{Sentry, as_before, lifted};
use tungstenite::Message;
use values::Rig;

use crate::epoch::Epoch;
use crate::robot::arm::start;

pub use error::LiveError;
pub use rest::Resting;
pub use seen::{ServerMessage, read_messages};

/// Time after connecting within which topics are advertised.
const TOPICS: Duration = Duration::from_secs(5);
/// How long the object must be seen at one place to be at rest.
const REST: Duration = Duration::from_millis(500);
/// How long after a strike the object is watched at its new place: more than the ingestion of logs takes a stop from.
const REST_AFTER: Duration = Duration::from_millis(800);
/// Greatest size in bytes of a strike's messages without images.
const PLACES: u64 = 8 << 20;
/// Time between two looks at what is waited for.
const TICK: Duration = Duration::from_millis(20);
/// Time between two looks for the camera's next place.
const FRAME: Duration = Duration::from_millis(2);

/// The live topics of a server.
#[derive(Debug)]
pub struct Live {
    url: String,
    rig: Rig,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Shared {
    seen: Mutex<Seen>,
    ends: AtomicBool,
}

impl Live {
    /// Connects to `ws://HOST:PORT`, and waits until the object's topic is there.
    pub fn connect(url: &str, rig: &Rig) -> Result<Self, LiveError> {
        let connection = Connection::open(url)?;
        let shared = Arc::new(Shared {
            seen: Mutex::new(Seen::new(&rig.topics)),
            ends: AtomicBool::new(false),
        });
        let reader = shared.clone();
        let thread =
            start("live-topics", move || listen(&reader, connection)).map_err(|error| {
                LiveError::Connection {
                    url: url.into(),
                    why: error.to_string(),
                }
            })?;
        let live = Self {
            url: url.into(),
            rig: rig.clone(),
            shared,
            thread: Some(thread),
        };
        live.wait_for_topic()?;
        Ok(live)
    }

    fn wait_for_topic(&self) -> Result<(), LiveError> {
        let until = Instant::now() + TOPICS;
        loop {
            {
                let seen = self.shared.lock();
                if let Some(fault) = &seen.fault {
                    return Err(fault.clone());
                }
                if seen.channels.object().is_some() {
                    return Ok(());
                }
                if Instant::now() > until {
                    return Err(LiveError::NoTopic {
                        url: self.url.clone(),
                        centroid: self.rig.topics.centroid.name.clone(),
                        pose: self.rig.topics.pose.topic.name.clone(),
                        found: seen.channels.names(),
                    });
                }
            }
            thread::sleep(TICK);
        }
    }

    /// Where the object rests now, on the table: no higher, by half of its height, than the lowest place where it was seen at rest. Errors
    /// with what is seen in place of that.
    pub fn at_rest(&self) -> Result<Resting, LiveError> {
        let rest = self.judge(REST, Instant::now() - 2 * REST)?;
        let Some(z) = rest.z else { return Ok(rest) };
        let mut seen = self.shared.lock();
        let lowest = seen.lowest.map_or(z, |lowest| lowest.min(z));
        seen.lowest = Some(lowest);
        if z - lowest > lifted(&self.rig) {
            return Err(LiveError::NotAtRest(format!(
                "the camera sees it {:.1} mm higher than where it was seen at rest before: it is held, or lies on something",
                (z - lowest) * 1e3
            )));
        }
        Ok(rest)
    }

    /// Waits until the object rests on the table, for `patience` at the most, and gives where. `is_over` ends the waiting too, as from a signal's
    /// handler. Errors with what is seen in place of rest.
    pub fn wait_for_rest(
        &self,
        patience: Duration,
        is_over: &AtomicBool,
    ) -> Result<Resting, LiveError> {
        self.wait(patience, is_over, || self.at_rest())
    }

    /// Checks that the object rests where it did, within the camera's noise and 3 mm, and what is not round as it did, within 3°: by a place that
    /// comes from now on, for what was taken away a moment ago is seen no more.
    pub fn is_still(&self, before: &Resting) -> Result<(), LiveError> {
        self.wait_for_place()?;
        as_before(&self.rig, before, &self.at_rest()?).map_err(LiveError::NotAtRest)
    }

    /// Tells, from the thread that receives the camera, when a message came that shows the object elsewhere than it was seen at rest, and
    /// how; until what was recorded is taken.
    pub fn watch(&self, before: Resting, moved: impl FnMut(Instant, &str) + Send + 'static) {
        let sentry = Sentry::new(&self.rig, before, moved);
        self.shared.lock().sentry = Some(sentry);
    }

    /// Greatest size in bytes that the messages of a strike may come to.
    pub fn room(&self) -> u64 {
        let images = self.shared.lock().channels.has(Role::Image);
        PLACES + if images { MOST_BYTES as u64 } else { 0 }
    }

    /// Keeps every message from two seconds ago on.
    pub fn record(&self) {
        self.shared.lock().recording.start();
    }

    /// Where the object comes to rest after a strike that began at `since`.
    pub fn wait_for_stop(
        &self,
        since: Instant,
        patience: Duration,
        is_over: &AtomicBool,
    ) -> Result<Resting, LiveError> {
        self.wait(patience, is_over, || self.judge(REST_AFTER, since))
    }

    /// What was recorded, in order of time and stamped by these clocks; the recording ends. Also whether something was left out, for want
    /// of memory.
    pub fn recorded(&self, epoch: Epoch) -> (Vec<Received>, Option<String>) {
        let mut seen = self.shared.lock();
        seen.sentry = None;
        seen.recording.take(epoch)
    }

    fn wait(
        &self,
        patience: Duration,
        is_over: &AtomicBool,
        look: impl Fn() -> Result<Resting, LiveError>,
    ) -> Result<Resting, LiveError> {
        let until = Instant::now() + patience;
        loop {
            match look() {
                Err(LiveError::NotAtRest(_))
                    if Instant::now() < until && !is_over.load(Ordering::Relaxed) => {}
                found => return found,
            }
            thread::sleep(TICK);
        }
    }

    /// Waits until the camera sees the object once more.
    fn wait_for_place(&self) -> Result<(), LiveError> {
        let asked = Instant::now();
        loop {
            let seen = self.shared.lock();
            if let Some(fault) = &seen.fault {
                return Err(fault.clone());
            }
            if seen.places.since(asked).next().is_some() {
                return Ok(());
            }
            if asked.elapsed() > FRESH {
                let why = format!("the camera has not seen it for {} ms", FRESH.as_millis());
                return Err(seen.not_at_rest(why));
            }
            drop(seen);
            thread::sleep(FRAME);
        }
    }

    /// Where the object rests, judged by the places since a moment over a window.
    fn judge(&self, window: Duration, since: Instant) -> Result<Resting, LiveError> {
        let seen = self.shared.lock();
        if let Some(fault) = &seen.fault {
            return Err(fault.clone());
        }
        let places = seen.places.since(since);
        let found = resting(places, Instant::now(), window, self.rig.camera.noise);
        let found = found.map_err(|why| seen.not_at_rest(why))?;
        let is_box = !self.rig.object.shape().is_round();
        if is_box && found.yaw.is_none() && seen.channels.has(Role::Pose) {
            let why = "its pose has not come all along, which says how the box is turned";
            return Err(seen.not_at_rest(why.into()));
        }
        match seen.behind {
            Some(behind) if behind.abs() > CLOCK => Err(LiveError::NotAtRest(format!(
                "its stamps are {:.1} s {} this computer's clock, and a log joins both: set the clocks alike (NTP, PTP)",
                behind.abs(),
                if behind > 0.0 { "behind" } else { "ahead of" }
            ))),
            _ => Ok(found),
        }
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.shared.ends.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // It ends within a tick of its socket; that it panicked matters no more.
            let _ = thread.join();
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Seen> {
        self.seen.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Reads until the connection ends, or nobody listens any more.
fn listen(shared: &Shared, mut connection: Connection) {
    while !shared.ends.load(Ordering::Relaxed) {
        let taken = connection
            .read()
            .and_then(|message| take(shared, &mut connection, message));
        let mut seen = shared.lock();
        if let Err(fault) = taken {
            seen.ends(fault);
            return;
        }
        if let Some(sentry) = &mut seen.sentry {
            sentry.waits(Instant::now());
        }
    }
}

/// A message of the server, answered with what it asks for.
fn take(
    shared: &Shared,
    connection: &mut Connection,
    message: Option<Message>,
) -> Result<(), LiveError> {
    match message {
        Some(Message::Text(text)) => {
            let answers = shared.lock().control(text.as_str());
            for answer in answers.map_err(|why| connection.wrong(why))? {
                connection.send(answer)?;
            }
        }
        Some(Message::Binary(frame)) => {
            let log_time = SystemTime::now()
                .duration_since(SystemTime::UNIX_EPOCH)
                .map_or(0, |since| since.as_nanos() as u64);
            let taken = shared.lock().data(&frame, Instant::now(), log_time);
            taken.map_err(|why| connection.wrong(why))?;
        }
        _ => {}
    }
    Ok(())
}
