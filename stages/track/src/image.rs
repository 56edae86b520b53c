//! An image in memory.

use crate::ImageError;
use crate::size::LARGEST_IMAGE;

/// An image of 8-bit R'G'B' pixels, rows from the top, without gaps.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Image {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Three bytes a pixel.
    pub rgb: Vec<u8>,
    /// Whether the camera saw no colours: all three bytes of a pixel are alike.
    pub grey: bool,
}

impl Image {
    /// Makes it this large, whatever it held.
    ///
    /// # Errors
    /// No pixels, or more than [`LARGEST_IMAGE`]: before any memory is taken.
    pub(crate) fn resize(&mut self, width: u64, height: u64) -> Result<(), ImageError> {
        [self.width, self.height] = checked_size(width, height)?;
        self.rgb.resize(3 * self.width * self.height, 0);
        Ok(())
    }

    /// The three bytes of a pixel; it must lie within.
    #[inline]
    pub fn pixel(&self, column: usize, row: usize) -> [u8; 3] {
        let at = 3 * (row * self.width + column);
        [self.rgb[at], self.rgb[at + 1], self.rgb[at + 2]]
    }
}

/// A width and height that are read.
///
/// # Errors
/// No pixels, or more than [`LARGEST_IMAGE`].
pub(crate) fn checked_size(width: u64, height: u64) -> Result<[usize; 2], ImageError> {
    let pixels = width.saturating_mul(height);
    if pixels == 0 || pixels > LARGEST_IMAGE as u64 {
        return Err(ImageError::Size { width, height });
    }
    Ok([width as usize, height as usize])
}
