//! The executor: loads an artifact, plans a strike, checks every limit, strikes, and logs it.
//!
//! [`Trust::load`] takes a version only if a configured key signed it and none newer was seen.
//! [`Planner::plan`] solves for a command, adds the residual and answers with a [`Plan`] or a [`Refusal`]: what breaks a
//! limit is refused, never clamped. [`execute`] hands a plan to a [`Robot`]; [`OpenLog`] keeps what it recorded, in the
//! form that `carom run` ingests. Polars, arrow and burn are absent on purpose: this runs on the robot's own computer.

mod about;
mod args;
pub mod batch;
mod clearance;
pub mod collect;
mod command;
mod config;
mod correction;
mod count;
mod epoch;
mod error;
pub mod identity;
mod last_stop;
mod limits;
mod live;
mod log;
mod motion;
mod plan;
mod planner;
mod recent;
mod refusal;
mod robot;
mod stroke;
#[cfg(test)]
mod testing;
mod trust;
mod watched;

pub use about::{about, built_from};
pub use args::Args;
pub use command::CommandPlanner;
pub use config::{Config, ConfigError};
pub use count::take_number;
pub use epoch::Epoch;
pub use error::PlannerError;
pub use last_stop::{Memory, NoMemory, memory_folder};
pub use live::{Live, LiveError, Resting, ServerMessage, read_messages};
pub use log::{Destination, LogError, OpenLog, WrittenLog, highest};
pub use logs::write::{Lineage, Received, Samples};
pub use plan::{Adapted, Details, FEW, Plan};
pub use planner::Planner;
pub use recent::{Recent, SESSION_GAP};
pub use refusal::{Reason, Refusal};
pub use robot::arm::{Guarded, Look, catch_signals, tell, told, unblock_signals};
pub use robot::{Choice, DryRun, Robot, RobotError, StrikeRecord, UnknownRobot, execute};
#[cfg(feature = "sim")]
pub use robot::{SimRobot, TruthSource};
pub use robot::{arm, ur, xarm};
pub use stroke::{Ramp, Stroke};
pub use trust::{Trust, TrustError, allows};
pub use watched::{Seen, Watched, strike_and_keep};
