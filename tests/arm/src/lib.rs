//! An emulator of an xArm7's controller: control port, real-time and ordinary report, motion limited in acceleration and jerk,
//! and the faults that can be made in it. The maker's own SDK drives it unchanged (`make arm`).
//!
//! The frames are written here anew from the maker's layouts, apart from the driver's; only the ramp of a speed is shared.

mod fault;
mod frames;
mod motion;
mod server;
mod state;

pub use fault::{Fault, Step};
pub use frames::Request;
pub use server::{Emulator, Listening};
pub use state::{Event, Model};
