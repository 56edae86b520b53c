//! One time for all that a strike's log joins: the arm's reports and the camera's messages are stamped by the same two clocks, read once.

use std::time::{Duration, Instant, SystemTime};

/// A clock that was set by more than this, in s, in a strike is reported.
const SET: f64 = 0.005;

/// This computer's two clocks at one moment. Stamps by it do not jump where the clock of the day is set.
#[derive(Clone, Copy, Debug)]
pub struct Epoch {
    day: u64,
    at: Instant,
    clock: fn() -> SystemTime,
}

impl Epoch {
    /// As both stand now.
    pub fn now() -> Self {
        Self::by(SystemTime::now)
    }

    /// The same by another clock of the day.
    pub(crate) fn by(clock: fn() -> SystemTime) -> Self {
        let day = clock().duration_since(SystemTime::UNIX_EPOCH);
        Self {
            day: day.map_or(0, |since| since.as_nanos() as u64),
            at: Instant::now(),
            clock,
        }
    }

    /// The stamp of a moment before or after, in ns since 1970.
    pub fn stamp(&self, at: Instant) -> u64 {
        let nanos = |time: Duration| time.as_nanos() as u64;
        match at.checked_duration_since(self.at) {
            Some(later) => self.day.saturating_add(nanos(later)),
            None => self.day.saturating_sub(nanos(self.at.duration_since(at))),
        }
    }

    /// What a person is told where the clock of the day was set since then, by more than a slow adjustment, or went on while this computer
    /// slept.
    pub fn was_set(&self) -> Option<String> {
        let now = Self::by(self.clock);
        let by = (i128::from(now.day) - i128::from(self.stamp(now.at))) as f64 * 1e-9;
        (by.abs() > SET).then(|| {
            format!(
                "this computer's clock was set by {by:+.3} s since the strike was planned: what a camera stamps by it does not fit the \
                 arm's stamps"
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
    }
}
