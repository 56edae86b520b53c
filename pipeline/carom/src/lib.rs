//! The command line of carom: arguments to a plan, the pipeline, its files, trials and the report.
//!
//! [`execute`] does what [`Cli`] asks and gives what there is to say; `main` prints it and chooses the exit code.

mod args;
mod artifacts;
mod commands;
mod dataset;
mod demo;
mod error;
mod growth;
mod inputs;
mod naming;
mod nightly;
mod noise;
mod outputs;
mod pipeline;
mod publishing;
mod reading;
mod rebuild;
mod report;
mod results;
mod robot;
mod score;
mod signing;
mod summary;
mod trial;

pub use args::Cli;
pub use commands::{Said, execute};
pub use error::{Error, Outcome};
