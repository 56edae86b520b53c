//! A straight line of the tip, and where on it the tip is when.

use super::driver::{Pose, distance};
use crate::stroke::Ramp;

#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    /// Start of the line: x, y, z in m.
    pub(super) from: [f64; 3],
    /// End of the line; the tip keeps this orientation all along it.
    pub(super) to: Pose,
    /// Greatest speed in m/s.
    pub(super) speed: f64,
    /// Distance from the beginning, in m, at which that speed must be reached; none where it need not.
    pub(super) reached_at: Option<f64>,
    pub(super) profile: Profile,
    /// Time, in s, within which it begins after it was sent.
    pub(super) start: f64,
}

impl Line {
    /// Its length in m.
    pub(super) fn length(&self) -> f64 {
        distance(self.from, self.to.at)
    }

    /// Distance of a point along the line, and beside it, in m.
    pub(super) fn place(&self, point: [f64; 3]) -> (f64, f64) {
        let length = self.length().max(1e-9);
        let along = (0..3)
            .map(|i| (point[i] - self.from[i]) * (self.to.at[i] - self.from[i]) / length)
            .sum::<f64>();
        let nearest = std::array::from_fn(|i| {
            let share = along.clamp(0.0, length) / length;
            self.from[i] + share * (self.to.at[i] - self.from[i])
        });
        (along, distance(point, nearest))
    }
}

/// Distance of the tip along a line, `t` seconds after it begins: up to the speed, and down again.
#[derive(Clone, Copy, Debug)]
pub(super) struct Profile {
    length: f64,
    ramp: Ramp,
    /// Seconds from rest to rest.
    pub(super) duration: f64,
}

impl Profile {
    /// The profile over a length in m under limits in m/s, m/s² and m/s³. A line that is too short for the speed comes as near to it as it can.
    pub(super) fn new(length: f64, speed: f64, acceleration: f64, jerk: Option<f64>) -> Self {
        let (mut low, mut high) = (0.0, speed);
        let fits = |speed: f64| 2.0 * Ramp::to(speed, acceleration, jerk).length() <= length;
        let mut top = speed;
        if !fits(speed) {
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                (low, high) = if fits(middle) {
                    (middle, high)
                } else {
                    (low, middle)
                };
            }
            top = low.max(1e-9);
        }
        let ramp = Ramp::to(top, acceleration, jerk);
        Self {
            length,
            ramp,
            duration: 2.0 * ramp.duration + (length - 2.0 * ramp.length()).max(0.0) / top,
        }
    }

    /// Distance from the beginning, in m.
    pub(super) fn at(&self, t: f64) -> f64 {
        let left = self.duration - t;
        if left <= 0.0 {
            self.length
        } else if left < self.ramp.duration {
            self.length - self.ramp.at(left).0
        } else {
            self.ramp.at(t).0
        }
    }

    /// Time, in s, at which it has gone this distance (m).
    pub(super) fn when(&self, along: f64) -> f64 {
        let (mut low, mut high) = (0.0, self.duration);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            (low, high) = if self.at(middle) < along {
                (middle, high)
            } else {
                (low, middle)
            };
        }
        low
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_runs_from_end_to_end_and_back_from_a_place_to_its_time() {
        for (length, jerk) in [
            (0.4, Some(100.0)),
            (0.4, None),
            (0.01, Some(100.0)),
            (0.01, None),
        ] {
            let profile = Profile::new(length, 0.8, 5.0, jerk);
            assert_eq!(profile.at(0.0), 0.0);
            assert!((profile.at(profile.duration) - length).abs() < 1e-9);
            let mut before = 0.0;
            for step in 1..100 {
                let t = profile.duration * f64::from(step) / 100.0;
                let along = profile.at(t);
                assert!(along >= before && along <= length);
                assert!(along - before < 0.8 * profile.duration / 99.0);
                assert!((profile.when(along) - t).abs() < 1e-3, "{length} {t}");
                before = along;
            }
        }
    }
}
