//! How large an image may be.

/// Most pixels of an image: 8192 × 4096, 100 MB as RGB.
pub const LARGEST_IMAGE: usize = 8192 * 4096;
