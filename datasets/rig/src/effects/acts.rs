//! Where an effect may act.

use values::{Command, Point};

use crate::StrikeIndex;

/// Standard gravity in m/s².
pub(crate) const GRAVITY: f64 = 9.806_65;

/// Where an effect may act; every step does nothing unless overridden.
pub(crate) trait Acts {
    /// The tip's speed and angle in place of the commanded ones, for an object that lies here (m).
    fn deliver(&self, command: Command, _from: Point, _when: StrikeIndex) -> Command {
        command
    }
    /// How far to the left of the centre the tip passes, in m.
    fn tip_offset(&self) -> f64 {
        0.0
    }
    /// Factor on the restitution at this speed of approach (m/s).
    fn restitution(&self, _speed: f64, _when: StrikeIndex) -> f64 {
        1.0
    }
    /// Factor on the friction of a whole strike.
    fn strike_friction(&self, _when: StrikeIndex) -> f64 {
        1.0
    }
    /// Whether [`Acts::local_friction`] or [`Acts::directional_friction`] differs over the base, with speed or direction.
    fn is_local(&self) -> bool {
        false
    }
    /// Factor on the friction of an element of the base here (m), sliding at this speed (m/s).
    fn local_friction(&self, _at: Point, _speed: f64) -> f64 {
        1.0
    }
    /// Factors on friction along two axes: the bearing of the first (rad), then both factors.
    fn grain(&self) -> Option<(f64, [f64; 2])> {
        None
    }
    /// Factor on the friction of an element that slides in this direction (a unit vector).
    fn directional_friction(&self, _direction: Point) -> f64 {
        1.0
    }
    /// Acceleration of the centre here (m), at this velocity (m/s), this long after the impact (s).
    fn acceleration(&self, _at: Point, _velocity: Point, _time: f64) -> Point {
        Point::default()
    }
    /// Rate at which a film slows motion, in 1/s: it acts on the spin too.
    fn film(&self) -> f64 {
        0.0
    }
    /// Where the camera, looking down on a centre (m), sees what lies here (m).
    fn see(&self, at: Point, _centre: Point, _when: StrikeIndex) -> Point {
        at
    }
    /// The finest length over which it changes, in m, where the integrator must step finely.
    fn grain_size(&self) -> f64 {
        f64::INFINITY
    }
}
