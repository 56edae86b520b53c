//! When to halve the rate and when to stop.

use crate::Settings;

/// What an epoch's validation error calls for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// The best so far: keep these weights.
    Best,
    Continue,
    /// No improvement for so long that training ends.
    Stop,
}

/// Halves the rate after `halve_after` epochs without improvement, ends after `stop_after`.
pub(crate) struct Schedule {
    rate: f64,
    best: f64,
    since_best: usize,
    since_change: usize,
    least_rate: f64,
    halve_after: usize,
    stop_after: usize,
}

impl Schedule {
    pub(crate) fn new(settings: &Settings) -> Self {
        Self {
            rate: settings.rate,
            best: f64::INFINITY,
            since_best: 0,
            since_change: 0,
            least_rate: settings.least_rate,
            halve_after: settings.halve_after,
            stop_after: settings.stop_after,
        }
    }

    pub(crate) fn rate(&self) -> f64 {
        self.rate
    }

    /// Takes the validation error of the epoch that just ended.
    pub(crate) fn epoch(&mut self, validation: f64) -> Verdict {
        if validation < self.best {
            self.best = validation;
            self.since_best = 0;
            self.since_change = 0;
            return Verdict::Best;
        }
        self.since_best += 1;
        self.since_change += 1;
        if self.since_best >= self.stop_after {
            return Verdict::Stop;
        }
        if self.since_change >= self.halve_after {
            self.rate = (0.5 * self.rate).max(self.least_rate);
            self.since_change = 0;
        }
        Verdict::Continue
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat_epochs(settings: &Settings) -> Vec<(Verdict, f64)> {
        let mut schedule = Schedule::new(settings);
        assert_eq!(schedule.epoch(1.0), Verdict::Best);
        (0..settings.stop_after)
            .map(|_| (schedule.epoch(1.0), schedule.rate()))
            .collect()
    }

    #[test]
    fn the_rate_halves_after_five_flat_epochs_and_training_ends_after_twenty() {
        let flat = flat_epochs(&Settings::default());
        let rates: Vec<f64> = flat.iter().map(|(_, rate)| *rate).collect();
        assert_eq!(rates[3], 1e-3);
        assert_eq!(rates[4], 5e-4);
        assert_eq!(rates[9], 2.5e-4);
        assert_eq!(rates[14], 1.25e-4);
        assert!(
            flat[..19]
                .iter()
                .all(|(verdict, _)| *verdict == Verdict::Continue)
        );
        assert_eq!(flat[19].0, Verdict::Stop);
    }

    #[test]
    fn the_rate_never_falls_below_its_least() {
        let flat = flat_epochs(&Settings {
            stop_after: 200,
            ..Settings::default()
        });
        assert_eq!(flat.last().map(|(_, rate)| *rate), Some(1e-6));
    }

    #[test]
    fn an_improvement_starts_the_count_anew_and_keeps_the_rate() {
        let mut schedule = Schedule::new(&Settings::default());
        schedule.epoch(1.0);
        for _ in 0..4 {
            schedule.epoch(2.0);
        }
        assert_eq!(schedule.epoch(0.5), Verdict::Best);
        for _ in 0..4 {
            assert_eq!(schedule.epoch(0.5), Verdict::Continue);
        }
        assert_eq!(schedule.rate(), 1e-3);
        schedule.epoch(0.5);
        assert_eq!(schedule.rate(), 5e-4);
    }
}
