//! A run for viewers: each strike's measured track beside the simulated ones, in the messages that Foxglove and Rerun draw.
//!
//! Strikes follow each other on the file's clock, which begins at the first one's stamp, so that a player shows one after another. Lines,
//! arrows and texts are `foxglove.SceneUpdate`, which Rerun does not draw: tracks, outlines, stops and effects are point clouds as well. Images of the
//! logs are beside them, small and not all.

mod draw;
mod effects;
mod images;
mod messages;
mod show;

pub use images::images;
pub use show::{Shown, show};
