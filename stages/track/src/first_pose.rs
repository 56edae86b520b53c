//! A camera's pose from points of the table, before any fit (Zhang 2000, section 3.1).

use values::StampMark;

use crate::camera::dot;
use crate::homography::homography;
use crate::rotation::{cross, length, unit};
use crate::seen_point::SeenPoint;
use crate::{CameraModel, Lens};

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
