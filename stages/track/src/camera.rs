//! A camera over the table: its lens, its pose and its timing, from the rig file.

use values::{Point, Rig, StampMark};

use crate::{Lens, SetupError};

/// Where the table's points are seen, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraModel {
    /// Its lens.
    pub lens: Lens,
    /// Place of its optical centre in the frame `table`, in m.
    pub position: [f64; 3],
    /// Axes of the optical frame (right, down, forward) in the frame `table`.
    pub axes: [[f64; 3]; 3],
    /// Exposure in s; none where it is not stated.
    pub exposure: Option<f64>,
    /// From the first row's exposure to the last one's, in s; none where it is not stated.
    pub readout: Option<f64>,
    /// What a stamp marks of the first row's exposure.
    pub stamp: StampMark,
}

/// Nearer than this along the optical axis nothing is seen, in m.
const NEAREST: f64 = 1e-3;

impl CameraModel {
    /// The camera of a rig file.
    ///
    /// # Errors
    /// Lens or pose are missing, or the camera does not look at the table.
    pub fn of(rig: &Rig) -> Result<Self, SetupError> {
        let camera = &rig.camera;
        let missing = |key| {
            let mend = "`carom camera calibrate` finds it";
            SetupError::Missing { key, mend }
        };
        let no_matrix = SetupError::Missing {
            key: "camera.matrix",
            mend: "`carom camera calibrate` finds it, or log the camera's CameraInfo beside its images",
        };
        let orientation = camera.orientation.ok_or(missing("camera.orientation"))?;
        let model = Self {
            lens: Lens {
                matrix: camera.matrix.ok_or(no_matrix)?,
                distortion: camera.distortion.unwrap_or_default(),
            },
            position: camera.position.ok_or(missing("camera.position"))?,
            axes: axes(orientation),
            exposure: camera.exposure,
            readout: camera.readout,
            stamp: camera.stamp,
        };
        let middle = Point::new(
            0.5 * (rig.table.x.low + rig.table.x.high),
            0.5 * (rig.table.y.low + rig.table.y.high),
        );
        match model.direction([middle.x, middle.y, 0.0]) {
            Some(_) => Ok(model),
            None => Err(SetupError::Behind {
                x: middle.x,
                y: middle.y,
            }),
        }
    }

    /// The point in the optical frame (right, down, forward), in m.
    pub(crate) fn optical(&self, point: [f64; 3]) -> [f64; 3] {
        let from = [0, 1, 2].map(|axis| point[axis] - self.position[axis]);
        self.axes.map(|axis| dot(axis, from))
    }

    /// The direction (X/Z, Y/Z) in which a point is seen; none where it lies behind.
    pub(crate) fn direction(&self, point: [f64; 3]) -> Option<[f64; 2]> {
        let [x, y, z] = self.optical(point);
        (z > NEAREST).then(|| [x / z, y / z])
    }

    /// The pixel in which a point (m, frame `table`) is seen; none where it lies behind.
    pub fn pixel(&self, point: [f64; 3]) -> Option<[f64; 2]> {
        Some(self.lens.pixel(self.direction(point)?))
    }

    /// The point at this height over the table (m) that is seen in a pixel; none above the horizon.
    pub fn point(&self, pixel: [f64; 2], height: f64) -> Option<Point> {
        let [u, v] = self.lens.direction(pixel);
        let [right, down, forward] = self.axes;
        let ray = [0, 1, 2].map(|axis| u * right[axis] + v * down[axis] + forward[axis]);
        let along = (height - self.position[2]) / ray[2];
        let [x, y] = [0, 1].map(|axis| self.position[axis] + along * ray[axis]);
        (along > 0.0 && x.is_finite() && y.is_finite()).then(|| Point::new(x, y))
    }

    /// From a stamp to the middle of the exposure of a row of an image with so many rows, in s.
    pub fn delay(&self, row: f64, rows: usize) -> f64 {
        let [exposure, readout] = [self.exposure, self.readout].map(Option::unwrap_or_default);
        let first = match self.stamp {
            StampMark::Start => 0.5 * exposure,
            StampMark::Middle => 0.0,
            StampMark::End => -0.5 * exposure,
        };
        first + readout * row / (rows.max(2) - 1) as f64
    }
}

/// The columns of the rotation of a quaternion `[x, y, z, w]`, which need not be quite of length 1.
fn axes([x, y, z, w]: [f64; 4]) -> [[f64; 3]; 3] {
    let s = 2.0 / (x * x + y * y + z * z + w * w);
    [
        [
            1.0 - s * (y * y + z * z),
            s * (x * y + z * w),
            s * (x * z - y * w),
        ],
        [
            s * (x * y - z * w),
            1.0 - s * (x * x + z * z),
            s * (y * z + x * w),
        ],
        [
            s * (x * z + y * w),
            s * (y * z - x * w),
            1.0 - s * (x * x + y * y),
        ],
    ]
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_1_SQRT_2;
    use values::Shape;

    fn rig() -> Rig {
        let mut rig = Rig::demo(Shape::Cylinder);
        rig.camera.matrix = Some([900.0, 900.0, 640.0, 360.0]);
        rig.camera.position = Some([0.5, 0.1, 1.2]);
        rig.camera.orientation = Some([-FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0, 0.0]);
        rig
    }

    #[test]
    fn a_camera_that_looks_down_sees_what_is_far_from_the_robot_above() {
        let camera = CameraModel::of(&rig()).expect("complete");
        let near = |pixel: Option<[f64; 2]>, x: f64, y: f64| {
            let pixel = pixel.expect("seen");
            assert!(
                (pixel[0] - x).abs() < 1e-9 && (pixel[1] - y).abs() < 1e-9,
                "{pixel:?}"
            );
        };
        near(camera.pixel([0.5, 0.1, 0.0]), 640.0, 360.0);
        // 75 px for 0.1 m: farther is up, left is left.
        near(camera.pixel([0.6, 0.1, 0.0]), 640.0, 285.0);
        near(camera.pixel([0.5, 0.2, 0.0]), 565.0, 360.0);
        // 40 mm up it is seen farther from the middle.
        near(camera.pixel([0.6, 0.1, 0.04]), 640.0, 360.0 - 90.0 / 1.16);
        let point = camera.point([565.0, 360.0], 0.0).expect("on the table");
        assert!(point.distance(Point::new(0.5, 0.2)) < 1e-12);
    }

    #[test]
    fn what_is_missing_is_named() {
        let mut rig = rig();
        rig.camera.position = None;
        let error = CameraModel::of(&rig).expect_err("no position").to_string();
        assert!(
            error.contains("camera.position") && error.contains("calibrate"),
            "{error}"
        );
        rig.camera.position = Some([0.5, 0.1, 1.2]);
        rig.camera.orientation = Some([0.0, 0.0, 0.0, 1.0]);
        let error = CameraModel::of(&rig).expect_err("it looks up").to_string();
        assert!(error.contains("behind"), "{error}");
    }

    #[test]
    fn a_stamp_is_moved_to_the_middle_of_the_rows_exposure() {
        let mut rig = rig();
        rig.camera.exposure = Some(0.004);
        rig.camera.readout = Some(0.016);
        for (mark, first) in [
            (StampMark::Start, 0.002),
            (StampMark::Middle, 0.0),
            (StampMark::End, -0.002),
        ] {
            rig.camera.stamp = mark;
            let camera = CameraModel::of(&rig).expect("complete");
            assert!((camera.delay(0.0, 481) - first).abs() < 1e-12);
            assert!((camera.delay(240.0, 481) - first - 0.008).abs() < 1e-12);
        }
    }
}
