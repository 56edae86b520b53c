//! An image in memory.

use crate::ImageError;
use crate::size::{LARGEST_IMAGE, MOST_BYTES};

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

    /// This image with no side longer than `most`: means of squares of pixels; what is left at the right and below is cut off.
    pub(crate) fn averaged(&self, most: usize) -> Self {
        let square = square([self.width, self.height], most);
        if square == 1 {
            return self.clone();
        }
        let (width, height) = (self.width / square, self.height / square);
        let mut rgb = Vec::with_capacity(3 * width * height);
        for row in 0..height {
            for column in 0..width {
                let mut sums = [0_usize; 3];
                for y in 0..square {
                    for x in 0..square {
                        let pixel = self.pixel(column * square + x, row * square + y);
                        for (sum, byte) in sums.iter_mut().zip(pixel) {
                            *sum += usize::from(byte);
                        }
                    }
                }
                rgb.extend(sums.map(|sum| (sum / (square * square)) as u8));
            }
        }
        Self {
            width,
            height,
            rgb,
            grey: self.grey,
        }
    }

    /// The three bytes of a pixel; it must lie within.
    #[inline]
    pub fn pixel(&self, column: usize, row: usize) -> [u8; 3] {
        let at = 3 * (row * self.width + column);
        let pixel = &self.rgb[at..at + 3];
        [pixel[0], pixel[1], pixel[2]]
    }
}

/// Pixels of a side of the squares that an image is averaged by so that no side is longer than `most`.
pub(crate) fn square([width, height]: [usize; 2], most: usize) -> usize {
    let square = width.max(height).div_ceil(most.max(1)).max(1);
    if square > width.min(height) {
        1
    } else {
        square
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

/// Checks that there is room for an image's pixels beside so many bytes that they are decoded from.
///
/// # Errors
/// Both take more than [`MOST_BYTES`].
pub(crate) fn check_room([width, height]: [usize; 2], beside: usize) -> Result<(), ImageError> {
    let bytes = 3 * width * height + beside;
    if bytes > MOST_BYTES {
        return Err(ImageError::Memory {
            width,
            height,
            bytes,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_is_refused_that_takes_more_with_what_it_is_decoded_from_than_there_is_room_for() {
        let size = [4600, 3450];
        let raw = 3 * size[0] * size[1];
        assert_eq!(check_room(size, raw), Ok(()));
        let refused = check_room([4600, 3500], raw).expect_err("too large");
        assert!(
            refused.to_string().contains("record smaller images"),
            "{refused}"
        );
        assert_eq!(check_room([7300, 4200], 3_000_000), Ok(()));
    }
}
