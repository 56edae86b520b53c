//! What of a track is a free slide.

use crate::{Strike, Track, median};

/// Seconds over which a speed is taken, and how many neighbouring speeds a median is taken of: single frames that are stale, early
/// or astray then move none.
const WINDOW: f64 = 0.07;
const NEIGHBOURS: usize = 7;
/// A rise of the speed counts from this share of the greatest speed, and of the speed before it, and from so many standard
/// deviations of its noise.
const RISE: (f64, f64, f64) = (0.1, 0.15, 6.0);
/// Share of the whole distance within which frames determine the deceleration: noise rules the ends.
const USED: std::ops::Range<f64> = 0.05..0.90;
/// Share of most strikes' deceleration below which an object was carried along: no table has patches of half its friction under a whole
/// slide.
const CARRIED: f64 = 0.5;
/// Deceleration in m/s² below which nothing brakes on a table, carried along or not.
const BRAKES: f64 = 0.5;
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
        if let Some(yaw) = &mut strike.track.yaw {
            yaw.track.drain(..keep.min(yaw.track.len()));
        }
        strike
    }

    /// Deceleration in m/s², as if it were constant, and the speed of release in m/s. None where too few frames lie on the way.
    pub fn release(&self) -> Option<(f64, f64)> {
        if self.has_stop() {
            let deceleration = self.deceleration()?;
            // Of release, as long a way before the stop.
            return Some((
                deceleration,
                (2.0 * deceleration * self.path().norm()).sqrt(),
            ));
        }
        let (deceleration, speed) = self.parabola()?;
        Some((deceleration, speed))
    }

    /// Deceleration and speed at time zero, of a parabola through the distances along the path: for a track that ends before rest.
    fn parabola(&self) -> Option<(f64, f64)> {
        let path = self.path();
        let whole = path.norm();
        let n = self.track.len() as f64;
        if n < 6.0 || whole <= 0.0 {
            return None;
        }
        let (mut s, mut q) = ([0.0; 5], [0.0; 3]);
        for frame in 0..self.track.len() {
            let t = self.track.t[frame];
            let gone = (self.track.point(frame) - self.initial).dot(path) / whole;
            for (power, sum) in s.iter_mut().enumerate() {
                *sum += t.powi(power as i32);
            }
            for (power, sum) in q.iter_mut().enumerate() {
                *sum += gone * t.powi(power as i32);
            }
        }
        // Normal equations by Cramer's rule.
        let det = |m: [[f64; 3]; 3]| {
            m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
                - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
                + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
        };
        let a = [[s[0], s[1], s[2]], [s[1], s[2], s[3]], [s[2], s[3], s[4]]];
        let with = |column: usize| {
            let mut b = a;
            for (row, value) in b.iter_mut().zip(q) {
                row[column] = value;
            }
            det(b)
        };
        let whole = det(a);
        let (speed, half) = (with(1) / whole, with(2) / whole);
        (speed > 0.0 && half.is_finite()).then_some((-2.0 * half, speed))
    }

    /// Deceleration in m/s², as if it were constant: √(D − d) falls along a straight line, D the path's length and d what is gone of
    /// it. None where too few frames lie on the way.
    pub fn deceleration(&self) -> Option<f64> {
        if !self.has_stop() {
            return self.parabola().map(|(deceleration, _)| deceleration);
        }
        let path = self.path();
        let whole = path.norm();
        let points: Vec<(f64, f64)> = (0..self.track.len())
            .map(|i| {
                let gone = (self.track.point(i) - self.initial).dot(path) / whole;
                (self.track.t[i], gone)
            })
            .filter(|(_, gone)| USED.contains(&(gone / whole)))
            .map(|(t, gone)| (t, (whole - gone).sqrt()))
            .collect();
        let n = points.len() as f64;
        if n < 3.0 {
            return None;
        }
        let (mean_t, mean_s) = (
            points.iter().map(|p| p.0).sum::<f64>() / n,
            points.iter().map(|p| p.1).sum::<f64>() / n,
        );
        let covariance: f64 = points.iter().map(|p| (p.0 - mean_t) * (p.1 - mean_s)).sum();
        let variance: f64 = points.iter().map(|p| (p.0 - mean_t).powi(2)).sum();
        let slope = covariance / variance;
        (slope < 0.0).then_some(2.0 * slope * slope)
    }
}

/// Which of these strikes slide freely: not pushed a second time, and braked at least half as much as most are. An arm that goes on
/// behind an object carries it without the object's speeding up again.
pub fn free_slides(strikes: &[&Strike]) -> Vec<bool> {
    let is_free: Vec<bool> = strikes.iter().map(|s| !s.is_pushed_again()).collect();
    let braked: Vec<Option<f64>> = strikes.iter().map(|s| s.deceleration()).collect();
    let all: Vec<f64> = braked
        .iter()
        .zip(&is_free)
        .filter_map(|(braked, is_free)| braked.filter(|_| *is_free))
        .collect();
    if all.is_empty() {
        return is_free;
    }
    let usual = median(all).unwrap_or(0.0);
    let least = if usual > BRAKES {
        CARRIED * usual
    } else {
        f64::NEG_INFINITY
    };
    is_free
        .iter()
        .zip(&braked)
        .map(|(is_free, braked)| *is_free && braked.is_none_or(|braked| braked >= least))
        .collect()
}

