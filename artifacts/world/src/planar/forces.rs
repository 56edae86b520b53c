//! What acts on an object that slides.

use values::{Conditions, Point};

use super::world::Planar;
use crate::{GRAVITY, effects::Slide};

#[derive(Clone, Copy)]
pub(super) struct Body {
    pub(super) position: Point,
    pub(super) velocity: Point,
    pub(super) spin: f64,
}

#[derive(Clone, Copy, Default)]
pub(super) struct Rate {
    pub(super) velocity: Point,
    pub(super) acceleration: Point,
    pub(super) turning: f64,
}

impl Body {
    pub(super) fn along(self, rate: &Rate, t: f64) -> Self {
        Self {
            position: self.position + rate.velocity * t,
            velocity: self.velocity + rate.acceleration * t,
            spin: self.spin + rate.turning * t,
        }
    }
}

/// What acts during one slide.
pub(super) struct Forces<'s> {
    pub(super) planar: &'s Planar<'s>,
    conditions: &'s Conditions,
    /// The table's deceleration before any effect in m/s²: this strike's own friction.
    dry: f64,
    /// Factor on friction, and force per unit mass in m/s², of what is the same all through it.
    factor: f64,
    force: Point,
    /// Square of the base's arm over that of the radius of gyration.
    leverage: f64,
}

impl<'s> Forces<'s> {
    /// `friction`: the logarithm of this strike's factor on the world's friction.
    pub(super) fn new(planar: &'s Planar<'s>, conditions: &'s Conditions, friction: f64) -> Self {
        let dry = planar.friction * GRAVITY * friction.exp();
        let mut slide = Slide {
            position: Point::default(),
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
    pub(super) fn rate(&self, t: f64, body: &Body) -> Rate {
        let planar = self.planar;
        let mut slide = Slide {
            position: body.position,
            velocity: body.velocity,
            spin: body.spin,
            dry: self.dry,
            conditions: self.conditions,
        };
        let mut dry = slide.dry * self.factor;
        for effect in &planar.varying {
            dry *= effect.friction_factor(&slide);
        }
        slide.dry = dry;
        let mut acceleration = self.force;
        for effect in &planar.varying {
            acceleration = acceleration + effect.acceleration(&slide);
        }
        if let Some(push) = planar.push {
            acceleration = acceleration + push(t, body.position, body.velocity);
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
