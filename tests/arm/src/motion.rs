//! One straight line, limited in acceleration and jerk; and a stop.

use strike::Ramp;

/// How the arm brakes when it is stopped, in mm/s².
const BRAKE: f64 = 8_000.0;

/// A motion, by the seconds since it began.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    from: [f64; 6],
    to: [f64; 6],
    length: f64,
    top: f64,
    ramp: Ramp,
    /// Where and how fast it was when it was stopped: seconds, mm, mm/s.
    stopped: Option<(f64, f64, f64)>,
}

impl Motion {
    /// A line at a speed (mm/s), acceleration (mm/s²) and jerk (mm/s³).
    pub fn line(from: [f64; 6], to: [f64; 6], speed: f64, acceleration: f64, jerk: f64) -> Self {
        let length = (0..3)
            .map(|i| (to[i] - from[i]).powi(2))
            .sum::<f64>()
            .sqrt();
        // A line that is too short for its speed is moved at one that it has room for.
        let fits = |speed: f64| 2.0 * Ramp::to(speed, acceleration, Some(jerk)).length() <= length;
        let mut top = speed;
        if !fits(top) {
            let (mut low, mut high) = (0.0, top);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if fits(middle) {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            top = low.max(1e-6);
        }
        Self {
            from,
            to,
            length,
            top,
            ramp: Ramp::to(top, acceleration, Some(jerk)),
            stopped: None,
        }
    }

    /// Seconds that it lasts.
    pub fn duration(&self) -> f64 {
        if let Some((at, _, speed)) = self.stopped {
            return at + speed / BRAKE;
        }
        let cruise = (self.length - 2.0 * self.ramp.length()) / self.top;
        2.0 * self.ramp.duration + cruise.max(0.0)
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
        let left = self.duration() - t;
        if left <= 0.0 {
            (self.length, 0.0)
        } else if left < self.ramp.duration {
            let (to_go, speed) = self.ramp.at(left);
            (self.length - to_go, speed)
        } else {
            self.ramp.at(t)
        }
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