impl Track {
    /// Whether the object speeds up again after it has slowed down, beyond what frames can feign: it was pushed a second time,
    /// as by an arm that goes on behind it.
    pub fn is_pushed_again(&self) -> bool {
        let frames = self.len();
        let span = self
            .t
            .last()
            .zip(self.t.first())
            .map_or(0.0, |(b, a)| b - a);
        let window = ((WINDOW * frames as f64 / span.max(1e-9)) as usize).max(NEIGHBOURS);
        if frames < window + NEIGHBOURS || span <= 0.0 {
            return false;
        }
        let speeds: Vec<f64> = (window..frames)
            .map(|i| {
                self.point(i).distance(self.point(i - window)) / (self.t[i] - self.t[i - window])
            })
            .collect();
        let noise = std::f64::consts::SQRT_2 * self.noise() / WINDOW;
        let peak = speeds.iter().copied().fold(0.0, f64::max);
        let mut least = f64::INFINITY;
        speeds.windows(NEIGHBOURS).any(|near| {
            let speed = median(near.to_vec()).unwrap_or(0.0);
            least = least.min(speed);
            speed - least > (RISE.0 * peak).max(RISE.1 * least).max(RISE.2 * noise)
        })
    }

    /// Standard deviation in m of a coordinate from frame to frame, by second differences.
    fn noise(&self) -> f64 {
        let bends = |x: &[f64]| -> Vec<f64> {
            x.windows(3)
                .map(|w| (w[2] - 2.0 * w[1] + w[0]).abs())
                .collect()
        };
        median([bends(&self.x), bends(&self.y)].concat()).unwrap_or(0.0) / (MEDIAN * 6f64.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Command, Point};

    /// A strike along x under `braking` m/s².
    fn strike(braking: f64) -> Strike {
        let speed: f64 = 0.8;
        let whole = speed * speed / (2.0 * braking);
        let mut track = Track::default();
        for i in 0..60 {
            let t = (f64::from(i) / 60.0).min(speed / braking);
            track.t.push(f64::from(i) / 60.0);
            track.x.push(speed * t - 0.5 * braking * t * t);
            track.y.push(0.0);
        }
        Strike {
            track,
            ..Strike::bare(
                Command::new(0.6, 0.0),
                Point::new(0.0, 0.0),
                Point::new(whole, 0.0),
            )
        }
    }

    #[test]
    fn what_is_carried_along_is_no_free_slide() {
        let strikes = [2.0, 2.1, 1.9, 1.4, 0.8].map(strike);
        // One that ends on its way says the same.
        let mut cut = strikes[0].clone();
        cut.track.t.truncate(15);
        cut.track.x.truncate(15);
        cut.track.y.truncate(15);
        cut.track.end = crate::End::Contact;
        cut.stop = cut.track.point(14);
        let (deceleration, speed) = cut.release().expect("determined");
        assert!((deceleration - 2.0).abs() < 1e-6 && (speed - 0.8).abs() < 1e-6);
        assert!((strikes[0].deceleration().expect("determined") - 2.0).abs() < 1e-6);
        let all: Vec<&Strike> = strikes.iter().collect();
        assert_eq!(free_slides(&all), [true, true, true, true, false]);
        assert!(free_slides(&[]).is_empty());
    }

    /// A slide under 2 m/s² from 0.8 m/s, pushed again by `push` m/s at 0.3 s, seen with noise of this many mm.
    fn track(push: f64, noise: f64) -> Track {
        let (mut x, mut speed, mut track) = (0.0, 0.8, Track::default());
        for i in 0..40 {
            let t = f64::from(i) / 60.0;
            let wobble = |k: f64| noise * 1e-3 * (f64::from(i * i) * k).sin() * 1.4;
            track.t.push(t);
            track.x.push(x + wobble(1.1));
            track.y.push(wobble(2.3));
            if i == 18 {
                speed += push;
            }
            x += speed / 60.0;
            speed = f64::max(speed - 2.0 / 60.0, 0.0);
        }
        track
    }

    #[test]
    fn a_second_push_shows_and_noise_does_not() {
        assert!(track(0.5, 0.5).is_pushed_again());
        for noise in [0.0, 0.5, 1.5, 4.0] {
            assert!(!track(0.0, noise).is_pushed_again(), "{noise}");
        }
        assert!(!Track::default().is_pushed_again());
    }

    #[test]
    fn frames_that_are_stale_early_late_or_astray_are_no_push() {
        for first in 1..36 {
            let mut stale = track(0.0, 0.5);
            (stale.x[first], stale.y[first]) = (stale.x[first - 1], stale.y[first - 1]);
            let again = (first + 9).min(38);
            (stale.x[again], stale.y[again]) = (stale.x[again - 1], stale.y[again - 1]);
            assert!(!stale.is_pushed_again(), "stale at {first}");

            let mut jitter = track(0.0, 0.5);
            for (i, t) in jitter.t.iter_mut().enumerate() {
                *t += 0.004 * ((i * first) as f64 * 1.7).sin();
            }
            assert!(!jitter.is_pushed_again(), "jitter {first}");

            let mut astray = track(0.0, 0.5);
            for (i, x) in astray.x[first..first + 3].iter_mut().enumerate() {
                *x += [0.015, -0.012, 0.014][i];
            }
            assert!(!astray.is_pushed_again(), "astray at {first}");
        }
    }
}
