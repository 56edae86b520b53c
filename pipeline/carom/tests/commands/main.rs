//! The commands of carom, as a person gives them.

mod fixture;
mod logs;
mod runs;
