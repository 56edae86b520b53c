//! The motion of the tip that strikes: start, pre-strike, strike, stop (paper, section 3.1), limited in acceleration and jerk.

use serde::Serialize;
use values::{Command, Point, Robot};

/// Length in m over which the tip holds the striking speed before it strikes (paper, section 3.1).
const PLATEAU: f64 = 0.010;
/// Distance, in m, over which an arm also holds the speed beyond the strike: its controller may begin to brake a little early, and reports, 4 ms
/// apart, show the speed of the touch between two of them.
const FOLLOW_THROUGH: f64 = 0.005;

/// A change of speed from rest, or to rest, limited in acceleration and jerk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    speed: f64,
    /// Greatest acceleration that it comes to, in m/s².
    acceleration: f64,
    /// Time, in s, to reach that acceleration; 0 without a limit of the jerk.
    rise: f64,
    /// Seconds that it lasts.
    pub duration: f64,
}

impl Ramp {
    /// The ramp from rest to `speed` (m/s) under limits in m/s² and m/s³.
    pub fn to(speed: f64, acceleration: f64, jerk: Option<f64>) -> Self {
        let (acceleration, rise) = match jerk {
            None => (acceleration, 0.0),
            Some(jerk) if speed * jerk >= acceleration * acceleration => {
                (acceleration, acceleration / jerk)
            }
            // The acceleration allowed is never reached.
            Some(jerk) => ((speed * jerk).sqrt(), (speed / jerk).sqrt()),
        };
        Self {
            speed,
            acceleration,
            rise,
            duration: speed / acceleration + rise,
        }
    }

    /// Its length in m.
    pub fn length(&self) -> f64 {
        0.5 * self.speed * self.duration
    }

    /// Distance covered (m) and speed (m/s) after a time (s) from rest.
    pub fn at(&self, t: f64) -> (f64, f64) {
        if t <= 0.0 {
            return (0.0, 0.0);
        }
        if t >= self.duration {
            return (self.length() + self.speed * (t - self.duration), self.speed);
        }
        if t > 0.5 * self.duration {
            // The second half mirrors the first.
            let (left, slower) = self.at(self.duration - t);
            return (self.speed * t - self.length() + left, self.speed - slower);
        }
        let (a, rise) = (self.acceleration, self.rise);
        if t < rise {
            return (a * t * t * t / (6.0 * rise), a * t * t / (2.0 * rise));
        }
        let later = t - rise;
        let (distance, speed) = (a * rise * rise / 6.0, 0.5 * a * rise);
        (
            distance + speed * later + 0.5 * a * later * later,
            speed + a * later,
        )
    }
}

/// Position of the tip's centre over time, in m and s; it moves on a straight line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Stroke {
    /// At rest, at time 0.
    pub start: Point,
    /// Striking speed reached, at `t_pre_strike`.
    pub pre_strike: Point,
    /// The tip touches the object, at `t_strike`.
    pub strike: Point,
    /// At rest again, at `t_stop`.
    pub stop: Point,
    /// Seconds from start to striking speed.
    pub t_pre_strike: f64,
    /// Seconds from start to touch.
    pub t_strike: f64,
    /// Seconds from start to rest.
    pub t_stop: f64,
    #[serde(skip)]
    ramp: Ramp,
    #[serde(skip)]
    direction: Point,
}

impl Stroke {
    /// The motion that strikes an object at `initial` (m) with `command`; `standoff` (m) is the distance of tip's and object's
    /// centre at touch.
    pub fn plan(initial: Point, command: Command, robot: &Robot, standoff: f64) -> Self {
        let direction = Point::polar(1.0, command.angle);
        let ramp = Ramp::to(command.speed, robot.acceleration, robot.jerk);
        // What strikes at a height, or with a jerk, is an arm; the paper's trapezoid has neither.
        let is_arm = robot.jerk.is_some() || robot.strike_height.is_some();
        let beyond = if is_arm { FOLLOW_THROUGH } else { 0.0 };
        let strike = initial - direction * standoff;
        let pre_strike = strike - direction * PLATEAU;
        let t_strike = ramp.duration + PLATEAU / command.speed;
        Self {
            start: pre_strike - direction * ramp.length(),
            pre_strike,
            strike,
            stop: strike + direction * (beyond + ramp.length()),
            t_pre_strike: ramp.duration,
            t_strike,
            t_stop: t_strike + beyond / command.speed + ramp.duration,
            ramp,
            direction,
        }
    }

