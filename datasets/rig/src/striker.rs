//! The arm's trapezoid: start, ramp, plateau through the impact, ramp, stop.

use values::{Command, Point};

/// Distance, in m, before the impact at which the commanded speed is reached (paper, section 3.1).
const PRE_STRIKE: f64 = 0.010;
/// Distance, in m, beyond the impact over which the commanded speed is held, so that the plateau spans the impact even if the arm is slower than
/// commanded.
const FOLLOW_THROUGH: f64 = 0.010;

/// One commanded motion along a line; times in s from its start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Profile {
    command: Command,
    ramp: f64,
    plateau: f64,
}

impl Profile {
    pub(crate) fn new(command: Command, acceleration: f64) -> Self {
        Self {
            command,
            ramp: command.speed / acceleration,
            plateau: (PRE_STRIKE + FOLLOW_THROUGH) / command.speed,
        }
    }

    /// How long it lasts.
    pub(crate) fn duration(&self) -> f64 {
        2.0 * self.ramp + self.plateau
    }

    /// When the tip touches, if it moves at this speed (m/s) from the pre-strike position on, which it reaches in time.
    pub(crate) fn impact(&self, delivered_speed: f64) -> f64 {
        self.ramp + PRE_STRIKE / delivered_speed
    }

    /// Commanded speed at a time, in m/s.
    pub(crate) fn speed(&self, time: f64) -> f64 {
        let falling = time - self.ramp - self.plateau;
        let share = if time < self.ramp {
            time / self.ramp
        } else {
            1.0 - falling.max(0.0) / self.ramp
        };
        self.command.speed * share.clamp(0.0, 1.0)
    }

    /// Commanded velocity at a time, in m/s.
    pub(crate) fn velocity(&self, time: f64) -> Point {
        Point::polar(self.speed(time), self.command.angle)
    }

    /// Distance commanded from the start to a time, in m.
    pub(crate) fn distance(&self, time: f64) -> f64 {
        let rising = time.clamp(0.0, self.ramp);
        let flat = (time - self.ramp).clamp(0.0, self.plateau);
        let falling = (time - self.ramp - self.plateau).clamp(0.0, self.ramp);
        self.command.speed
            * (rising * rising / (2.0 * self.ramp) + flat + falling
                - falling * falling / (2.0 * self.ramp))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trapezoid_reaches_its_speed_ten_millimetres_before_the_blow() {
        let profile = Profile::new(Command::new(0.8, 0.0), 4.0);
        assert!((profile.speed(0.1) - 0.4).abs() < 1e-12);
        assert_eq!(profile.speed(profile.impact(0.8)), 0.8);
        assert!((profile.impact(0.8) - (0.2 + 0.0125)).abs() < 1e-12);
        assert!(profile.speed(profile.duration()).abs() < 1e-12);
        assert!((profile.distance(profile.duration()) - (0.16 + 0.02)).abs() < 1e-12);
    }
}
