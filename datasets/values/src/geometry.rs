//! Points and displacements on the table.

use std::f64::consts::{PI, TAU};
use std::ops::{Add, Mul, Sub};

use serde::{Deserialize, Serialize};

use crate::exact::Exact;

/// An angle in rad, turned into (−π, π].
pub fn wrap_angle(angle: f64) -> f64 {
    let turned = angle.rem_euclid(TAU);
    if turned > PI { turned - TAU } else { turned }
}

/// A position or a displacement on the table, in metres; in files an array `[x, y]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "Exact<f64, 2>", into = "[f64; 2]")]
pub struct Point {
    /// Away from the robot, in metres.
    pub x: f64,
    /// To the robot's left, in metres.
    pub y: f64,
}

impl Point {
    /// The point (x, y), in metres.
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    /// The point at this distance (m) and bearing (rad, from +x) from the origin.
    pub fn polar(distance: f64, bearing: f64) -> Self {
        Self::new(distance * bearing.cos(), distance * bearing.sin())
    }

    /// Length in metres.
    pub fn norm(self) -> f64 {
        // Positions and speeds of a table cannot overflow a square; this takes a fifth of `hypot`'s time.
        self.dot(self).sqrt()
    }

    /// Direction in radians from +x, counter-clockwise.
    pub fn bearing(self) -> f64 {
        self.y.atan2(self.x)
    }

    /// Distance to another point, in metres.
    pub fn distance(self, other: Point) -> f64 {
        (self - other).norm()
    }

    /// Scalar product, in square metres.
    pub fn dot(self, other: Point) -> f64 {
        self.x * other.x + self.y * other.y
    }

    /// Turned counter-clockwise about the origin by an angle in radians.
    pub fn rotated(self, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self::new(cos * self.x - sin * self.y, sin * self.x + cos * self.y)
    }

    /// Whether both coordinates are finite numbers.
    pub fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite()
    }
}

impl Add for Point {
    type Output = Point;
    fn add(self, other: Point) -> Point {
        Point::new(self.x + other.x, self.y + other.y)
    }
}

impl Sub for Point {
    type Output = Point;
    fn sub(self, other: Point) -> Point {
        Point::new(self.x - other.x, self.y - other.y)
    }
}

impl Mul<f64> for Point {
    type Output = Point;
    fn mul(self, factor: f64) -> Point {
        Point::new(self.x * factor, self.y * factor)
    }
}

impl From<Exact<f64, 2>> for Point {
    fn from(Exact(numbers): Exact<f64, 2>) -> Self {
        numbers.into()
    }
}

impl From<[f64; 2]> for Point {
    fn from([x, y]: [f64; 2]) -> Self {
        Self::new(x, y)
    }
}

impl From<Point> for [f64; 2] {
    fn from(point: Point) -> Self {
        [point.x, point.y]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_angle_is_turned_into_one_circle() {
        assert_eq!([PI, -PI, 0.0].map(wrap_angle), [PI, PI, 0.0]);
        assert!((wrap_angle(-0.3) + 0.3).abs() < 1e-12);
        assert!((wrap_angle(7.0 - 6.0 * TAU) - (7.0 - TAU)).abs() < 1e-9);
    }
}
