//! What acts on an object that slides.

use std::ops::Mul;

use values::{Conditions, Point};

use super::world::Planar;
use crate::{GRAVITY, effects::Slide};

#[derive(Clone, Copy)]
pub(super) struct Body {
    pub(super) position: Point,
    pub(super) velocity: Point,
    pub(super) spin: f64,
}

/// Rate of change of a sliding object's position (m/s), velocity (m/s²) and spin (rad/s²).
#[derive(Clone, Copy, Debug, Default)]
pub struct Rate {
    pub(super) velocity: Point,
    pub(super) acceleration: Point,
    pub(super) turning: f64,
}

impl Rate {
    pub(super) fn less(self, other: &Self) -> Self {
        Self {
            velocity: self.velocity - other.velocity,
            acceleration: self.acceleration - other.acceleration,
            turning: self.turning - other.turning,
        }
    }
}

impl Mul<f64> for Rate {
    type Output = Self;

    fn mul(self, by: f64) -> Self {
        Self {
            velocity: self.velocity * by,
            acceleration: self.acceleration * by,
            turning: self.turning * by,
        }
    }
}

impl Body {
    pub(super) fn along(self, rate: &Rate, t: f64) -> Self {
        Self {
            position: self.position + rate.velocity * t,
            velocity: self.velocity + rate.acceleration * t,
            spin: self.spin + rate.turning * t,
        }
    }

    /// The state after a step, by the rates at its beginning, twice in its middle, and at its end (Runge and Kutta).
    #[inline(always)]
    pub(super) fn stepped(&self, [first, second, third, fourth]: [&Rate; 4], step: f64) -> Self {
        let sum = |a: Point, b: Point, c: Point, d: Point| a + (b + c) * 2.0 + d;
        let sixth = step / 6.0;
        Self {
            position: self.position
                + sum(
                    first.velocity,
                    second.velocity,
                    third.velocity,
                    fourth.velocity,
                ) * sixth,
            velocity: self.velocity
                + sum(
                    first.acceleration,
                    second.acceleration,
                    third.acceleration,
                    fourth.acceleration,
                ) * sixth,
            spin: self.spin
                + (first.turning + 2.0 * (second.turning + third.turning) + fourth.turning) * sixth,
        }
    }

    /// The state in the middle of a step, interpolated from both ends.
    pub(super) fn between(a: &Self, at_a: &Rate, b: &Self, at_b: &Rate, step: f64) -> Self {
        let eighth = step / 8.0;
        Self {
            position: (a.position + b.position) * 0.5 + (a.velocity - b.velocity) * eighth,
            velocity: (a.velocity + b.velocity) * 0.5
                + (at_a.acceleration - at_b.acceleration) * eighth,
            spin: (a.spin + b.spin) * 0.5 + (at_a.turning - at_b.turning) * eighth,
        }
    }
}

/// What acts during one slide.
pub(super) struct Forces<'s> {
    pub(super) planar: &'s Planar<'s>,
    conditions: &'s Conditions,
    /// Where the object was struck, in m.
    pub(super) from: Point,
    /// The table's deceleration before any effect in m/s²: this strike's own friction.
    dry: f64,
    /// Factor on friction, and force per unit mass in m/s², of effects that are constant during the slide.
    factor: f64,
    force: Point,
    /// Square of the base's arm over that of the radius of gyration.
    leverage: f64,
}

impl<'s> Forces<'s> {
    /// `from`: where the object was struck, in m; `friction`: the logarithm of this strike's factor on the world's friction.
    pub(super) fn new(
        planar: &'s Planar<'s>,
        conditions: &'s Conditions,
        from: Point,
        friction: f64,
    ) -> Self {
        let dry = planar.friction * GRAVITY * friction.exp();
        let mut slide = Slide {
            position: from,
            from,
            velocity: Point::default(),
            spin: 0.0,
            dry,
            conditions,
        };
        let even = planar.even.iter();
        let factor = even.map(|e| e.friction_factor(&slide)).product();
        slide.dry *= factor;
        let even = planar.even.iter();
        Self {
            planar,
            conditions,
            from,
            dry,
            factor,
            force: even.fold(Point::default(), |sum, e| sum + e.acceleration(&slide)),
            leverage: planar.base.arm.powi(2) / planar.gyration,
        }
    }

    /// Deceleration by dry friction in m/s², and force per unit mass in m/s², by what is the same all through the slide.
    pub(super) fn even(&self) -> (f64, Point) {
        (self.dry * self.factor, self.force)
    }

    #[inline(always)]
    pub(super) fn rate(&self, body: &Body) -> Rate {
        self.rubbed(body, 1.0)
    }

    /// Deceleration by dry friction in m/s², of all effects.
    pub(super) fn dry(&self, body: &Body) -> f64 {
        let slide = self.slide(body);
        let varying = self.planar.varying.iter();
        varying.fold(self.dry * self.factor, |dry, e| {
            dry * e.friction_factor(&slide)
        })
    }

    fn slide(&self, body: &Body) -> Slide<'_> {
        Slide {
            position: body.position,
            from: self.from,
            velocity: body.velocity,
            spin: body.spin,
            dry: self.dry,
            conditions: self.conditions,
        }
    }

    /// Rates of a body under `share` times its dry friction.
    #[inline(always)]
    pub(super) fn rubbed(&self, body: &Body, share: f64) -> Rate {
        let planar = self.planar;
        let mut slide = self.slide(body);
        let mut dry = slide.dry * self.factor * share;
        for effect in &planar.varying {
            dry *= effect.friction_factor(&slide);
        }
        slide.dry = dry;
        let mut acceleration = self.force;
        for effect in &planar.varying {
            acceleration = acceleration + effect.acceleration(&slide);
        }
        let base = &planar.base;
        let rim = base.arm * body.spin;
        let [pull, turning] = base.pull(body.velocity.dot(body.velocity), rim * rim);
        Rate {
            velocity: body.velocity,
            acceleration: acceleration - body.velocity * (dry * pull),
            turning: -dry * turning * body.spin * self.leverage,
        }
    }

    /// Distance in m that one step may go from a position.
    pub(super) fn stretch(&self, position: Point) -> f64 {
        let each = self.planar.varying.iter();
        each.fold(f64::INFINITY, |least, e| least.min(e.stretch(position)))
    }
}
