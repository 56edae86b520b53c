//! How large an image may be, and how bright a pixel.

/// Most pixels of an image: 8192 × 4096, 100 MB as RGB.
pub const LARGEST_IMAGE: usize = 8192 * 4096;

/// All bytes of a pixel at or over this are glare.
pub(crate) const GLARE: u8 = 245;

/// Whether a pixel is so bright that its colour is not seen.
pub(crate) fn is_glare(rgb: [u8; 3]) -> bool {
    rgb.iter().all(|byte| *byte >= GLARE)
}
