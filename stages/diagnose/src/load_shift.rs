//! The load that a box shifts to its front edge as the table brakes it.
//!
//! Braked at its base with μ·g, a box whose centre of mass is h above the table presses on it μ·h before its centre. There its base moves
//! aside where the box turns, and is rubbed against that: by μ·g·(μ·h)·ω/|v| to the right of its way where it turns to the left, which bends
//! the way (so curling stones are explained, Johnston 1981). A box that is 6 to 12 mm high stops a few millimetres aside. The world
//! presses evenly, and what the shift does would be taken for grain or a tilt. How much of it there is, is free in every model of a box: an
//! embedded rig has none, a rigid box all of it.

use values::Point;
use world::{
    GRAVITY,
    effects::{Acts, Effect, Slide},
};

/// Speed in m/s below which a box is as good as at rest, and turns as it slides.
const LEAST_SPEED: f64 = 0.01;

/// A part of the shift, of a box that weighs evenly.
pub(crate) struct LoadShift {
    /// 1 for all of it.
    pub(crate) part: f64,
    /// Height of the centre of mass above the table, in m.
    pub(crate) height: f64,
    /// Mean distance of the base's elements from its centre, in m.
    pub(crate) arm: f64,
}

impl Effect for LoadShift {
    fn acts(&self) -> Acts {
        Acts::Slide
    }

    fn acceleration(&self, slide: &Slide<'_>) -> Point {
        let Slide {
            velocity,
            spin,
            dry,
            ..
        } = *slide;
        let shift = self.part * self.height * dry / GRAVITY;
        // A base that turns faster than it slides is rubbed aside no more.
        let speed = velocity.norm();
        let slip = speed.hypot(self.arm * spin).max(LEAST_SPEED);
        let to_left = Point::new(-velocity.y, velocity.x) * speed.max(LEAST_SPEED).recip();
        to_left * (-dry * shift * spin / slip)
    }
}

#[cfg(test)]
mod tests {
    use values::Conditions;

    use super::*;

    /// Force per unit mass by even pressure and a part that rises towards the front by so much that its centre lies `shift` before the box's.
    fn summed(half: f64, shift: f64, velocity: Point, spin: f64, dry: f64) -> Point {
        let cells = 40;
        let along = velocity * velocity.norm().recip();
        let at = |i: i32| half * (f64::from(2 * i + 1) / f64::from(cells) - 1.0);
        let mut force = Point::default();
        for i in 0..cells * cells {
            let r = Point::new(at(i % cells), at(i / cells));
            let pressure = 1.0 + shift * r.dot(along) / (half * half / 3.0);
            let slip = velocity + Point::new(-r.y, r.x) * spin;
            force = force + slip * (-dry * pressure / slip.norm().max(1e-12));
        }
        force * f64::from(cells * cells).recip()
    }

    #[test]
    fn it_bends_the_way_as_the_pressure_under_a_box_does() {
        let (half, height, friction) = (0.03, 0.01, 0.3);
        let dry = friction * GRAVITY;
        let shift = LoadShift {
            part: 1.0,
            height,
            arm: 0.765 * half,
        };
        for (speed, spin) in [(0.6, 4.0), (0.4, -8.0), (0.2, 5.0)] {
            let velocity = Point::polar(speed, 0.4);
            let summed = |shift| summed(half, shift, velocity, spin, dry);
            let aside = summed(friction * height) - summed(0.0);
            let found = shift.acceleration(&Slide {
                position: Point::default(),
                from: Point::default(),
                velocity,
                spin,
                dry,
                conditions: &Conditions::default(),
            });
            let off = (found - aside).norm() / aside.norm();
            assert!(
                off < 0.25,
                "{speed} m/s, {spin} rad/s: {found:?}, {aside:?}"
            );
        }
    }
}
