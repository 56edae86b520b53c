//! The commands of carom, as a person gives them.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod camera;
mod collect;
mod datasets;
mod fixture;
mod fleet;
mod logs;
mod nights;
mod pixels;
mod runs;
mod shell;
mod tracks;
mod workers;
