//! The parts of a night: its gates, what is new, and its record (`nightly.json`).

mod executor_gate;
mod held_out_gate;
mod log;
mod new_data;
mod night;

pub use executor_gate::plan_paths;
pub use held_out_gate::{compare_held_out, held_out};
pub use log::Log;
pub use new_data::{changed, new_strikes};
pub use night::{Night, Status, keep, kept};
