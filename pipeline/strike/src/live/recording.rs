//! What is held of the live topics: recent places, and messages for a log, both bounded.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use logs::write::Received;

use super::rest::Place;
use crate::epoch::Epoch;

/// Places are held for so long, and at most so many: a camera's 240 Hz, four times over.
const PLACES: Duration = Duration::from_secs(4);
const MOST_PLACES: usize = 4_000;
/// Time before a recording from which messages are part of it: the object's rest before the strike.
const BEFORE: Duration = Duration::from_secs(2);
/// Bytes of messages that are held, before a recording and in one: ten seconds of images at 25 MB/s.
pub(super) const MOST_BYTES: usize = 256 << 20;
/// Memory in bytes of a held message beside its data.
const OVERHEAD: usize = 128;

/// Recent places of the object.
#[derive(Debug, Default)]
pub(super) struct Places(VecDeque<Place>);

impl Places {
    pub(super) fn push(&mut self, place: Place) {
        while self.0.front().is_some_and(|first| {
            place.at.duration_since(first.at) > PLACES || self.0.len() >= MOST_PLACES
        }) {
            self.0.pop_front();
        }
        self.0.push_back(place);
    }

    /// The places from a moment on, in order of time.
    pub(super) fn since(&self, since: Instant) -> impl Iterator<Item = Place> {
        self.0
            .iter()
            .copied()
            .filter(move |place| place.at >= since)
    }
}

#[derive(Debug, Default)]
pub(super) struct Recording {
    messages: VecDeque<(Instant, Received)>,
    bytes: usize,
    is_on: bool,
    left_out: usize,
}

impl Recording {
    pub(super) fn start(&mut self) {
        self.is_on = true;
        self.left_out = 0;
    }

    pub(super) fn push(&mut self, at: Instant, message: Received) {
        let size = message.data.len() + OVERHEAD;
        if self.is_on && self.bytes + size > MOST_BYTES {
            self.left_out += 1;
            return;
        }
        while !self.is_on
            && let Some((first, _)) = self.messages.front()
            && (at.duration_since(*first) > BEFORE || self.bytes + size > MOST_BYTES)
        {
            if let Some((_, old)) = self.messages.pop_front() {
                self.bytes -= old.data.len() + OVERHEAD;
            }
        }
        self.bytes += size;
        self.messages.push_back((at, message));
    }

    /// All recorded messages, stamped by these clocks; and a note on what was left out.
    pub(super) fn take(&mut self, epoch: Epoch) -> (Vec<Received>, Option<String>) {
        let messages = std::mem::take(&mut self.messages);
        let left_out = (self.left_out > 0).then(|| {
            format!(
                "{} messages of the live topics are not in the log: at most {} MB are held",
                self.left_out,
                MOST_BYTES >> 20
            )
        });
        *self = Self::default();
        (
            messages
                .into_iter()
                .map(|(at, message)| Received {
                    log_time: epoch.stamp(at),
                    ..message
                })
                .collect(),
            left_out,
        )
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use logs::RawChannel;

    use super::*;

    fn message(bytes: usize) -> Received {
        Received {
            channel: Arc::new(RawChannel {
                id: 1,
                topic: "/a".into(),
                encoding: "json".into(),
                schema: String::new(),
                schema_encoding: String::new(),
                schema_data: Arc::from([]),
            }),
            log_time: 0,
            data: vec![0; bytes],
        }
    }

    #[test]
    fn two_seconds_are_held_before_a_recording_and_all_of_it_after() {
        let (mut recording, begun) = (Recording::default(), Instant::now());
        let at = |tenths: u64| begun + Duration::from_millis(100 * tenths);
        (0..100).for_each(|tenth| recording.push(at(tenth), message(10)));
        recording.start();
        (100..160).for_each(|tenth| recording.push(at(tenth), message(10)));
        let (messages, left_out) = recording.take(Epoch::now());
        assert_eq!((messages.len(), left_out), (81, None));
        assert_eq!(recording.take(Epoch::now()).0.len(), 0);
    }

    #[test]
    fn a_flood_is_held_within_the_limit_and_reported() {
        let (mut recording, now) = (Recording::default(), Instant::now());
        (0..40).for_each(|_| recording.push(now, message(8 << 20)));
        assert!(recording.bytes <= MOST_BYTES);
        recording.start();
        (0..40).for_each(|_| recording.push(now, message(8 << 20)));
        assert!(recording.bytes <= MOST_BYTES);
        assert!(
            recording
                .take(Epoch::now())
                .1
                .expect("a warning")
                .contains("not in the log")
        );
        let mut places = Places::default();
        for _ in 0..3 * MOST_PLACES {
            places.push(Place {
                at: now,
                point: values::Point::default(),
                yaw: None,
                z: None,
            });
        }
        assert_eq!(places.since(now).count(), MOST_PLACES);
    }
}
