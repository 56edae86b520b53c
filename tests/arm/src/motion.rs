//! One straight line, limited in acceleration and jerk; and a stop.
//!
//! The profile is made as motion controllers make it, and not as the planner plans it: a rectangle of speed, averaged over a moving
//! window that limits the acceleration and over one that limits the jerk (Biagiotti and Melchiorri, "FIR filters for online trajectory
//! planning", Control Engineering Practice 20, 2012).

use std::f64::consts::PI;

/// How the arm brakes when it is stopped, in mm/s².
const BRAKE: f64 = 8_000.0;

/// A motion, by the seconds since it began.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    from: [f64; 6],
    to: [f64; 6],
    length: f64,
    profile: Profile,
    /// Where and how fast it was when it was stopped: seconds, mm, mm/s.
    stopped: Option<(f64, f64, f64)>,
    /// Since when, in s, it runs at half the speed.
    slowed: f64,
}

/// A rectangle of speed under two moving averages.
#[derive(Clone, Copy, Debug)]
struct Profile {
    /// Height of the rectangle, in mm/s.
    speed: f64,
    /// Widths in s: of the rectangle, and of both windows.
    widths: [f64; 3],
}

impl Profile {
    fn new(length: f64, speed: f64, acceleration: f64, jerk: f64) -> Self {
        let rectangle = length / speed;
        // Where the jerk does not let the acceleration be reached, both windows share the ramp.
        let to_acceleration = acceleration / jerk;
        let ramp = speed / acceleration;
        let windows = if ramp >= to_acceleration {
            [ramp, to_acceleration]
        } else {
            [(speed / jerk).sqrt(); 2]
        };
        Self {
            speed,
            widths: [rectangle, windows[0], windows[1]],
        }
    }

    fn duration(&self) -> f64 {
        self.widths.iter().sum()
    }

    /// Distance (mm) and speed (mm/s): an average over a window is a difference of integrals, so that a step under two averages
    /// and integrated once more is eight cubes.
    fn at(&self, t: f64) -> (f64, f64) {
        let [rectangle, one, other] = self.widths;
        let mut sums = (0.0, 0.0);
        for corner in 0..8u8 {
            let is_in = |bit: u8| f64::from(corner >> bit & 1);
            let sign = if corner.count_ones() % 2 == 0 {
                1.0
            } else {
                -1.0
            };
            let since = (t - is_in(0) * rectangle - is_in(1) * one - is_in(2) * other).max(0.0);
            sums.0 += sign * since.powi(3) / 6.0;
            sums.1 += sign * since.powi(2) / 2.0;
        }
        let scale = self.speed / (one * other);
        (scale * sums.0, scale * sums.1)
    }
}

impl Motion {
    /// A line at a speed (mm/s), acceleration (mm/s²) and jerk (mm/s³).
    pub fn line(from: [f64; 6], to: [f64; 6], speed: f64, acceleration: f64, jerk: f64) -> Self {
        // The tool turns the shorter way.
        let to = std::array::from_fn(|i| match i {
            0..3 => to[i],
            _ => from[i] + (to[i] - from[i] + PI).rem_euclid(2.0 * PI) - PI,
        });
        let length = (0..3)
            .map(|i| (to[i] - from[i]).powi(2))
            .sum::<f64>()
            .sqrt();
        Self {
            from,
            to,
            length,
            profile: Profile::new(length, speed, acceleration, jerk),
            stopped: None,
            slowed: f64::INFINITY,
        }
    }

    /// Runs at half the speed from now on.
    pub fn slow_down(&mut self, t: f64) {
        self.slowed = self.slowed.min(t);
    }

    /// Seconds of the line as it was planned, and the share of its speed.
    fn planned(&self, t: f64) -> (f64, f64) {
        let later = (t - self.slowed).max(0.0);
        (t - 0.5 * later, if later > 0.0 { 0.5 } else { 1.0 })
    }

    pub fn duration(&self) -> f64 {
        match self.stopped {
            Some((at, _, speed)) => at + speed / BRAKE,
            None => self.profile.duration() + (self.profile.duration() - self.slowed).max(0.0),
        }
    }

    /// Begins to brake now.
    pub fn stop(&mut self, t: f64) {
        if self.stopped.is_none() {
            let (distance, speed) = self.progress(t);
            self.stopped = Some((t, distance, speed));
        }
    }

    /// Distance (mm) and speed (mm/s) along the line.
    pub fn progress(&self, t: f64) -> (f64, f64) {
        if let Some((at, distance, speed)) = self.stopped {
            let later = (t - at).clamp(0.0, speed / BRAKE);
            return (
                distance + speed * later - 0.5 * BRAKE * later * later,
                speed - BRAKE * later,
            );
        }
        if t >= self.duration() {
            return (self.length, 0.0);
        }
        let (planned, share) = self.planned(t);
        let (distance, speed) = self.profile.at(planned);
        (distance, share * speed)
    }

    /// Pose (mm, rad) and velocity (mm/s).
    pub fn at(&self, t: f64) -> ([f64; 6], [f64; 3]) {
        let (distance, speed) = self.progress(t);
        let length = self.length.max(1e-9);
        let share = if self.length < 1e-6 {
            1.0
        } else {
            distance / length
        };
        let pose = std::array::from_fn(|i| self.from[i] + share * (self.to[i] - self.from[i]));
        let velocity = std::array::from_fn(|i| speed * (self.to[i] - self.from[i]) / length);
        (pose, velocity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_keeps_to_its_limits_and_ends_where_it_is_to() {
        // Reaching the acceleration, not reaching it, and too short for the speed.
        for (length, speed, acceleration, jerk) in [
            (400.0, 1_000.0, 10_000.0, 100_000.0),
            (400.0, 400.0, 20_000.0, 100_000.0),
            (30.0, 1_000.0, 5_000.0, 100_000.0),
        ] {
            let to = [length, 0.0, 0.0, 0.0, 0.0, 0.0];
            let motion = Motion::line([0.0; 6], to, speed, acceleration, jerk);
            let step = 1e-4;
            let ticks = (motion.duration() / step) as u32 + 2;
            let at = |tick: u32| motion.progress(f64::from(tick) * step);
            let (mut before, mut rising) = (0.0, 0.0);
            for tick in 1..ticks {
                let (distance, now) = at(tick);
                let acceleration_now = (now - before) / step;
                let jerk_now = (acceleration_now - rising) / step;
                assert!((-1e-6..=speed * 1.000_001).contains(&now), "{now}");
                assert!(
                    acceleration_now.abs() <= acceleration * 1.001,
                    "{acceleration_now}"
                );
                assert!(jerk_now.abs() <= jerk * 1.01, "{jerk_now} of {jerk}");
                assert!(distance >= at(tick - 1).0 - 1e-9);
                (before, rising) = (now, acceleration_now);
            }
            assert!((at(ticks).0 - length).abs() < 1e-9);
        }
    }
}
