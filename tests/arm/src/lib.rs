//! Emulators of an xArm7's controller (control port, real-time, ordinary and rich report) and of Universal Robots' (RTDE, scripts,
//! dashboard): motion limited in acceleration and jerk, and the faults that can be made in them. The maker's own SDK drives the first, and
//! `ur-rtde` reads the second, both unchanged (`make arm`).
//!
//! Frames and motion are written here anew from the maker's layouts and from the literature, apart from the driver's and the
//! planner's. An arm may have a [`Table`] before it, whose object it strikes, and a camera that publishes where that object is.

#![expect(missing_docs, reason = "its own tests alone use it")]

mod fault;
pub mod foxglove;
mod frames;
mod maker;
mod model;
mod motion;
mod server;
mod shared;
mod state;
mod table;
mod ur;

pub use fault::{Fault, Step};
pub use frames::Request;
pub use maker::connect_to;
pub use model::Model;
pub use server::{Emulator, Listening, Maker};
pub use state::Event;
pub use table::Table;
