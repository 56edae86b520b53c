//! Trials in closed loop: targets, strikes and their results (`trial.json`).

mod closed_loop;
mod outcome;
mod targets;

pub use closed_loop::{TrialSettings, run};
pub use outcome::{Outcome, TargetStrike, Trial, kept};
