//! How fast a topic's stamps go by the recorder's clock.

use values::median;

/// Spans over which stamps and log times are compared, in ns of stamps; longer ones are pauses.
const LEAST: i64 = 500_000_000;
const MOST: i64 = 2_000_000_000;
/// Difference of a span's pace from the usual one from which a clock was set in it.
const SET: f64 = 0.1;
/// Least number of spans that tell a pace.
const SPANS: usize = 5;

/// Log time over stamps, span by span: what a recorder delays, and a clock that is set, is a span's alone.
#[derive(Clone, Default)]
pub(super) struct Pace {
    from: Option<(i64, i64)>,
    ratios: Vec<f64>,
}

impl Pace {
    /// Takes a message's stamp and its log time, both in ns.
    pub(super) fn take(&mut self, stamp: i64, log_time: i64) {
        let (begun, logged) = *self.from.get_or_insert((stamp, log_time));
        let (by_stamps, by_log) = (stamp.saturating_sub(begun), log_time.saturating_sub(logged));
        if (LEAST..=MOST).contains(&by_stamps) {
            self.ratios.push(by_log as f64 / by_stamps as f64);
        }
        if !(0..LEAST).contains(&by_stamps) {
            self.from = Some((stamp, log_time));
        }
    }

    /// Seconds of log time that pass in one of stamps, and its standard error; none where few spans tell. A span in which a clock was set is none.
    pub(super) fn measured(&self) -> Option<[f64; 2]> {
        let middle = median(self.ratios.clone())?;
        let mut ratios = self.ratios.clone();
        ratios.retain(|ratio| (ratio - middle).abs() < SET);
        let count = ratios.len() as f64;
        let mean = ratios.iter().sum::<f64>() / count;
        let squares: f64 = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum();
        let error = (squares / (count - 1.0).max(1.0) / count).sqrt();
        (ratios.len() >= SPANS).then_some([mean, error])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_that_run_slow_are_measured_and_a_clock_that_is_set_is_none_that_runs_wrong() {
        let pace = |stamp: &dyn Fn(i64) -> i64| {
            let mut pace = Pace::default();
            for i in 0..2400_i64 {
                let now = 16_666_667 * i;
                let late = (8e6 * (0.618_034 * i as f64).fract()) as i64;
                pace.take(stamp(now), now + late);
            }
            pace.measured().expect("forty seconds tell it")
        };
        let [ratio, error] = pace(&|now| now);
        assert!(
            (ratio - 1.0).abs() < 4.0 * error && error < 0.003,
            "{ratio} {error}"
        );
        let [ratio, _] = pace(&|now| now / 10 * 9);
        assert!((ratio - 1.0 / 0.9).abs() < 0.01, "{ratio}");
        let [ratio, _] = pace(&|now| {
            now - if now > 20_000_000_000 {
                3_600_000_000_000
            } else {
                0
            }
        });
        assert!((ratio - 1.0).abs() < 0.005, "{ratio}");
        assert_eq!(Pace::default().measured(), None);
    }
}
