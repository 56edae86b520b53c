//! The rays of a camera's pixels.

use crate::Optics;

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
