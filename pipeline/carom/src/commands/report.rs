//! `carom report`: the HTML report again.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use crate::args::Global;
use crate::error::Output;
use crate::inputs::Inputs;
use crate::pipeline::{Step, pipeline};
use crate::steps::open;
use crate::{Error, report};

/// `carom report`.
#[derive(Args, Debug)]
pub struct ReportArgs {
    /// Folder of a run.
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
}

/// Writes the report of what the run's cache holds; what is missing is computed, and nothing is published.
pub fn run(args: &ReportArgs, global: Global) -> Result<Output, Error> {
    let inputs = Inputs::kept(&args.dir)?;
    let run = open(&args.dir, global)?;
    let results = pipeline(&run, &inputs, Step::Publish)?;
    let path = report::write(&args.dir, &inputs, &results, None)?;
    Ok(Output::done(
        json!({ "report": path }),
        format!("report     {path}\n"),
    ))
}
