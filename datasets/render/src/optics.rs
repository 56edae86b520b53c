//! The camera as glass and metal: lens, place, shutter, and the rays of its pixels.

use values::Rig;

/// A camera: OpenCV's model of lens and pose, and its timing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Optics {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `[fx, fy, cx, cy]` in px; pixel centres are whole numbers.
    pub matrix: [f64; 4],
    /// `[k1, k2, p1, p2, k3]`.
    pub distortion: [f64; 5],
    /// Place in the frame `table`, in m.
    pub position: [f64; 3],
    /// Orientation of the optical frame in the frame `table`, `[qx, qy, qz, qw]`.
    pub orientation: [f64; 4],
    /// Exposure in s.
    pub exposure: f64,
    /// From the first row's exposure to the last one's, in s.
    pub readout: f64,
}

impl Optics {
    /// The camera of a rig file, with so many pixels; nothing where lens or pose are missing.
    pub fn of(rig: &Rig, [width, height]: [usize; 2]) -> Option<Self> {
        Some(Self {
            width,
            height,
            matrix: rig.camera.matrix?,
            distortion: rig.camera.distortion.unwrap_or_default(),
            position: rig.camera.position?,
            orientation: rig.camera.orientation?,
            exposure: rig.camera.exposure.unwrap_or(0.0),
            readout: rig.camera.readout.unwrap_or(0.0),
        })
    }

    /// The ray that arrives at a pixel, in the frame `table`; of any length.
    pub(crate) fn ray(&self, x: f64, y: f64) -> [f64; 3] {
        /// Rounds of undoing the distortion at the most; what is left shrinks by ten or more in each.
        const ROUNDS: usize = 25;
        /// What may be left of it.
        const DONE: f64 = 1e-12;
        let [fx, fy, cx, cy] = self.matrix;
        let [k1, k2, p1, p2, k3] = self.distortion;
        let (seen_x, seen_y) = ((x - cx) / fx, (y - cy) / fy);
        let (mut u, mut v) = (seen_x, seen_y);
        for _ in 0..ROUNDS {
            let r = u * u + v * v;
            let stretch = 1.0 + k1 * r + k2 * r * r + k3 * r * r * r;
            let tangential = [
                2.0 * p1 * u * v + p2 * (r + 2.0 * u * u),
                p1 * (r + 2.0 * v * v) + 2.0 * p2 * u * v,
            ];
            let next = [
                (seen_x - tangential[0]) / stretch,
                (seen_y - tangential[1]) / stretch,
            ];
            let moved = (next[0] - u).abs() + (next[1] - v).abs();
            [u, v] = next;
            if moved < DONE {
                break;
            }
        }
        self.turned([u, v, 1.0])
    }

    /// Where a ray meets the table, in m.
    pub(crate) fn on_table(&self, ray: [f64; 3]) -> [f64; 2] {
        let along = -self.position[2] / ray[2];
        [0, 1].map(|i| self.position[i] + along * ray[i])
    }

    /// The pixel at which a point is seen, without regard to what is behind the camera.
    pub fn seen(&self, point: [f64; 3]) -> [f64; 2] {
        let [qx, qy, qz, qw] = self.orientation;
        let back = Self {
            orientation: [-qx, -qy, -qz, qw],
            ..*self
        };
        let from = [0, 1, 2].map(|i| point[i] - self.position[i]);
        let [x, y, z] = back.turned(from);
        let (u, v) = (x / z, y / z);
        let [fx, fy, cx, cy] = self.matrix;
        let [k1, k2, p1, p2, k3] = self.distortion;
        let r = u * u + v * v;
        let stretch = 1.0 + k1 * r + k2 * r * r + k3 * r * r * r;
        [
            fx * (u * stretch + 2.0 * p1 * u * v + p2 * (r + 2.0 * u * u)) + cx,
            fy * (v * stretch + p1 * (r + 2.0 * v * v) + 2.0 * p2 * u * v) + cy,
        ]
    }

    /// v turned by the orientation: v + 2q×(q×v + w·v), of a quaternion of length 1.
    fn turned(&self, v: [f64; 3]) -> [f64; 3] {
        let [x, y, z, w] = self.orientation;
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [
                a[1] * b[2] - a[2] * b[1],
                a[2] * b[0] - a[0] * b[2],
                a[0] * b[1] - a[1] * b[0],
            ]
        };
        let inner = cross([x, y, z], v);
        let inner = [0, 1, 2].map(|i| inner[i] + w * v[i]);
        let outer = cross([x, y, z], inner);
        [0, 1, 2].map(|i| v[i] + 2.0 * outer[i])
    }
}

/// Rays through the corners of the pixels, in the frame `table`.
#[derive(Clone, Debug)]
pub(crate) struct Rays {
    corners: Vec<[f64; 3]>,
    /// Corners in a row.
    across: usize,
}

impl Rays {
    pub(crate) fn of(optics: &Optics) -> Self {
        let (width, height) = (optics.width, optics.height);
        let mut corners = Vec::with_capacity((width + 1) * (height + 1));
        for row in 0..=height {
            for column in 0..=width {
                corners.push(optics.ray(column as f64 - 0.5, row as f64 - 0.5));
            }
        }
        Self {
            corners,
            across: width + 1,
        }
    }

    /// The ray through a part (0 to 1 from the left and the top) of a pixel.
    pub(crate) fn through(&self, column: usize, row: usize, x: f64, y: f64) -> [f64; 3] {
        let at = row * self.across + column;
        let below = at + self.across;
        let corner = |at: usize, i: usize| self.corners[at][i];
        [0, 1, 2].map(|i| {
            let upper = corner(at, i) * (1.0 - x) + corner(at + 1, i) * x;
            let lower = corner(below, i) * (1.0 - x) + corner(below + 1, i) * x;
            upper * (1.0 - y) + lower * y
        })
    }
}
