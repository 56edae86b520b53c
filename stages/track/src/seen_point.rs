//! A known point and its pixel: what a camera is calibrated from.

/// A point of the table or above it, and where it is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenPoint {
    /// In the frame `table`, in m.
    pub at: [f64; 3],
    /// Its pixel.
    pub pixel: [f64; 2],
}
