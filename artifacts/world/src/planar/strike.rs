//! One strike as planar form takes it, and what comes of it.

use values::{Command, Conditions, Point, Strike};

/// What one strike is simulated from, and when it is looked at.
#[derive(Clone, Copy, Debug)]
pub struct StrikeInput<'a> {
    /// Where the camera sees the object at rest, in m.
    pub initial: Point,
    /// The command that the arm is sent.
    pub command: Command,
    /// Session and order.
    pub conditions: &'a Conditions,
    /// Seconds at which the object is looked at, rising, by the track's clock.
    pub times: &'a [f64],
    /// Whether it is followed to its rest; else to the last of these times.
    pub to_rest: bool,
}

impl<'a> From<&'a Strike> for StrikeInput<'a> {
    /// A logged strike, at its own frames.
    fn from(strike: &'a Strike) -> Self {
        Self {
            initial: strike.initial,
            command: strike.command,
            conditions: &strike.conditions,
            times: &strike.track.t,
            to_rest: strike.has_stop(),
        }
    }
}

/// How one strike differs from what was commanded and measured.
#[derive(Clone, Copy, Debug, Default)]
pub struct Deviation {
    /// Logarithm of the factor on speed.
    pub speed: f64,
    /// Angle in rad.
    pub angle: f64,
    /// Seconds from touch to the track's zero.
    pub delay: f64,
    /// Error of the resting place, in m.
    pub rest: Point,
    /// Logarithm of the factor on friction.
    pub friction: f64,
}

/// A strike's frames as simulated.
#[derive(Clone, Debug, Default)]
pub struct Frames {
    /// Seen centroids, in m.
    pub at: Vec<Point>,
    /// Their rates of change, in m/s.
    pub rate: Vec<Point>,
    /// Where it is seen at rest, in m; at the last frame, where it is followed no farther.
    pub stop: Point,
}

impl Frames {
    pub(super) fn push(&mut self, at: Point, rate: Point) {
        self.at.push(at);
        self.rate.push(rate);
    }
}
