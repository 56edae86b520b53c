//! Many nights on data that grow, with a fault in each, drawn at random: what was logged is not lost, the version in use is the
//! right one after every night, and the memory does not grow.
//!
//! A night is struck by its fault, in a program of its own; the next morning what a person would mend is mended (a log that was
//! still being copied, a version restored from the robot's copy), and the night is run again, undisturbed.

mod fault;
mod folder;
mod nights;

pub use fault::Fault;
pub use folder::{Ended, Folder, ended, peak_memory};
pub use nights::{Settings, Soaked, soak};
