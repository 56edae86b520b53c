//! The parts of a night: its gates, what is new, its record (`nightly.json`), and that of a fleet's (`fleet.json`).

mod change;
mod executor_gate;
mod fleet;
mod held_out_gate;
mod mlflow;
mod night;

pub use change::{Change, Since};
pub use executor_gate::{ExecutorGate, plan_paths, promised};
pub use fleet::{FleetNight, RigNight, recipes};
pub use held_out_gate::{HeldOutGate, compare_held_out, unseen};
pub use mlflow::Server;
pub use night::{Log, Night, Status, changed, gone, keep, kept, new_strikes};
