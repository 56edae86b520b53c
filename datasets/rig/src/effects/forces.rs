//! Effects that accelerate the object's centre.

use values::Point;

use super::acts::{Acts, GRAVITY};
use crate::declare::declare;

declare! {
    /// A film between object and table: a = −c·v, and the spin slows at the same rate by area.
    ViscousDrag = "viscous_drag" {
        c: 0.5, "1/s", Some(0.0);
    }

    fn acceleration(&self, _at: Point, velocity: Point, _time: f64) -> Point {
        velocity * -self.c
    }
    fn film(&self) -> f64 {
        self.c
    }
}

declare! {
    /// Drag with the square of speed: a = −k·|v|·v.
    QuadraticDrag = "quadratic_drag" {
        k: 0.6, "1/m", Some(0.0);
    }

    fn acceleration(&self, _at: Point, velocity: Point, _time: f64) -> Point {
        velocity * (-self.k * velocity.norm())
    }
}

declare! {
    /// The table leans: a = g·(sin t_x, sin t_y).
    TableTilt = "table_tilt" {
        /// Downhill towards +x, in rad.
        t_x: -0.003, "rad", Some(0.0);
        /// Downhill towards +y, in rad.
        t_y: 0.006, "rad", Some(0.0);
    }

    fn acceleration(&self, _at: Point, _velocity: Point, _time: f64) -> Point {
        Point::new(self.t_x.sin(), self.t_y.sin()) * GRAVITY
    }
}

declare! {
    /// The table sags: the slope of a paraboloid, a = −g·sin(atan(kappa·r)) towards its lowest point.
    TableBowl = "table_bowl" {
        kappa: 0.04, "1/m", Some(0.0);
        /// Lowest point, in m.
        center_x: 0.45, "m", None;
        center_y: 0.0, "m", None;
    }

    fn acceleration(&self, at: Point, _velocity: Point, _time: f64) -> Point {
        let slope = (at - Point::new(self.center_x, self.center_y)) * self.kappa;
        slope * (-GRAVITY / (1.0 + slope.dot(slope)).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn accelerations_follow_their_formulas() {
        let (at, v) = (Point::new(0.65, 0.1), Point::new(0.3, -0.4));
        assert!(
            ViscousDrag { c: 2.0 }
                .acceleration(at, v, 0.0)
                .distance(Point::new(-0.6, 0.8))
                < 1e-12
        );
        assert!(
            QuadraticDrag { k: 2.0 }
                .acceleration(at, v, 0.0)
                .distance(Point::new(-0.3, 0.4))
                < 1e-12
        );
        let tilt = TableTilt {
            t_x: 0.004,
            t_y: -0.002,
        }
        .acceleration(at, v, 0.0);
        assert!(tilt.distance(Point::new(0.004, -0.002) * GRAVITY) < 1e-6);
        let bowl = TableBowl {
            kappa: 0.04,
            center_x: 0.45,
            center_y: 0.0,
        }
        .acceleration(at, v, 0.0);
        assert!(bowl.distance(Point::new(-0.2, -0.1) * (0.04 * GRAVITY)) < 1e-4);
    }
}
