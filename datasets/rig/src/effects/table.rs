//! Tables that are neither a plane nor a paraboloid.

use values::Point;

use super::acts::{Acts, GRAVITY};
use super::place::waves;
use crate::declare::declare;

declare! {
    /// A table that leans and is warped: its slope changes over it, as that of a board with one corner lifted.
    WarpedTilt = "warped_tilt" {
        /// Downhill towards +x in the middle, in rad.
        t_x: -0.003, "rad", Some(0.0);
        /// Downhill towards +y in the middle, in rad.
        t_y: 0.006, "rad", Some(0.0);
        /// Slope along x that is added for each metre of y, and the other way round, in 1/m.
        warp: 0.006, "1/m", Some(0.0);
    }

    fn acceleration(&self, at: Point, _velocity: Point, _time: f64) -> Point {
        let (x, y) = (at.x - 0.45, at.y);
        Point::new(self.t_x + self.warp * y, self.t_y + self.warp * x) * GRAVITY
    }
}

declare! {
    /// A sag with a flat rim: a slope that rises as a sine and falls to nothing again at its radius.
    SineBowl = "sine_bowl" {
        /// Curvature at the bottom, in 1/m.
        kappa: 0.05, "1/m", Some(0.0);
        /// Lowest point, in m.
        center_x: 0.45, "m", None;
        center_y: 0.0, "m", None;
        /// Where the table is flat again, in m.
        radius: 0.7, "m", None;
    }

    fn acceleration(&self, at: Point, _velocity: Point, _time: f64) -> Point {
        let arm = at - Point::new(self.center_x, self.center_y);
        let distance = arm.norm();
        if distance < 1e-9 || distance > self.radius {
            return Point::default();
        }
        let phase = std::f64::consts::PI / self.radius;
        let slope = self.kappa * (phase * distance).sin() / phase;
        arm * (-GRAVITY * slope / distance)
    }
}

declare! {
    /// A long sag: the table is bent along one direction alone.
    Trough = "trough" {
        kappa: 0.05, "1/m", Some(0.0);
        /// Where its lowest line passes, in m.
        center_x: 0.45, "m", None;
        /// Where its lowest line passes, in m.
        center_y: 0.0, "m", None;
        /// Bearing across the lowest line, in rad.
        bearing: 0.3, "rad", None;
    }

    fn acceleration(&self, at: Point, _velocity: Point, _time: f64) -> Point {
        let across = Point::polar(1.0, self.bearing);
        let arm = at - Point::new(self.center_x, self.center_y);
        across * (-GRAVITY * self.kappa * arm.dot(across))
    }
}

declare! {
    /// A saddle: the table is bent up along one direction, and down as much across it.
    Saddle = "saddle" {
        kappa: 0.05, "1/m", Some(0.0);
        center_x: 0.45, "m", None;
        center_y: 0.0, "m", None;
        /// Bearing along which it rises, in rad.
        bearing: 0.3, "rad", None;
    }

    fn acceleration(&self, at: Point, _velocity: Point, _time: f64) -> Point {
        let arm = (at - Point::new(self.center_x, self.center_y)).rotated(-self.bearing);
        Point::new(-arm.x, arm.y).rotated(self.bearing) * (GRAVITY * self.kappa)
    }
}

declare! {
    /// A table with bumps: its height is a smooth random field.
    TableMap = "table_map" {
        /// Standard deviation of the slope along any direction.
        slope: 0.01, "1", Some(0.0);
        /// Length over which the height changes, in m.
        length: 0.15, "m", None;
        /// Which field, any number.
        seed: 1.0, "1", None;
    }

    fn acceleration(&self, at: Point, _velocity: Point, _time: f64) -> Point {
        // Minus the gradient of slope·length·Σ size·cos(k·p/length + phase), times gravity.
        waves(self.seed).fold(Point::default(), |sum, (vector, phase, size)| {
            let steep = size * (vector.dot(at) / self.length + phase).sin();
            sum + vector * (GRAVITY * self.slope * steep)
        })
    }
    fn grain_size(&self) -> f64 {
        0.2 * self.length
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pull(effect: &dyn Acts, x: f64, y: f64) -> Point {
        effect.acceleration(Point::new(x, y), Point::default(), 0.0) * (1.0 / GRAVITY)
    }

    #[test]
    fn a_warped_table_leans_otherwise_elsewhere() {
        let tilt = WarpedTilt::default();
        assert!(pull(&tilt, 0.45, 0.0).distance(Point::new(-0.003, 0.006)) < 1e-12);
        assert!(pull(&tilt, 0.45, 0.5).distance(Point::new(0.0, 0.006)) < 1e-12);
    }

    #[test]
    fn sags_pull_towards_their_lowest_place() {
        let bowl = SineBowl::default();
        assert!(pull(&bowl, 0.46, 0.0).distance(Point::new(-0.0005, 0.0)) < 1e-6);
        assert!(pull(&bowl, 0.45 + 0.71, 0.0).norm() < 1e-12);
        let trough = Trough {
            bearing: 0.0,
            ..Trough::default()
        };
        assert!(pull(&trough, 0.55, 0.3).distance(Point::new(-0.005, 0.0)) < 1e-12);
    }
}
