//! Lens and pose of a camera from points of the table and the pixels in which they are seen; the first pose after Zhang 2000, section 3.1.
//!
//! A homography of the plane gives a first pose (Zhang 2000, section 3.1); the sum of squared pixels is then minimised over the
//! pose, and over the focal length where the lens is not known. What the points leave uncertain is given in mm on the table.

use nalgebra::DMatrix;
use values::{Interval, StampMark};

use crate::camera::dot;
use crate::homography::homography;
use crate::minimise::{LeastSquares, minimise, slope};
use crate::rotation::{cross, length, quaternion, turned, unit};
use crate::{CalibrationError, CameraModel, Lens};

/// What is known of the lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KnownLens {
    /// All.
    Lens(Lens),
    /// Only how many pixels the image has: one focal length is found, the axis goes through the image's middle, and the lens bends nothing.
    Size([usize; 2]),
}

/// Where the object may be: what a calibration is judged for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Workspace {
    /// The table's bounds in m.
    pub table: [Interval; 2],
    /// Height of the object's middle in m.
    pub height: f64,
}

/// A camera that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// Its lens.
    pub lens: Lens,
    /// Place of its optical centre in the frame `table`, in m.
    pub position: [f64; 3],
    /// Its optical frame in the frame `table`, `[qx, qy, qz, qw]`.
    pub orientation: [f64; 4],
    /// Reprojection error in px: rms of a coordinate, for the unknowns that were fitted.
    pub error: f64,
    /// Points that it was found from.
    pub points: usize,
    /// The greatest distance of a point's pixel from where the camera found would see it, in px.
    pub worst: f64,
    /// Standard error in m of the object's place where it is known least, over the table.
    pub unsure: f64,
}

/// A pixel that was typed, and one that was found in an image, is off by this much (px, standard deviation) even where fewer points leave
/// less.
const TYPED: f64 = 0.5;
const FOUND: f64 = 0.15;
/// Points whose pixels are off by more than this (px) were mistyped, or the lens bends more than is known.
const MOST_ERROR: f64 = 2.0;
/// An object that is seen farther than this from where it is (m) is seen wrong.
const MOST_UNSURE: f64 = 0.003;
/// Focal lengths to begin with, of the image's width: wide to narrow lenses.
const FOCAL_LENGTHS: [f64; 5] = [0.5, 0.75, 1.0, 1.5, 2.5];

impl Calibration {
    /// Finds a camera from at least four points that do not lie in a line.
    ///
    /// # Errors
    /// Too few points; points that do not determine the camera; pixels that fit no camera; a camera that would see the object wrong by
    /// more than 3 mm somewhere on the table.
    pub fn from_points(
        points: &[SeenPoint],
        known: KnownLens,
        workspace: Workspace,
    ) -> Result<Self, CalibrationError> {
        Self::from(points, known, workspace, TYPED)
    }

    /// Finds the pose of a camera whose lens is known from the corners of a board that lies on the table.
    ///
    /// # Errors
    /// Those of [`Calibration::from_points`].
    pub fn from_board(
        corners: &[SeenPoint],
        lens: Lens,
        workspace: Workspace,
    ) -> Result<Self, CalibrationError> {
        Self::from(corners, KnownLens::Lens(lens), workspace, FOUND)
    }

