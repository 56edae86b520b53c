//! How the object leaves the tip.
//!
//! After it the slide is planar and smooth, and can be integrated without contacts where thousands of worlds must be tried.

use values::{Command, Point};

/// The object as it leaves the tip, in the frame of the impact: x along the tip's velocity, y to its left, the object at rest
/// in the origin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Release {
    /// Seconds since touch.
    pub time: f64,
    /// Position of the object in m.
    pub position: Point,
    /// Its velocity in m/s.
    pub velocity: Point,
    /// Its rate of turning in rad/s.
    pub spin: f64,
}

/// What varies of a release from impact to impact: time, position and velocity in the frame of the impact, spin; positions per m,
/// velocities and spin per m/s of the tip's speed.
pub(crate) type Scaled = [f64; 6];

impl Release {
    /// By the tip's speed in m/s.
    pub(crate) fn scaled(&self, speed: f64) -> Scaled {
        [
            self.time,
            self.position.x,
            self.position.y,
            self.velocity.x / speed,
            self.velocity.y / speed,
            self.spin / speed,
        ]
    }

    /// After an impact with this command, on the table.
    pub(crate) fn of(scaled: Scaled, command: Command) -> Self {
        let [time, x, y, vx, vy, spin] = scaled;
        let Command { speed, angle } = command;
        Self {
            time,
            position: Point::new(x, y).rotated(angle),
            velocity: Point::new(vx, vy).rotated(angle) * speed,
            spin: spin * speed,
        }
    }
}
