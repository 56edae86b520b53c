//! Stamps, and samples in their order.
//!
//! Recorders write messages as they arrive, and two may overtake each other on the way. A few messages of a topic are held, so that
//! one that comes late takes its place; a stamp that lies further back, or stamps that stay back, are a clock that was set back.

use std::collections::VecDeque;

use logs::Sample;

/// Number of messages that are held; one may be overtaken by as many.
const HELD: usize = 8;
/// Number of messages in a row, earlier than one before them, that are no overtaking: the clock was set back.
const STAY_BACK: usize = 4;

/// What has a stamp.
pub(crate) trait Stamped {
    /// Nanoseconds on the log's clock.
    fn stamp(&self) -> i64;
}

impl Stamped for Sample {
    fn stamp(&self) -> i64 {
        self.stamp
    }
}

/// The last messages of one topic, by their stamps; equal stamps in the order in which they came.
#[derive(Debug)]
pub(crate) struct Ordered<T> {
    held: VecDeque<T>,
    /// The latest stamp that came, and the last one that was let go.
    latest: Option<i64>,
    released: Option<i64>,
    /// The last messages that came, each earlier than the latest stamp.
    behind: Vec<i64>,
}

impl<T> Default for Ordered<T> {
    fn default() -> Self {
        Self {
            held: VecDeque::new(),
            latest: None,
            released: None,
            behind: Vec::new(),
        }
    }
}

/// The clock was set back.
#[derive(Debug, PartialEq)]
pub(crate) struct ClockSetBack<T> {
    /// Nanoseconds by which it was set back.
    pub(crate) by: i64,
    /// The messages that came since, in order; none of them is held.
    pub(crate) since: Vec<T>,
}

impl<T: Stamped> Ordered<T> {
    /// Takes the next message; those that it lets go of are added to `out`.
    pub(crate) fn take(&mut self, message: T, out: &mut Vec<T>) -> Result<(), ClockSetBack<T>> {
        let stamp = message.stamp();
        let latest = self.latest.unwrap_or(stamp);
        if stamp < latest {
            self.behind.push(stamp);
        } else {
            self.behind.clear();
            self.latest = Some(stamp);
        }
        let is_gone = self.released.is_some_and(|released| stamp < released);
        if is_gone || self.behind.len() > STAY_BACK {
            return Err(self.set_back(latest.saturating_sub(stamp), message));
        }
        let place = self.held.partition_point(|held| held.stamp() <= stamp);
        self.held.insert(place, message);
        // Whether those behind were overtaken is not yet known: none of them goes before.
        while self.held.len() > HELD + self.behind.len() {
            let Some(first) = self.held.pop_front() else {
                break;
            };
            self.released = Some(first.stamp());
            out.push(first);
        }
        Ok(())
    }

    /// Takes out the messages that came since the clock was set back; the others stay.
    fn set_back(&mut self, by: i64, message: T) -> ClockSetBack<T> {
        self.behind.pop();
        let mut since = Vec::new();
        for stamp in std::mem::take(&mut self.behind) {
            let last = self.held.iter().rposition(|held| held.stamp() == stamp);
            since.extend(last.and_then(|at| self.held.remove(at)));
        }
        since.push(message);
        ClockSetBack { by, since }
    }

    /// Releases all that is held, in order; the next message may have any stamp.
    pub(crate) fn drain(&mut self) -> Vec<T> {
        let held = self.held.drain(..).collect();
        *self = Self::default();
        held
    }
}

/// Nanoseconds in seconds.
pub(crate) fn seconds(nanoseconds: i64) -> f64 {
    nanoseconds as f64 * 1e-9
}

/// Seconds from one stamp to another.
pub(crate) fn since(from: i64, to: i64) -> f64 {
    seconds(to.saturating_sub(from))
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Stamped for i64 {
        fn stamp(&self) -> i64 {
            *self
        }
    }

    /// What is let go of these stamps, and where the clock was set back.
    fn order(stamps: &[i64]) -> (Vec<i64>, Vec<i64>) {
        let (mut ordered, mut out, mut backs) = (Ordered::default(), Vec::new(), Vec::new());
        let mut next: VecDeque<i64> = stamps.iter().copied().collect();
        while let Some(stamp) = next.pop_front() {
            if let Err(ClockSetBack { by, since }) = ordered.take(stamp, &mut out) {
                backs.push(by);
                out.extend(ordered.drain());
                since.into_iter().rev().for_each(|s| next.push_front(s));
            }
        }
        out.extend(ordered.drain());
        (out, backs)
    }

    #[test]
    fn messages_that_were_overtaken_take_their_place() {
        let in_order: Vec<i64> = (0..40).map(|i| 10 * i).collect();
        for distance in 1..=HELD {
            let mut swapped = in_order.clone();
            let late = swapped.remove(15);
            swapped.insert(15 + distance, late);
            assert_eq!(order(&swapped), (in_order.clone(), vec![]), "{distance}");
        }
        let mut reversed = in_order.clone();
        reversed[10..14].reverse();
        assert_eq!(order(&reversed), (in_order, vec![]));
    }

    #[test]
    fn a_clock_that_is_set_back_is_reported_and_the_messages_before_and_after_are_kept_apart() {
        for back in [35, 55, 200, 100_000] {
            let before: Vec<i64> = (0..40).map(|i| 100_000 + 10 * i).collect();
            let after: Vec<i64> = (40..80).map(|i| 100_000 + 10 * i - back).collect();
            let all = [before, after].concat();
            let (out, backs) = order(&all);
            // Back by less than the messages that may be overtaken, it cannot be distinguished from overtaking.
            if back > 10 * STAY_BACK as i64 {
                assert_eq!((out, backs.len()), (all, 1), "{back}");
            }
        }
    }
}