    fn from(
        points: &[SeenPoint],
        known: KnownLens,
        workspace: Workspace,
        least_error: f64,
    ) -> Result<Self, CalibrationError> {
        if points.len() < FEWEST {
            return Err(CalibrationError::Few {
                points: points.len(),
                needed: FEWEST,
            });
        }
        let (lenses, is_known) = match known {
            KnownLens::Lens(lens) => (vec![lens], true),
            KnownLens::Size(size) => (
                FOCAL_LENGTHS.map(|share| plain(share, size)).to_vec(),
                false,
            ),
        };
        let fits = lenses.iter().filter_map(|lens| {
            let start = first_pose(points, lens)?;
            let unknowns = Unknowns { start, is_known };
            let fit = minimise(&unknowns.zero(), &|at| unknowns.left(at, points))?;
            Some((unknowns, fit))
        });
        let best = fits.min_by(|a, b| a.1.squares().total_cmp(&b.1.squares()));
        let (unknowns, fit) = best.ok_or(CalibrationError::Undetermined)?;
        let camera = unknowns.camera(&fit.at);
        let free = (fit.left.len() - fit.at.len()) as f64;
        let error = (fit.squares() / free).sqrt();
        let (index, worst) = farthest(&fit.left);
        if error > MOST_ERROR {
            return Err(CalibrationError::Poor {
                error,
                most: MOST_ERROR,
                point: index + 1,
                worst,
            });
        }
        // A mirrored table is seen as well, from below.
        if camera.position[2] <= 0.0 {
            return Err(CalibrationError::Mirrored);
        }
        let unsure = unknowns
            .unsure(&fit, error.max(least_error), workspace)
            .ok_or(CalibrationError::Undetermined)?;
        if unsure > MOST_UNSURE {
            return Err(CalibrationError::Unsure {
                unsure: 1e3 * unsure,
                most: 1e3 * MOST_UNSURE,
            });
        }
        Ok(Self {
            lens: camera.lens,
            position: camera.position,
            orientation: quaternion(camera.axes),
            error,
            points: points.len(),
            worst,
            unsure,
        })
    }
}

/// Two equations a point must outnumber seven unknowns.
const FEWEST: usize = 4;

fn plain(share: f64, [width, height]: [usize; 2]) -> Lens {
    let focal = share * width as f64;
    Lens {
        matrix: [
            focal,
            focal,
            0.5 * (width as f64 - 1.0),
            0.5 * (height as f64 - 1.0),
        ],
        distortion: [0.0; 5],
    }
}

/// Steps from a first camera: of its place (m), its turn (rad), and the logarithm of its focal length.
struct Unknowns {
    start: CameraModel,
    is_known: bool,
}

impl Unknowns {
    fn zero(&self) -> Vec<f64> {
        vec![0.0; if self.is_known { 6 } else { 7 }]
    }

    fn camera(&self, at: &[f64]) -> CameraModel {
        let mut camera = self.start;
        camera.position = [0, 1, 2].map(|i| camera.position[i] + at[i]);
        let turn = [at[3], at[4], at[5]];
        camera.axes = camera.axes.map(|axis| turned(axis, turn));
        if let Some(zoom) = at.get(6) {
            camera.lens.matrix[0] *= zoom.exp();
            camera.lens.matrix[1] *= zoom.exp();
        }
        camera
    }

    fn left(&self, at: &[f64], points: &[SeenPoint]) -> Option<Vec<f64>> {
        let camera = self.camera(at);
        let mut left = Vec::with_capacity(2 * points.len());
        for point in points {
            let pixel = camera.pixel(point.at)?;
            left.extend([0, 1].map(|i| pixel[i] - point.pixel[i]));
        }
        Some(left)
    }

    /// The greatest standard error (m) of the object's place over the table, where pixels are off by `pixel`.
    fn unsure(&self, fit: &LeastSquares, pixel: f64, workspace: Workspace) -> Option<f64> {
        let found = self.camera(&fit.at);
        let [x, y] = workspace.table;
        let places = [x.low, 0.5 * (x.low + x.high), x.high]
            .into_iter()
            .flat_map(|x| [y.low, 0.5 * (y.low + y.high), y.high].map(|y| [x, y]));
        let mut unsure = 0.0f64;
        for [x, y] in places {
            // Where the lens is not known, a corner that no camera sees is not asked for.
            let Some(seen) = found.pixel([x, y, workspace.height]) else {
                continue;
            };
            let place = |at: &[f64]| {
                let point = self.camera(at).point(seen, workspace.height)?;
                Some(vec![point.x, point.y])
            };
            let slope: DMatrix<f64> = slope(&fit.at, 2, &place)?;
            let variance = &slope * &fit.covariance * slope.transpose();
            unsure = unsure.max(pixel * variance.trace().max(0.0).sqrt());
        }
        Some(unsure)
    }
}

