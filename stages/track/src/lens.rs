//! A lens: from directions to pixels and back.
//!
//! Source: `plumb_bob` of ROS and OpenCV (Brown 1971): with (u, v) = (X/Z, Y/Z) and r² = u² + v²,
//! u' = u·(1 + k1·r² + k2·r⁴ + k3·r⁶) + 2·p1·u·v + p2·(r² + 2u²), v' likewise, pixel = (fx·u' + cx, fy·v' + cy).

/// Camera matrix and distortion. Pixel centres are whole numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// `[fx, fy, cx, cy]` in px.
    pub matrix: [f64; 4],
    /// `[k1, k2, p1, p2, k3]`.
    pub distortion: [f64; 5],
}

/// Newton steps of [`Lens::direction`]; each squares the error.
const STEPS: usize = 8;

impl Lens {
    /// The pixel in which a direction (u, v) = (X/Z, Y/Z) is seen.
    pub fn pixel(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let [fx, fy, cx, cy] = self.matrix;
        let [du, dv] = self.distorted([u, v]);
        [fx * du + cx, fy * dv + cy]
    }

    /// How the pixel moves with the direction: d pixel / d (u, v), rows x and y.
    pub(crate) fn slope(&self, [u, v]: [f64; 2]) -> [[f64; 2]; 2] {
        let [fx, fy, ..] = self.matrix;
        let [[a, b], [c, d]] = self.distorted_slope([u, v]);
        [[fx * a, fx * b], [fy * c, fy * d]]
    }

    /// The direction that is seen in a pixel, to 1e-9 where the lens does not fold the image over.
    pub fn direction(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [fx, fy, cx, cy] = self.matrix;
        let seen = [(x - cx) / fx, (y - cy) / fy];
        let mut at = seen;
        for _ in 0..STEPS {
            let [du, dv] = self.distorted(at);
            let [[a, b], [c, d]] = self.distorted_slope(at);
            let [eu, ev] = [seen[0] - du, seen[1] - dv];
            let determinant = a * d - b * c;
            if determinant.abs() < 1e-6 {
                break;
            }
            at[0] += (d * eu - b * ev) / determinant;
            at[1] += (a * ev - c * eu) / determinant;
        }
        at
    }

    /// How far it bends the corners of an image about its principal point, of their distance from there.
    pub(crate) fn bend(&self) -> f64 {
        let [fx, fy, cx, cy] = self.matrix;
        let corner = [cx / fx, cy / fy];
        let [u, v] = self.distorted(corner);
        (u - corner[0]).hypot(v - corner[1]) / corner[0].hypot(corner[1]).max(1e-9)
    }

    fn distorted(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let [k1, k2, p1, p2, k3] = self.distortion;
        let r2 = u * u + v * v;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        [
            u * radial + 2.0 * p1 * u * v + p2 * (r2 + 2.0 * u * u),
            v * radial + p1 * (r2 + 2.0 * v * v) + 2.0 * p2 * u * v,
        ]
    }

    fn distorted_slope(&self, [u, v]: [f64; 2]) -> [[f64; 2]; 2] {
        let [k1, k2, p1, p2, k3] = self.distortion;
        let r2 = u * u + v * v;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let growth = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));
        let mixed = growth * u * v + 2.0 * p1 * u + 2.0 * p2 * v;
        [
            [radial + growth * u * u + 2.0 * p1 * v + 6.0 * p2 * u, mixed],
            [mixed, radial + growth * v * v + 6.0 * p1 * v + 2.0 * p2 * u],
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_comes_back_from_its_pixel() {
        let lens = Lens {
            matrix: [900.0, 910.0, 640.0, 350.0],
            distortion: [-0.21, 0.07, 0.001, -0.0008, 0.003],
        };
        for direction in [[0.0, 0.0], [0.3, -0.2], [-0.6, 0.35], [0.55, 0.4]] {
            let back = lens.direction(lens.pixel(direction));
            assert!((back[0] - direction[0]).abs() < 1e-9, "{back:?}");
            assert!((back[1] - direction[1]).abs() < 1e-9, "{back:?}");
        }
    }

    #[test]
    fn the_slope_is_the_difference_of_pixels() {
        let lens = Lens {
            matrix: [900.0, 910.0, 640.0, 350.0],
            distortion: [-0.21, 0.07, 0.001, -0.0008, 0.003],
        };
        let (at, step) = ([0.31, -0.22], 1e-6);
        let slope = lens.slope(at);
        for axis in 0..2 {
            let (mut more, mut less) = (at, at);
            more[axis] += step;
            less[axis] -= step;
            let (more, less) = (lens.pixel(more), lens.pixel(less));
            for row in 0..2 {
                let expected = (more[row] - less[row]) / (2.0 * step);
                assert!((slope[row][axis] - expected).abs() < 1e-4);
            }
        }
    }
}
