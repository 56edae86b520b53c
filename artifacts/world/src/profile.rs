//! The trapezoidal motion of the tip: start, pre-strike, strike, stop (paper, section 3.1).

use serde::{Deserialize, Serialize};
use values::{Command, Point};

/// Length in m over which the tip holds the striking speed before it strikes.
pub const RUN_UP: f64 = 0.010;

/// Where the tip's centre is when, in m and s; it moves on a straight line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Profile {
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
}

impl Profile {
    /// The motion that strikes an object at `initial` with `command`: constant `acceleration` (m/s²) up to the
    /// pre-strike position 10 mm ahead of the strike, constant speed to the strike, constant deceleration to rest.
    /// `standoff` (m) is the distance of tip's and object's centre at touch.
    pub fn plan(initial: Point, command: Command, acceleration: f64, standoff: f64) -> Self {
        let direction = Point::polar(1.0, command.angle);
        let ramp = command.speed * command.speed / (2.0 * acceleration);
        let strike = initial - direction * standoff;
        let pre_strike = strike - direction * RUN_UP;
        let t_pre_strike = command.speed / acceleration;
        let t_strike = t_pre_strike + RUN_UP / command.speed;
        Self {
            start: pre_strike - direction * ramp,
            pre_strike,
            strike,
            stop: strike + direction * ramp,
            t_pre_strike,
            t_strike,
            t_stop: t_strike + t_pre_strike,
        }
    }

    /// Position (m) and velocity (m/s) of the tip's centre, `t` seconds after it starts.
    pub fn at(&self, t: f64) -> (Point, Point) {
        let speed = (self.strike - self.pre_strike).norm() / (self.t_strike - self.t_pre_strike);
        let direction = (self.strike - self.pre_strike) * (1.0 / RUN_UP);
        let acceleration = speed / self.t_pre_strike;
        if t <= 0.0 {
            (self.start, Point::default())
        } else if t < self.t_pre_strike {
            (
                self.start + direction * (0.5 * acceleration * t * t),
                direction * (acceleration * t),
            )
        } else if t < self.t_strike {
            (
                self.pre_strike + direction * (speed * (t - self.t_pre_strike)),
                direction * speed,
            )
        } else if t < self.t_stop {
            let left = self.t_stop - t;
            (
                self.stop - direction * (0.5 * acceleration * left * left),
                direction * (acceleration * left),
            )
        } else {
            (self.stop, Point::default())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_profile_is_continuous_and_reaches_its_positions() {
        let command = Command::new(0.8, 0.3);
        let profile = Profile::plan(Point::new(0.3, 0.1), command, 5.0, 0.042);
        for (t, place) in [
            (0.0, profile.start),
            (profile.t_pre_strike, profile.pre_strike),
            (profile.t_strike, profile.strike),
            (profile.t_stop, profile.stop),
        ] {
            for side in [-1e-9, 1e-9] {
                assert!(profile.at(t + side).0.distance(place) < 1e-8);
            }
        }
        assert!((profile.at(profile.t_strike - 1e-6).1.norm() - 0.8).abs() < 1e-9);
        assert!((profile.strike.distance(Point::new(0.3, 0.1)) - 0.042).abs() < 1e-12);
        assert!((profile.pre_strike.distance(profile.strike) - RUN_UP).abs() < 1e-12);
    }
}
