//! One time for all that a strike's log joins: the arm's reports and the camera's messages are stamped by the same two clocks, read once.

use std::time::{Duration, Instant, SystemTime};

/// A clock that was set by more than this, in s, is reported. What keeps a clock in time by making it run slower or faster (NTP, PTP) does
/// that to both clocks alike (clock_gettime(2)): apart they come by a step alone, or by sleep.
const SET: f64 = 0.001;
/// Number of times that both clocks are read; the quickest reading counts, for between the two a program may lose its processor.
const READINGS: usize = 5;

/// This computer's two clocks at one moment. Stamps by it do not jump where the clock of the day is set.
#[derive(Clone, Copy, Debug)]
pub struct Epoch {
    day: u64,
    at: Instant,
    clock: fn() -> SystemTime,
}

impl Epoch {
    /// This computer's clock of the day and its monotonic clock as they stand now.
    pub fn now() -> Self {
        Self::by(SystemTime::now)
    }

    /// This computer's monotonic clock and `clock` as they stand now.
    pub(crate) fn by(clock: fn() -> SystemTime) -> Self {
        let reading = || {
            let before = Instant::now();
            let day = clock().duration_since(SystemTime::UNIX_EPOCH);
            let took = before.elapsed();
            let day = day.map_or(0, |since| since.as_nanos() as u64);
            let at = before + took / 2;
            (took, Self { day, at, clock })
        };
        let first = reading();
        let others = (1..READINGS).map(|_| reading());
        let (_, quickest) = others.fold(
            first,
            |one, other| if other.0 < one.0 { other } else { one },
        );
        quickest
    }

    /// This epoch's two clocks read again.
    pub(crate) fn anew(&self) -> Self {
        Self::by(self.clock)
    }

    /// The stamp of a moment before or after, in ns since 1970.
    pub fn stamp(&self, at: Instant) -> u64 {
        let nanos = |time: Duration| time.as_nanos() as u64;
        match at.checked_duration_since(self.at) {
            Some(later) => self.day.saturating_add(nanos(later)),
            None => self.day.saturating_sub(nanos(self.at.duration_since(at))),
        }
    }

    /// By how much, in s, the clock of the day was set since then, or went on while this computer slept.
    fn set_by(&self) -> Option<f64> {
        let now = self.anew();
        let by = (i128::from(now.day) - i128::from(self.stamp(now.at))) as f64 * 1e-9;
        (by.abs() > SET).then_some(by)
    }

    /// The warning for a person that the clock was set during a strike, where this epoch is that of its plan; none where it was not.
    pub fn was_set(&self) -> Option<String> {
        self.set_by().map(|by| {
            format!(
                "this computer's clock was set by {by:+.3} s since the strike was planned: what a camera stamps by it does not fit the \
                 arm's stamps"
            )
        })
    }

    /// The warning for a person that the clock was set between two strikes, where this epoch is the end of the first; none where it was not.
    pub(crate) fn was_set_between(&self) -> Option<String> {
        self.set_by().map(|by| {
            format!(
                "this computer's clock was set by {by:+.3} s since the strike before: a camera with a clock of its own is now off by as \
                 much; `carom check` measures by how much it is late"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_run_with_the_clock_that_nobody_sets() {
        let epoch = Epoch::now();
        let later = epoch.at + Duration::from_millis(1_500);
        assert_eq!(epoch.stamp(later) - epoch.day, 1_500_000_000);
        assert_eq!(epoch.was_set(), None);
        // Set an hour back after the strike began.
        let set = Epoch {
            day: epoch.day + 3_600_000_000_000,
            ..epoch
        };
        let said = set.was_set().expect("set");
        assert!(said.contains("-3600."), "{said}");
        // By little, however slow this machine is.
        let set = Epoch {
            day: epoch.day - 2_000_000,
            ..epoch
        };
        let said = set.was_set_between().expect("set");
        assert!(said.contains("+0.002 s"), "{said}");
    }
}
