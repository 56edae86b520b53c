//! What an effect does to a strike, and where.

use values::{Command, Conditions, Point};

/// Distance, in m, at which [`unobserve`] ends: far below what any camera sees and well above the rounding of a position.
const UNOBSERVE_TOLERANCE: f64 = 1e-13;
/// Greatest number of steps of [`unobserve`]: enough for the most distorted lens of the library, each step of which takes away a third of the error.
const UNOBSERVE_STEPS: u32 = 100;

/// The object while it slides.
#[derive(Clone, Copy, Debug)]
pub struct Slide<'a> {
    /// Centre in m.
    pub position: Point,
    /// Where it was struck, in m.
    pub from: Point,
    /// Velocity in m/s.
    pub velocity: Point,
    /// Turning in rad/s, to the left.
    pub spin: f64,
    /// Deceleration by dry friction alone, in m/s²: μ·g of the world without effects for [`Effect::friction_factor`], and
    /// that times the factors of all effects for [`Effect::acceleration`].
    pub dry: f64,
    /// When and in which session.
    pub conditions: &'a Conditions,
}

/// Where an effect acts, so that a simulation need ask it nowhere else.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acts {
    /// On the command or the impact.
    Launch,
    /// On friction or force, by a strike's conditions alone: the same all through one slide.
    Strike,
    /// On friction or force, by where the object is and how fast.
    Slide,
    /// On the measurement.
    Camera,
}

/// What an effect does to a strike; each method does nothing unless the effect says otherwise.
pub trait Effect: Send + Sync {
    /// The place where the effect acts; everywhere else it does nothing.
    fn acts(&self) -> Acts;

    /// The command that the arm delivers in place of the one it was given, to an object that lies at `from` (m).
    fn deliver(&self, command: Command, _from: Point, _conditions: &Conditions) -> Command {
        command
    }

    /// Lateral offset of the tip's line, in m to the left of the direction of approach.
    fn tip_offset(&self) -> f64 {
        0.0
    }

    /// Logarithm of a factor on friction between tip and object.
    fn tip_friction(&self) -> f64 {
        0.0
    }

    /// Factor on restitution at an impact speed in m/s.
    fn restitution_factor(&self, _impact_speed: f64, _conditions: &Conditions) -> f64 {
        1.0
    }

    /// Factor on the friction between object and table.
    fn friction_factor(&self, _slide: &Slide<'_>) -> f64 {
        1.0
    }

    /// Distance in m within which what it does on the table is smooth, from an object's centre at `position`.
    fn stretch(&self, _position: Point) -> f64 {
        f64::INFINITY
    }

    /// Force on the object per unit mass, in m/s².
    fn acceleration(&self, _slide: &Slide<'_>) -> Point {
        Point::default()
    }

    /// Angle (rad) by which the camera sees every object turned.
    fn seen_turn(&self) -> f64 {
        0.0
    }

    /// Position (m) at which the camera sees an object that is at `point` (m).
    fn observe(&self, point: Point) -> Point {
        point
    }
}

/// What the arm makes of a command with these effects, where it strikes an object that lies at `from` (m), in the session and at the
/// time of `conditions`.
pub fn deliver(
    effects: &[Box<dyn Effect>],
    command: Command,
    from: Point,
    conditions: &Conditions,
) -> Command {
    effects.iter().fold(command, |command, effect| {
        effect.deliver(command, from, conditions)
    })
}

/// Where the camera sees an object that is at `point` (m), with these effects.
pub fn observe(effects: &[Box<dyn Effect>], point: Point) -> Point {
    effects
        .iter()
        .fold(point, |seen, effect| effect.observe(seen))
}

/// Position (m) of an object that the camera sees at `seen` (m): a fixed point, for the measurement changes little.
pub fn unobserve(effects: &[Box<dyn Effect>], seen: Point) -> Point {
    let mut point = seen;
    for _ in 0..UNOBSERVE_STEPS {
        let error = seen - observe(effects, point);
        point = point + error;
        if error.norm() < UNOBSERVE_TOLERANCE {
            break;
        }
    }
    point
}
