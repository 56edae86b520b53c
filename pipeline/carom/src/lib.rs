//! The command line of carom: commands, the pipeline, its files, trials and the report.
//!
//! [`execute`] does what [`Cli`] asks and returns the [`Output`]; [`program`] prints it and chooses the exit code.

mod args;
mod beside;
mod cli;
mod commands;
mod dataset;
mod difference;
mod error;
mod fetching;
mod first_version;
mod growth;
mod inputs;
mod left_out;
mod naming;
mod nightly;
mod noise;
mod outputs;
mod pipeline;
mod program;
mod proposal;
mod publishing;
mod reading;
mod report;
mod results;
mod robot;
mod score;
mod signing;
mod steps;
mod summary;
mod told;
mod tracking;
mod trial;
mod varying;
mod view;
mod words;

pub use cli::{Cli, about, execute};
pub use error::{Error, Outcome, Output};
pub use program::program;