    /// Position (m) and velocity (m/s) of the tip's centre, `t` seconds after it starts.
    pub fn at(&self, t: f64) -> (Point, Point) {
        let left = self.t_stop - t;
        let (distance, speed) = if left < self.ramp.duration {
            let (to_go, speed) = self.ramp.at(left);
            (self.length() - to_go, speed)
        } else {
            self.ramp.at(t)
        };
        (
            self.start + self.direction * distance,
            self.direction * speed,
        )
    }

    /// Distance from start to stop, in m.
    pub fn length(&self) -> f64 {
        self.start.distance(self.stop)
    }

    /// Direction of the motion, a unit vector.
    pub fn direction(&self) -> Point {
        self.direction
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn robot(acceleration: f64, jerk: Option<f64>) -> Robot {
        Robot {
            jerk,
            ..Robot::limits([0.4, 1.0].into(), [-0.8, 0.8].into(), acceleration)
        }
    }

    const COMMAND: Command = Command::new(0.8, 0.3);

    #[test]
    fn without_a_jerk_it_is_the_papers_trapezoid() {
        let from = Point::new(0.3, 0.1);
        let stroke = Stroke::plan(from, COMMAND, &robot(5.0, None), 0.042);
        let profile = world::Profile::plan(from, COMMAND, 5.0, 0.042);
        for t in (0..=400).map(|i| f64::from(i) * 1e-3) {
            let ((at, velocity), (there, other)) = (stroke.at(t), profile.at(t));
            assert!(
                at.distance(there) < 1e-9 && velocity.distance(other) < 1e-9,
                "{t}"
            );
        }
        assert!((stroke.t_stop - profile.t_stop).abs() < 1e-12);
    }

    #[test]
    fn no_limit_is_passed_and_the_speed_is_reached_before_the_strike() {
        for (acceleration, jerk) in [(5.0, 100.0), (50.0, 100.0), (5.0, 10.0), (2.0, 1e4)] {
            let stroke = Stroke::plan(
                Point::new(0.5, 0.0),
                COMMAND,
                &robot(acceleration, Some(jerk)),
                0.042,
            );
            let step = stroke.t_stop / 20_000.0;
            let speed = |i: i32| stroke.at(f64::from(i) * step).1.norm();
            let mut before = 0.0;
            let mut distance = 0.0;
            for i in 0..20_000 {
                let now = (speed(i + 1) - speed(i)) / step;
                assert!(
                    now.abs() <= acceleration * 1.001,
                    "{acceleration} {jerk}: {now}"
                );
                let change = ((now - before) / step).abs();
                assert!(
                    change <= jerk * 1.01 + 1e-3 / step,
                    "{acceleration} {jerk}: {change}"
                );
                before = now;
                distance += 0.5 * (speed(i) + speed(i + 1)) * step;
            }
            assert!((distance - stroke.length()).abs() < 1e-6);
            let (at, velocity) = stroke.at(stroke.t_pre_strike);
            assert!(at.distance(stroke.pre_strike) < 1e-9);
            assert!((velocity.norm() - 0.8).abs() < 1e-9);
            assert!(stroke.at(stroke.t_strike).0.distance(stroke.strike) < 1e-9);
            assert!(stroke.at(stroke.t_stop).0.distance(stroke.stop) < 1e-9);
        }
    }

    #[test]
    fn a_run_up_limited_in_jerk_is_longer() {
        let length = |jerk| Ramp::to(1.0, 50.0, jerk).length();
        assert!((length(None) - 0.01).abs() < 1e-12);
        // At 100 m/s³ 1 m/s takes two times 0.1 s.
        assert!((length(Some(100.0)) - 0.1).abs() < 1e-12);
        assert!((length(Some(1.0)) - 1.0).abs() < 1e-12);
    }
}
