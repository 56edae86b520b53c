//! Markers, and ChArUco boards: a chessboard with ArUco markers in its white squares.
//!
//! ```text
//! image → dark quads → markers of the dictionary → corners of the chessboard → lens from some views, pose from one
//! ```
//!
//! The markers identify the corners, so that a board may be cut or covered; the corners, where two black squares meet, are found
//! to a fraction of a pixel.

mod corners;
mod dictionary;
mod lens_fit;
mod markers;
mod pattern;
mod plane;
mod quads;

pub(crate) use markers::cell_lights;
pub(crate) use pattern::Pattern;
pub(crate) use quads::{Grey, Quad, dark_quads};

pub use corners::{Board, SeenBoard};
pub use dictionary::Dictionary;
pub use lens_fit::{FEWEST_CORNERS, LensFit};
