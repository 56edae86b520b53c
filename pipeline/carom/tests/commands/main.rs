//! The commands of carom, as a person gives them.

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
