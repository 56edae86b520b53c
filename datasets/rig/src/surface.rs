//! What acts on the sliding object: friction at each element of its base, and accelerations of its centre.

use values::Point;

use crate::effects::{Acts, GRAVITY};
use crate::{FenceTruth, Hidden, StrikeIndex};

/// Below this speed (m/s) an element counts as not moving, and no direction opposes it.
const STILL: f64 = 1e-9;
/// How many integration steps fall into the finest length over which an effect changes.
const STEPS_A_GRAIN: f64 = 3.0;
/// The longest step in s: RK4 at it moves the stop by less than 0.05 mm (tested).
const LONGEST_STEP: f64 = 2e-3;
/// The shortest step in s.
const SHORTEST_STEP: f64 = 1e-4;

/// The table during one strike.
pub(crate) struct Surface<'a> {
    friction: f64,
    local: Vec<&'a dyn Acts>,
    grains: Vec<(f64, [f64; 2])>,
    acting: Vec<&'a dyn Acts>,
    film: f64,
    grain_size: f64,
    fences: &'a [FenceTruth],
}

impl<'a> Surface<'a> {
    pub(crate) fn new(friction: f64, hidden: &'a Hidden, index: StrikeIndex) -> Self {
        Self {
            friction: hidden.acts().fold(friction, |friction, effect| {
                friction * effect.strike_friction(index)
            }),
            local: hidden.acts().filter(|effect| effect.is_local()).collect(),
            grains: hidden.acts().filter_map(Acts::grain).collect(),
            acting: hidden.acts().collect(),
            film: hidden.acts().map(Acts::film).sum(),
            grain_size: hidden
                .acts()
                .map(Acts::grain_size)
                .fold(f64::INFINITY, f64::min),
            fences: &[],
        }
    }

    pub(crate) fn with_fences(self, fences: &'a [FenceTruth]) -> Self {
        Self { fences, ..self }
    }

    /// Velocity of a body with an edge at `reach` (m), once it has met the fences that it touches.
    pub(crate) fn fenced(&self, at: Point, velocity: Point, reach: f64) -> Point {
        let turned = |velocity, fence: &FenceTruth| {
            fence.turned_back(at, velocity, reach).unwrap_or(velocity)
        };
        self.fences.iter().fold(velocity, turned)
    }

    /// Whether friction is the same all over the base, whatever its speed.
    pub(crate) fn is_uniform(&self) -> bool {
        self.local.is_empty() && self.grains.is_empty()
    }

    /// The step for an object that starts at this speed (m/s), in s.
    pub(crate) fn step(&self, speed: f64) -> f64 {
        (self.grain_size / STEPS_A_GRAIN / speed.max(0.1)).clamp(SHORTEST_STEP, LONGEST_STEP)
    }

    /// Deceleration by friction where nothing local acts, in m/s².
    pub(crate) fn deceleration(&self) -> f64 {
        self.friction * GRAVITY
    }

    /// Coefficient of friction of an element here, sliding at this speed.
    pub(crate) fn friction(&self, at: Point, speed: f64) -> f64 {
        self.local
            .iter()
            .fold(self.friction, |friction, effect| {
                friction * effect.local_friction(at, speed)
            })
            .max(0.0)
    }

    /// Friction's acceleration of the mass over an element that slides here at this velocity, in m/s².
    pub(crate) fn drag(&self, at: Point, velocity: Point) -> Point {
        // Not `hypot`, which guards against overflow and takes most of the time here.
        let speed = velocity.dot(velocity).sqrt();
        if speed < STILL {
            return Point::default();
        }
        let direction =
            self.grains
                .iter()
                .fold(velocity * (1.0 / speed), |along, &(bearing, factors)| {
                    let turned = along.rotated(-bearing);
                    // Normal to the ellipse of limit forces: the force that opposes this slip at most power.
                    let squared = Point::new(
                        factors[0] * factors[0] * turned.x,
                        factors[1] * factors[1] * turned.y,
                    );
                    let power = Point::new(factors[0] * turned.x, factors[1] * turned.y).norm();
                    (squared * (1.0 / power)).rotated(bearing)
                });
        let along = self.local.iter().fold(GRAVITY, |pressure, effect| {
            pressure * effect.directional_friction(velocity * (1.0 / speed))
        });
        direction * (-along * self.friction(at, speed))
    }

    /// Acceleration of the centre by all but friction, in m/s².
    pub(crate) fn acceleration(&self, at: Point, velocity: Point, time: f64) -> Point {
        self.acting.iter().fold(Point::default(), |sum, effect| {
            sum + effect.acceleration(at, velocity, time)
        })
    }

    /// Rate at which a film slows the spin of a base, in 1/s, before its moments.
    pub(crate) fn film(&self) -> f64 {
        self.film
    }
}
