//! What of a track is a free slide.

use crate::{Strike, Track};

/// Seconds over which a speed is taken.
const WINDOW: f64 = 0.05;
/// A rise of the speed counts from this share of the greatest speed, and from so many standard deviations of its noise.
const RISE: (f64, f64) = (0.1, 6.0);
/// Median of the absolute value of a normal variable.
const MEDIAN: f64 = 0.674_49;

impl Strike {
    /// The strike without its first `frame` seconds: a track has a corner at the impact, and a clock that is off by a part of
    /// a frame would bend a fit there.
    pub fn after_impact(&self, frame: f64) -> Self {
        let mut strike = self.clone();
        let keep = strike.track.t.partition_point(|&t| t < frame * 0.999);
        strike.track.t.drain(..keep);
        strike.track.x.drain(..keep);
        strike.track.y.drain(..keep);
        strike
    }
}

impl Track {
    /// Whether the object speeds up again after it has slowed down, beyond the noise of its frames: it was pushed a second time,
    /// as by an arm that goes on behind it.
    pub fn is_pushed_again(&self) -> bool {
        let frames = self.len();
        let span = self
            .t
            .last()
            .zip(self.t.first())
            .map_or(0.0, |(b, a)| b - a);
        let window = ((WINDOW * frames as f64 / span.max(1e-9)) as usize).max(3);
        if frames < window + 3 || span <= 0.0 {
            return false;
        }
        let speeds: Vec<f64> = (window..frames)
            .map(|i| {
                self.point(i).distance(self.point(i - window)) / (self.t[i] - self.t[i - window])
            })
            .collect();
        let noise = std::f64::consts::SQRT_2 * self.noise() / WINDOW;
        let peak = speeds.iter().copied().fold(0.0, f64::max);
        let allowed = (RISE.0 * peak).max(RISE.1 * noise);
        let mut least = f64::INFINITY;
        speeds.iter().any(|speed| {
            least = least.min(*speed);
            speed - least > allowed
        })
    }

    /// Standard deviation in m of a coordinate from frame to frame, by second differences.
    fn noise(&self) -> f64 {
        let bends = |x: &[f64]| -> Vec<f64> {
            x.windows(3)
                .map(|w| (w[2] - 2.0 * w[1] + w[0]).abs())
                .collect()
        };
        let mut bends = [bends(&self.x), bends(&self.y)].concat();
        bends.sort_by(f64::total_cmp);
        bends.get(bends.len() / 2).copied().unwrap_or(0.0) / (MEDIAN * 6f64.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slide under 2 m/s² from 0.8 m/s, pushed again by `push` m/s at 0.2 s, seen with noise of this many mm.
    fn track(push: f64, noise: f64) -> Track {
        let (mut x, mut speed, mut track) = (0.0, 0.8, Track::default());
        for i in 0..40 {
            let t = f64::from(i) / 60.0;
            let wobble = |k: f64| noise * 1e-3 * (f64::from(i * i) * k).sin() * 1.4;
            track.t.push(t);
            track.x.push(x + wobble(1.1));
            track.y.push(wobble(2.3));
            if i == 12 {
                speed += push;
            }
            x += speed / 60.0;
            speed = f64::max(speed - 2.0 / 60.0, 0.0);
        }
        track
    }

    #[test]
    fn a_second_push_shows_and_noise_does_not() {
        assert!(track(0.3, 0.5).is_pushed_again());
        for noise in [0.0, 0.5, 1.5, 4.0] {
            assert!(!track(0.0, noise).is_pushed_again(), "{noise}");
        }
        assert!(!Track::default().is_pushed_again());
    }
}
