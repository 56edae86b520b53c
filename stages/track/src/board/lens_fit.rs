//! A lens from views of a board.
//!
//! The homographies of the views give a focal length (Zhang 2000, section 3.1, with the axis through the image's middle); the sum of
//! squared pixels is then minimised over focal lengths, principal point, k1, k2, p1, p2 and the pose of every view. k3 stays 0: it cannot
//! be distinguished from k2 but at the corners of wide lenses.

use super::corners::SeenBoard;
use super::plane::Homography;
use crate::calibrate::{SeenPoint, first_pose};
use crate::minimise::{LeastSquares, minimise};
use crate::rotation::turned;
use crate::{BoardError, CameraModel, Lens};

/// A lens that was found from views of a board.
#[derive(Clone, Debug, PartialEq)]
pub struct LensFit {
    /// The lens.
    pub lens: Lens,
    /// Width and height in px of the images that it holds for.
    pub size: [usize; 2],
    /// Reprojection error in px: rms of a coordinate, for the unknowns that were fitted.
    pub error: f64,
    /// Rms of each view that was used, in px; none of one that shows too little.
    pub views: Vec<Option<f64>>,
    /// Corners that were used.
    pub corners: usize,
    /// Standard error of the focal length, as a share of it.
    pub unsure: f64,
}

/// Inner corners that a view must show.
pub const FEWEST_CORNERS: usize = 6;
/// Views that a lens is found from, at the least.
const FEWEST_VIEWS: usize = 3;
/// Corners are off by more than this (px, rms): blurred, a bent board, or not the board that was said.
const MOST_ERROR: f64 = 1.0;
/// A focal length that is known worse than to this share puts what stands over the table elsewhere by about as much of its height.
const MOST_UNSURE: f64 = 0.01;
/// Unknowns of the lens: logarithms of the focal lengths, the principal point by them, k1, k2, p1, p2.
const OF_LENS: usize = 8;
/// Unknowns of a view: place, of its distance, and turn in rad.
const OF_VIEW: usize = 6;

impl LensFit {
    /// Finds the lens of a camera with images of this size (width, height) from what they show of a board.
    ///
    /// # Errors
    /// Too few views; views that do not determine the focal length; corners that fit no lens; a focal length that is not known to 1 %.
    pub fn from_views(views: &[SeenBoard], size: [usize; 2]) -> Result<Self, BoardError> {
        let used: Vec<(usize, Vec<SeenPoint>)> = views
            .iter()
            .enumerate()
            .filter(|(_, view)| view.corners.len() >= FEWEST_CORNERS)
            .map(|(index, view)| (index, view.points()))
            .collect();
        if used.len() < FEWEST_VIEWS {
            return Err(BoardError::Few {
                views: used.len(),
                needed: FEWEST_VIEWS,
                corners: FEWEST_CORNERS,
            });
        }
        let start = first_lens(&used, size).ok_or(BoardError::Undetermined)?;
        let poses = used.iter().map(|(_, points)| first_pose(points, &start));
        let poses: Vec<CameraModel> = poses
            .collect::<Option<_>>()
            .ok_or(BoardError::Undetermined)?;
        let unknowns = Unknowns { start, poses };
        let zero = vec![0.0; OF_LENS + OF_VIEW * used.len()];
        let left = |at: &[f64]| unknowns.left(at, &used);
        let fit = minimise(&zero, &left).ok_or(BoardError::Undetermined)?;
        let free = fit.left.len().saturating_sub(fit.at.len()).max(1) as f64;
        let error = (fit.squares() / free).sqrt();
        let views = of_views(views.len(), &used, &fit);
        if error.is_nan() || error > MOST_ERROR {
            let rms = |view: &Option<f64>| view.unwrap_or_default();
            let worst = (0..views.len()).max_by(|a, b| rms(&views[*a]).total_cmp(&rms(&views[*b])));
            let worst = worst.unwrap_or_default();
            return Err(BoardError::Poor {
                error,
                most: MOST_ERROR,
                view: worst,
                worst: rms(&views[worst]),
            });
        }
        let unsure = error * fit.covariance[(0, 0)].max(fit.covariance[(1, 1)]).sqrt();
        if unsure.is_nan() || unsure > MOST_UNSURE {
            return Err(BoardError::Unsure {
                unsure: 100.0 * unsure,
                most: 100.0 * MOST_UNSURE,
            });
        }
        Ok(Self {
            lens: unknowns.lens(&fit.at),
            size,
            error,
            views,
            corners: fit.left.len() / 2,
            unsure,
        })
    }
}

