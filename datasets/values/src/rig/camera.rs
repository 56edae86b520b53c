//! What sees the object: its noise and rate and, where images are read, its lens, pose and timing.

use serde::{Deserialize, Serialize};

use crate::{Point, exact};

/// The camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Frames per second, in Hz.
    pub rate: f64,
    /// Standard deviation of a centroid's coordinate, in m.
    pub noise: f64,
    /// The point of the table it looks down on.
    pub centre: Point,
    /// Focal lengths and principal point `[fx, fy, cx, cy]` in px; pixel centres are whole numbers.
    #[serde(default, with = "exact", skip_serializing_if = "Option::is_none")]
    pub matrix: Option<[f64; 4]>,
    /// Width and height in px of the images that `matrix` holds for; images of another size are refused.
    #[serde(default, with = "exact", skip_serializing_if = "Option::is_none")]
    pub size: Option<[u32; 2]>,
    /// Distortion `[k1, k2, p1, p2, k3]`: `plumb_bob` of ROS and OpenCV.
    #[serde(default, with = "exact", skip_serializing_if = "Option::is_none")]
    pub distortion: Option<[f64; 5]>,
    /// Place of its optical centre in the frame `table`, in m.
    #[serde(default, with = "exact", skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// Orientation of its optical frame (z forward, x right, y down) in the frame `table`, as `[qx, qy, qz, qw]`.
    #[serde(default, with = "exact", skip_serializing_if = "Option::is_none")]
    pub orientation: Option<[f64; 4]>,
    /// Exposure of an image, in s; none where it is not stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exposure: Option<f64>,
    /// From the exposure of an image's first row to that of its last, in s; 0 for a global shutter; none where it is not stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub readout: Option<f64>,
    /// What an image's stamp marks.
    #[serde(default, skip_serializing_if = "is_middle")]
    pub stamp: StampMark,
}

/// What an image's stamp marks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum StampMark {
    /// The start of the first row's exposure.
    Start,
    /// The middle of the first row's exposure.
    #[default]
    Middle,
    /// The end of the first row's exposure.
    End,
}

/// Whether the mark is the default, which is not written.
fn is_middle(mark: &StampMark) -> bool {
    *mark == StampMark::Middle
}
