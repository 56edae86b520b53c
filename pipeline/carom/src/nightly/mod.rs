//! The parts of a night: its gates, what is new, its record (`nightly.json`), and that of a fleet's (`fleet.json`).

mod change;
mod executor_gate;
mod fleet;
mod held_out_gate;
mod log;
mod mlflow;
mod new_data;
mod night;

pub use change::{Change, Since};
pub use executor_gate::{ExecutorGate, plan_paths, promised};
pub use fleet::{FleetNight, RigNight, recipes};
pub use held_out_gate::{HeldOutGate, compare_held_out, unseen};
pub use log::Log;
pub use mlflow::Server;
pub use new_data::{changed, gone, new_strikes};
pub use night::{Night, Status, keep, kept};