impl SeenBoard {
    /// Its corners on a table that the board lies on: its upper left corner at 0, x along its rows, y against its columns, z up.
    fn points(&self) -> Vec<SeenPoint> {
        let corners = self.corners.iter();
        corners
            .map(|([right, down], pixel)| SeenPoint {
                at: [*right, -down, 0.0],
                pixel: *pixel,
            })
            .collect()
    }

    /// Its corners as points of the table, for a board that lies on it with its upper left and its upper right corner at these places.
    ///
    /// # Errors
    /// The places are not as far from each other as the board is wide, `width`.
    pub fn on_table(
        &self,
        [left, right]: [[f64; 2]; 2],
        width: f64,
    ) -> Result<Vec<SeenPoint>, BoardError> {
        let along = [0, 1].map(|i| right[i] - left[i]);
        let typed = along[0].hypot(along[1]);
        if (typed - width).abs() > MOST_TYPED * width {
            return Err(BoardError::Width { typed, width });
        }
        let [x, y] = along.map(|part| part / typed);
        let corners = self.corners.iter();
        let place = |([right, down], pixel): &([f64; 2], [f64; 2])| SeenPoint {
            at: [
                left[0] + right * x + down * y,
                left[1] + right * y - down * x,
                0.0,
            ],
            pixel: *pixel,
        };
        Ok(corners.map(place).collect())
    }
}

/// Places that were measured on the table may differ from the board's width by this share of it.
const MOST_TYPED: f64 = 0.02;

/// One focal length for both axes: it makes the board's axes stand across each other and be of one length in every view.
fn first_lens(views: &[(usize, Vec<SeenPoint>)], [width, height]: [usize; 2]) -> Option<Lens> {
    let middle = [width, height].map(|size| 0.5 * (size as f64 - 1.0));
    let (mut slope, mut square) = (0.0, 0.0);
    for (_, points) in views {
        let flat = points
            .iter()
            .map(|point| ([point.at[0], point.at[1]], point.pixel));
        let matrix = Homography::between(&flat.collect::<Vec<_>>())?.matrix(middle);
        let [x, y] = [0, 1].map(|column| matrix.map(|row| row[column]));
        let size = x[0].hypot(x[1]) * y[0].hypot(y[1]);
        for (across, along) in [
            (x[0] * y[0] + x[1] * y[1], x[2] * y[2]),
            (
                x[0] * x[0] + x[1] * x[1] - y[0] * y[0] - y[1] * y[1],
                x[2] * x[2] - y[2] * y[2],
            ),
        ] {
            slope -= across * along / (size * size);
            square += across * across / (size * size);
        }
    }
    let focal = (square / slope).sqrt();
    focal.is_finite().then_some(Lens {
        matrix: [focal, focal, middle[0], middle[1]],
        distortion: [0.0; 5],
    })
}

/// Steps from a first lens and first poses.
struct Unknowns {
    start: Lens,
    poses: Vec<CameraModel>,
}

impl Unknowns {
    fn lens(&self, at: &[f64]) -> Lens {
        let [fx, fy, cx, cy] = self.start.matrix;
        Lens {
            matrix: [
                fx * at[0].exp(),
                fy * at[1].exp(),
                cx + fx * at[2],
                cy + fy * at[3],
            ],
            distortion: [at[4], at[5], at[6], at[7], 0.0],
        }
    }

    fn left(&self, at: &[f64], views: &[(usize, Vec<SeenPoint>)]) -> Option<Vec<f64>> {
        let lens = self.lens(at);
        let mut left = Vec::new();
        for (view, (_, points)) in views.iter().enumerate() {
            let at = &at[OF_LENS + OF_VIEW * view..][..OF_VIEW];
            let mut camera = self.poses[view];
            let distance = crate::rotation::length(camera.position);
            camera.lens = lens;
            camera.position = [0, 1, 2].map(|i| camera.position[i] + distance * at[i]);
            camera.axes = camera.axes.map(|axis| turned(axis, [at[3], at[4], at[5]]));
            for point in points {
                let pixel = camera.pixel(point.at)?;
                left.extend([0, 1].map(|i| pixel[i] - point.pixel[i]));
            }
        }
        Some(left)
    }
}

/// The rms of a coordinate in each view.
fn of_views(
    count: usize,
    used: &[(usize, Vec<SeenPoint>)],
    fit: &LeastSquares,
) -> Vec<Option<f64>> {
    let mut views = vec![None; count];
    let mut left = fit.left.as_slice();
    for (index, points) in used {
        let (here, rest) = left.split_at(2 * points.len());
        let squares: f64 = here.iter().map(|left| left * left).sum();
        views[*index] = Some((squares / here.len() as f64).sqrt());
        left = rest;
    }
    views
}
