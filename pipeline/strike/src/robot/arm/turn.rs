//! An orientation, whatever the maker writes it as: roll, pitch and yaw, or a rotation vector.

use std::f64::consts::FRAC_PI_2;

/// A rotation, as a unit quaternion w, x, y, z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn([f64; 4]);

impl Turn {
    /// By roll, pitch and yaw about the fixed axes x, y and z, in rad.
    pub fn rpy([roll, pitch, yaw]: [f64; 3]) -> Self {
        let about = |axis: usize, angle: f64| {
            let mut vector = [0.0; 3];
            vector[axis] = angle;
            Self::vector(vector)
        };
        about(2, yaw).after(about(1, pitch)).after(about(0, roll))
    }

    /// By a rotation vector: its length is the angle in rad.
    pub fn vector(vector: [f64; 3]) -> Self {
        let angle = vector.iter().map(|v| v * v).sum::<f64>().sqrt();
        if angle < 1e-12 {
            return Self([1.0, 0.0, 0.0, 0.0]);
        }
        let (sin, cos) = (0.5 * angle).sin_cos();
        let [x, y, z] = vector.map(|v| v / angle * sin);
        Self([cos, x, y, z])
    }

    /// This rotation as a rotation vector of at most half a turn, in rad.
    pub fn to_vector(self) -> [f64; 3] {
        let [w, x, y, z] = if self.0[0] < 0.0 {
            self.0.map(|part| -part)
        } else {
            self.0
        };
        let sin = (x * x + y * y + z * z).sqrt();
        if sin < 1e-12 {
            return [0.0; 3];
        }
        let angle = 2.0 * f64::atan2(sin, w);
        [x, y, z].map(|v| v / sin * angle)
    }

    /// This rotation as roll, pitch and yaw about the fixed axes, in rad; the roll is 0 where the pitch is a quarter of a turn.
    pub fn to_rpy(self) -> [f64; 3] {
        let [w, x, y, z] = self.0;
        let sin = 2.0 * (w * y - z * x);
        if sin.abs() > 1.0 - 1e-9 {
            return [
                0.0,
                FRAC_PI_2.copysign(sin),
                f64::atan2(-2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z)),
            ];
        }
        [
            f64::atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
            sin.asin(),
            f64::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
        ]
    }

    /// Whether every number is finite.
    pub fn is_finite(self) -> bool {
        self.0.iter().all(|part| part.is_finite())
    }

    /// The angle in rad between two, at most half a turn.
    pub fn angle_to(self, other: Self) -> f64 {
        let dot: f64 = self.0.iter().zip(other.0).map(|(a, b)| a * b).sum();
        2.0 * dot.abs().min(1.0).acos()
    }

    /// This rotation after another one.
    fn after(self, first: Self) -> Self {
        let ([w, x, y, z], [a, b, c, d]) = (self.0, first.0);
        Self([
            w * a - x * b - y * c - z * d,
            w * b + x * a + y * d - z * c,
            w * c - x * d + y * a + z * b,
            w * d + x * c - y * b + z * a,
        ])
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn both_forms_are_one_rotation_whole_turns_and_signs_aside() {
        let down = Turn::rpy([PI, 0.0, 0.0]);
        assert!(down.angle_to(Turn::vector([PI, 0.0, 0.0])) < 1e-6);
        assert!(down.angle_to(Turn::rpy([-PI, 0.0, 0.0])) < 1e-6);
        assert!((down.angle_to(Turn::rpy([PI, 0.3, 0.0])) - 0.3).abs() < 1e-6);
        for rpy in [[0.1, -0.2, 0.3], [PI, 0.4, -2.0], [1.0, FRAC_PI_2, 0.5]] {
            let turn = Turn::rpy(rpy);
            assert!(
                Turn::vector(turn.to_vector()).angle_to(turn) < 1e-6,
                "{rpy:?}"
            );
            assert!(Turn::rpy(turn.to_rpy()).angle_to(turn) < 1e-4, "{rpy:?}");
        }
        // Roll comes first: after it, the yaw is about the fixed axis.
        let turned = Turn::rpy([FRAC_PI_2, 0.0, FRAC_PI_2]).to_vector();
        let third = 2.0 * PI / 3.0 / 3f64.sqrt();
        assert!(
            turned.iter().all(|v| (v.abs() - third).abs() < 1e-9),
            "{turned:?}"
        );
    }
}