/// Which point's pixel is farthest off, and by how much.
fn farthest(left: &[f64]) -> (usize, f64) {
    let distances = left.chunks(2).map(|pair| pair[0].hypot(pair[1]));
    let far = distances.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
    far.unwrap_or((0, 0.0))
}

/// A point of the table or above it, and where it is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenPoint {
    /// In the frame `table`, in m.
    pub at: [f64; 3],
    /// Its pixel.
    pub pixel: [f64; 2],
}

/// A pose from the homography between the table's plane and directions; heights of points are small and wait for the fit.
pub(crate) fn first_pose(points: &[SeenPoint], lens: &Lens) -> Option<CameraModel> {
    let count = points.len() as f64;
    let middle = [0, 1].map(|i| points.iter().map(|point| point.at[i]).sum::<f64>() / count);
    let h = homography(points.iter().map(|point| {
        let at = [0, 1].map(|i| point.at[i] - middle[i]);
        (at, lens.direction(point.pixel))
    }))?;
    // Columns: the camera's view of the table's x, of its y, and of its middle, which lies before the camera.
    let across = [h[0], h[3], h[6]];
    let along = [h[1], h[4], h[7]];
    let scale = 0.5 * (length(across) + length(along));
    if !scale.is_finite() || scale <= 0.0 {
        return None;
    }
    let x = unit(across)?;
    let off = dot(x, along);
    let y = unit([0, 1, 2].map(|i| along[i] - off * x[i]))?;
    let z = cross(x, y);
    let to_middle = [h[2], h[5], 1.0].map(|part| part / scale);
    // Rows of the camera's view are its axes in the table's frame.
    let axes = [0, 1, 2].map(|i| [x[i], y[i], z[i]]);
    let from_middle = [x, y, z].map(|axis| -dot(axis, to_middle));
    Some(CameraModel {
        lens: *lens,
        position: [
            middle[0] + from_middle[0],
            middle[1] + from_middle[1],
            from_middle[2],
        ],
        axes,
        exposure: None,
        readout: None,
        stamp: StampMark::Middle,
    })
}

#[cfg(test)]
mod tests {
    use values::{Rig, Shape};

    use super::*;
    use crate::rotation::length;

    const WORKSPACE: Workspace = Workspace {
        table: [Interval::new(0.1, 1.0), Interval::new(-0.5, 0.5)],
        height: 0.02,
    };

    /// A camera that leans by some degrees.
    fn camera(lean: f64) -> CameraModel {
        let mut rig = Rig::demo(Shape::Cylinder);
        rig.camera.matrix = Some([900.0, 900.0, 639.5, 359.5]);
        rig.camera.position = Some([0.5, 0.1, 1.2]);
        let h = std::f64::consts::FRAC_1_SQRT_2;
        rig.camera.orientation = Some([-h, h, 0.0, 0.0]);
        let mut camera = CameraModel::of(&rig).expect("complete");
        camera.axes = camera.axes.map(|axis| turned(axis, [0.0, lean, 0.05]));
        camera
    }

    fn seen(camera: &CameraModel, places: &[[f64; 3]]) -> Vec<SeenPoint> {
        let see = |at: &[f64; 3]| SeenPoint {
            at: *at,
            pixel: camera.pixel(*at).expect("seen").map(|part| part.round()),
        };
        places.iter().map(see).collect()
    }

    const CORNERS: [[f64; 3]; 4] = [
        [0.2, -0.3, 0.0],
        [0.2, 0.4, 0.0],
        [0.8, 0.4, 0.0],
        [0.8, -0.3, 0.0],
    ];

