//! From images to centroids: how far they are off, and what is said where there is none.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod accuracy;
mod board;
mod camera;
mod camera_info;
mod common;
mod film;
mod hostile;
mod jpeg;
mod learned;
mod logs;
mod marker;
mod readout;
mod video;
