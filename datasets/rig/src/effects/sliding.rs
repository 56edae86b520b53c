//! Sliding friction and drag by other laws than the usual ones.

use values::Point;

use super::acts::Acts;
use crate::declare::declare;

declare! {
    /// Friction is higher at low speed, by a rational curve: a factor 1 + delta/(1 + (v/v_s)^exponent).
    RationalStribeck = "rational_stribeck" {
        /// Relative rise at rest.
        delta: 0.3, "1", Some(0.0);
        /// Speed at which half of the rise is left, in m/s.
        v_s: 0.35, "m/s", None;
        exponent: 2.0, "1", None;
    }

    fn is_local(&self) -> bool {
        true
    }
    fn local_friction(&self, _at: Point, speed: f64) -> f64 {
        1.0 + self.delta / (1.0 + (speed / self.v_s).powf(self.exponent))
    }
}

/// Below this speed friction rises no more, in m/s.
const CREEP: f64 = 0.02;

declare! {
    /// Friction falls with the logarithm of speed, as rate-and-state friction does: a factor 1 + rate·ln(v_ref/(v + 0.02 m/s)).
    LogarithmicStribeck = "logarithmic_stribeck" {
        /// Relative rise for each factor e that the speed falls by.
        rate: 0.10, "1", Some(0.0);
        /// Speed at which friction is the rig's own, in m/s.
        v_ref: 0.6, "m/s", None;
    }

    fn is_local(&self) -> bool {
        true
    }
    fn local_friction(&self, _at: Point, speed: f64) -> f64 {
        // The integrator asks at infinite speed for friction without what depends on it.
        let speed = speed.min(10.0);
        (1.0 + self.rate * (self.v_ref / (speed + CREEP)).ln()).max(0.1)
    }
}

declare! {
    /// Drag with any power of speed: a = −coefficient·|v|^exponent along v.
    PowerDrag = "power_drag" {
        /// In m/s² at 1 m/s.
        coefficient: 0.5, "m/s2", Some(0.0);
        /// Power of the speed.
        exponent: 1.5, "1", None;
    }

    fn acceleration(&self, _at: Point, velocity: Point, _time: f64) -> Point {
        let speed = velocity.norm();
        if speed < 1e-6 {
            return Point::default();
        }
        velocity * (-self.coefficient * speed.powf(self.exponent - 1.0))
    }
}

declare! {
    /// Friction depends on the direction of motion and opposes it, without the force across that an elliptic law has: a factor
    /// 1 − contrast/2·cos 2(bearing − direction).
    CosineGrain = "cosine_grain" {
        /// Friction across less friction along, over their mean.
        contrast: 0.14, "1", Some(0.0);
        /// Bearing of the grain, in rad.
        direction: 0.5, "rad", None;
    }

    fn is_local(&self) -> bool {
        true
    }
    fn directional_friction(&self, direction: Point) -> f64 {
        1.0 - self.contrast / 2.0 * (2.0 * (direction.bearing() - self.direction)).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curves_pass_through_the_points_that_name_their_parameters() {
        let rational = RationalStribeck::default();
        assert!((rational.local_friction(Point::default(), 0.0) - 1.3).abs() < 1e-12);
        assert!((rational.local_friction(Point::default(), 0.35) - 1.15).abs() < 1e-12);
        let logarithmic = LogarithmicStribeck::default();
        assert!((logarithmic.local_friction(Point::default(), 0.58) - 1.0).abs() < 1e-12);
        assert!(logarithmic.local_friction(Point::default(), 0.1) > 1.1);
        assert!(logarithmic.local_friction(Point::default(), f64::INFINITY) >= 0.1);
    }

    #[test]
    fn power_drag_follows_its_exponent() {
        let drag = PowerDrag::default();
        let at = |speed| {
            drag.acceleration(Point::default(), Point::new(speed, 0.0), 0.0)
                .x
        };
        assert!((at(1.0) + 0.5).abs() < 1e-12);
        assert!((at(0.25) + 0.5 * 0.125).abs() < 1e-12);
        assert_eq!(at(0.0), 0.0);
    }

    #[test]
    fn the_cosine_grain_is_lowest_along_and_highest_across() {
        let grain = CosineGrain::default();
        let along = grain.directional_friction(Point::polar(1.0, 0.5));
        let across =
            grain.directional_friction(Point::polar(1.0, 0.5 + std::f64::consts::FRAC_PI_2));
        assert!((along - 0.93).abs() < 1e-6 && (across - 1.07).abs() < 1e-6);
    }
}
