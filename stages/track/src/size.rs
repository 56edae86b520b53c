//! How large an image may be, and how bright a pixel.

/// Bytes that an image takes at the most: its pixels as RGB, with what they are decoded from. The program takes another 32 MB at the most.
pub(crate) const MOST_BYTES: usize = 95_500_000;

/// Most pixels of an image.
pub const LARGEST_IMAGE: usize = MOST_BYTES / 3;

/// Bytes of messages that wait in a queue at the most.
pub(crate) const MOST_WAITING: usize = 12 << 20;

/// All bytes of a pixel at or over this are glare.
pub(crate) const GLARE: u8 = 245;

/// Whether a pixel is so bright that its colour is not seen.
pub(crate) fn is_glare(rgb: [u8; 3]) -> bool {
    rgb.iter().all(|byte| *byte >= GLARE)
}
