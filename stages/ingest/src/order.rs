//! Stamps, and samples in their order.
//!
//! Recorders write messages as they arrive, and many may overtake each other on the way. The last half second of a topic is held, so that
//! one that comes late takes its place; a stamp that lies further back, or stamps that stay back among others that leave them no room, are a
//! clock that was set back.

use std::collections::VecDeque;

use logs::Sample;

/// Messages are held for this time, in ns by their stamps, and so many of them at the least and at the most.
const WINDOW: i64 = 500_000_000;
const HELD: usize = 8;
const MOST_HELD: usize = 4096;
/// Number of messages in a row, earlier than one before them, for which those held leave no room, that are no overtaking: the clock was set back.
const STAY_BACK: usize = 4;
/// Share of the usual interval between messages within which two leave each other no room.
const ROOM: f64 = 0.7;
/// Number of intervals that tell the usual one.
const INTERVALS: usize = 16;

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
    /// The last messages that came, each earlier than the latest stamp; and how many of them had no room.
    behind: Vec<i64>,
    crowded: usize,
    /// The last intervals between messages that were let go.
    intervals: VecDeque<i64>,
}

impl<T> Default for Ordered<T> {
    fn default() -> Self {
        Self {
            held: VecDeque::new(),
            latest: None,
            released: None,
            behind: Vec::new(),
            crowded: 0,
            intervals: VecDeque::new(),
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
        let place = self.held.partition_point(|held| held.stamp() <= stamp);
        if stamp < latest {
            self.behind.push(stamp);
            self.crowded += usize::from(!self.has_room(place, stamp));
        } else {
            self.behind.clear();
            self.crowded = 0;
            self.latest = Some(stamp);
        }
        let is_gone = self.released.is_some_and(|released| stamp < released);
        if is_gone || self.crowded > STAY_BACK {
            let by = latest.saturating_sub(self.behind[0]);
            return Err(self.set_back(by, message));
        }
        self.held.insert(place, message);
        // Whether those behind were overtaken is not yet known: none of them goes before.
        while self.behind.is_empty() && self.is_ripe(stamp) {
            let Some(first) = self.held.pop_front() else {
                break;
            };
            if let Some(last) = self.released.replace(first.stamp()) {
                self.intervals.push_back(first.stamp().saturating_sub(last));
            }
            if self.intervals.len() > INTERVALS {
                self.intervals.pop_front();
            }
            out.push(first);
        }
        Ok(())
    }

    /// Whether the first message that is held can be overtaken no more. Stamps that stand still are in no order.
    fn is_ripe(&self, latest: i64) -> bool {
        let age = |first: &T| latest.saturating_sub(first.stamp());
        let age = self.held.front().map_or(0, age);
        self.held.len() > HELD && (age > WINDOW || age == 0 || self.held.len() > MOST_HELD)
    }

    /// Whether the messages held leave room for one at this place among them: where some are missing that were overtaken.
    fn has_room(&self, place: usize, stamp: i64) -> bool {
        let mut intervals: Vec<i64> = self.intervals.iter().copied().collect();
        // The first ones tell less: of what is held many may be missing.
        let is_known = intervals.len() == INTERVALS;
        if !is_known {
            let pairs = self.held.iter().zip(self.held.iter().skip(1));
            intervals = pairs
                .map(|(a, b)| b.stamp().saturating_sub(a.stamp()))
                .collect();
        }
        intervals.sort_unstable();
        let usual = intervals.get(intervals.len() / if is_known { 2 } else { 4 });
        let usual = ROOM * usual.map_or(0.0, |interval| *interval as f64);
        let is_far =
            |other: Option<&T>| other.is_none_or(|o| o.stamp().abs_diff(stamp) as f64 > usual);
        is_far(self.held.get(place))
            && is_far(place.checked_sub(1).and_then(|at| self.held.get(at)))
    }

    /// Takes out the messages that came since the clock was set back; the others stay.
    fn set_back(&mut self, by: i64, message: T) -> ClockSetBack<T> {
        self.behind.pop();
        self.crowded = 0;
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

    /// Stamps in ns of messages at 100 Hz, from so many on.
    fn at_100_hz(numbers: std::ops::Range<i64>) -> Vec<i64> {
        numbers.map(|i| 10_000_000 * i).collect()
    }

    #[test]
    fn messages_that_were_overtaken_take_their_place() {
        let in_order = at_100_hz(0..200);
        for distance in 1..=40 {
            let mut swapped = in_order.clone();
            let late = swapped.remove(85);
            swapped.insert(85 + distance, late);
            assert_eq!(order(&swapped), (in_order.clone(), vec![]), "{distance}");
            // As many at once, in their order or not.
            let mut late: Vec<i64> = swapped.splice(80..80 + distance, []).collect();
            late.sort_unstable();
            swapped.splice(90..90, late.iter().copied());
            assert_eq!(order(&swapped).0, in_order, "{distance}");
        }
        // Each comes up to 0.4 s late; the first ones, too.
        for seed in 1..50_u64 {
            let late = |i: u64| (i * i * 7919 * seed + i * 104_729) % 400_000_000;
            let mut shuffled = in_order.clone();
            shuffled.sort_by_key(|stamp| stamp + late(*stamp as u64 / 10_000_000) as i64);
            assert_eq!(order(&shuffled), (in_order.clone(), vec![]), "{seed}");
        }
    }

    #[test]
    fn a_clock_that_is_set_back_is_reported_and_the_messages_before_and_after_are_kept_apart() {
        for back in [35, 55, 200, 480, 100_000] {
            let before = at_100_hz(100..200);
            let after = at_100_hz(200..400);
            let after: Vec<i64> = after.iter().map(|stamp| stamp - 1_000_000 * back).collect();
            let all = [before, after].concat();
            let (out, backs) = order(&all);
            // Back by less than the messages that may be overtaken, it cannot be distinguished from overtaking.
            if back > 10 * STAY_BACK as i64 {
                assert_eq!((out, backs.len()), (all, 1), "{back}");
            }
        }
    }
}