    #[test]
    fn four_points_give_the_pose_of_a_camera_whose_lens_is_known() {
        for lean in [0.0, 0.4] {
            let camera = camera(lean);
            let points = seen(&camera, &CORNERS);
            let known = KnownLens::Lens(camera.lens);
            let found = Calibration::from_points(&points, known, WORKSPACE).expect("found");
            let off = [0, 1, 2].map(|i| found.position[i] - camera.position[i]);
            // Half a pixel turns a camera by some mrad about what it looks at.
            assert!(length(off) < 0.02, "{found:?}");
            assert!(found.error < 1.0 && found.unsure < 0.003, "{found:?}");
            // Its orientation is the camera's.
            let mut rig = Rig::demo(Shape::Cylinder);
            rig.camera.matrix = Some(found.lens.matrix);
            rig.camera.position = Some(found.position);
            rig.camera.orientation = Some(found.orientation);
            let again = CameraModel::of(&rig).expect("complete");
            for point in &points {
                let pixel = again.pixel(point.at).expect("seen");
                assert!(
                    (pixel[0] - point.pixel[0]).hypot(pixel[1] - point.pixel[1])
                        <= found.worst + 1e-6
                );
            }
        }
    }

    #[test]
    fn heights_determine_the_focal_length_of_a_camera_that_looks_straight_down() {
        let camera = camera(0.0);
        let size = KnownLens::Size([1280, 720]);
        let flat = Calibration::from_points(&seen(&camera, &CORNERS), size, WORKSPACE);
        assert!(
            matches!(
                flat,
                Err(CalibrationError::Undetermined | CalibrationError::Unsure { .. })
            ),
            "{flat:?}"
        );
        let mut places = CORNERS.to_vec();
        places.extend(CORNERS.map(|[x, y, _]| [0.9 * x, 0.9 * y, 0.15]));
        let found =
            Calibration::from_points(&seen(&camera, &places), size, WORKSPACE).expect("found");
        assert!((found.lens.matrix[0] - 900.0).abs() < 25.0, "{found:?}");
        assert!((found.position[2] - 1.2).abs() < 0.03, "{found:?}");
    }

    #[test]
    fn a_camera_that_leans_determines_its_focal_length() {
        let camera = camera(0.5);
        let mut places = CORNERS.to_vec();
        places.extend([[0.5, 0.0, 0.0], [0.35, 0.2, 0.0], [0.65, -0.2, 0.0]]);
        let size = KnownLens::Size([1280, 720]);
        let found =
            Calibration::from_points(&seen(&camera, &places), size, WORKSPACE).expect("found");
        assert!((found.lens.matrix[0] - 900.0).abs() < 20.0, "{found:?}");
    }

    #[test]
    fn mirrored_points_are_refused() {
        let camera = camera(0.3);
        let known = KnownLens::Lens(camera.lens);
        for from_right in [false, true] {
            let mut points = seen(&camera, &CORNERS);
            for point in &mut points {
                match from_right {
                    true => point.pixel[0] = 1279.0 - point.pixel[0],
                    false => point.at[1] = -point.at[1],
                }
            }
            let found = Calibration::from_points(&points, known, WORKSPACE);
            assert_eq!(found, Err(CalibrationError::Mirrored));
        }
    }

    #[test]
    fn a_poor_calibration_is_refused() {
        let camera = camera(0.3);
        let known = KnownLens::Lens(camera.lens);
        let try_with = |points: &[SeenPoint]| Calibration::from_points(points, known, WORKSPACE);
        let mut points = seen(&camera, &CORNERS);
        let few = try_with(&points[..3]).expect_err("three points");
        assert_eq!(
            few,
            CalibrationError::Few {
                points: 3,
                needed: 4
            }
        );
        points.push(points[0]);
        points[2].pixel[0] += 40.0;
        match try_with(&points) {
            Err(CalibrationError::Poor { error, .. }) => assert!(error > 2.0),
            other => panic!("{other:?}"),
        }
        let line: Vec<[f64; 3]> = (0..6)
            .map(|k| [0.2 + 0.1 * f64::from(k), 0.1, 0.0])
            .collect();
        let line = try_with(&seen(&camera, &line)).expect_err("a line");
        assert!(
            matches!(
                line,
                CalibrationError::Undetermined | CalibrationError::Unsure { .. }
            ),
            "{line}"
        );
        let near = CORNERS.map(|[x, y, z]| [0.5 + 0.04 * x, 0.04 * y, z]);
        let near = try_with(&seen(&camera, &near)).expect_err("all in one place");
        assert!(
            matches!(
                near,
                CalibrationError::Unsure { .. } | CalibrationError::Undetermined
            ),
            "{near}"
        );
    }
}
