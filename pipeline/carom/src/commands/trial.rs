//! `carom trial`: strikes targets with each model and measures where the object stops.

use std::path::PathBuf;

use clap::Args;

use crate::args::Global;
use crate::error::{Output, to_json};
use crate::robot::TrialRobot;
use crate::trial::{self, TrialSettings};
use crate::{Error, steps, summary};

/// `carom trial`.
#[derive(Args, Debug)]
pub struct TrialArgs {
    /// Folder of a run.
    #[arg(long, value_name = "DIR")]
    pub artifacts: PathBuf,
    /// What strikes: `sim`, the embedded rig, with the hidden truth of DIR/truth.json or DIR/rig/truth.json, which `carom demo`
    /// writes; `sim:FOLDER` with the truth in FOLDER; `world`, the version's own identified world with its scatter, for a rig of your
    /// own: it shows how well the version solves and learns, and says nothing of reality.
    #[arg(long, value_name = "sim[:FOLDER]|world")]
    pub robot: TrialRobot,
    /// Random targets, struck once with each model.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(0..=100_000))]
    pub targets: u32,
    /// Strikes at each target of the paper's Figure 8, with each model.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1_000))]
    pub repeats: u32,
    /// Number of new sessions among which the random targets are dealt and struck again.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(0..=1_000))]
    pub sessions: u32,
    /// Where targets and launch scatter come from.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Version to strike with [default: the latest].
    #[arg(long, value_name = "VERSION")]
    pub version: Option<String>,
}

/// Runs the trial, keeps it in the run's folder and writes the report again where there is one.
pub fn run(args: &TrialArgs, global: Global) -> Result<Output, Error> {
    let trial = trial::run(
        &args.artifacts,
        &TrialSettings {
            robot: &args.robot,
            version: args.version.as_deref(),
            targets: args.targets as usize,
            repeats: args.repeats as usize,
            sessions: args.sessions as usize,
            seed: args.seed,
        },
        global.quiet,
    )?;
    steps::refresh_report(&args.artifacts, global)?;
    Ok(Output::done(to_json(&trial)?, summary::trial(&trial)))
}
