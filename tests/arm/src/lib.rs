//! An emulator of an xArm7's controller: control port, real-time and ordinary report, motion limited in acceleration and jerk,
//! and the faults that can be made in it. The maker's own SDK drives it unchanged (`make arm`).
//!
//! Frames and motion are written here anew from the maker's layouts and from the literature, apart from the driver's and the
//! planner's. An arm may have a [`Table`] before it, whose object it strikes, and a camera that publishes where that object is.

mod fault;
pub mod foxglove;
mod frames;
mod motion;
mod server;
mod state;
mod table;

pub use fault::{Fault, Step};
pub use frames::Request;
pub use server::{Emulator, Listening};
pub use state::{Event, Model};
pub use table::Table;
