//! `carom run`: the whole pipeline; `carom ingest`: its first step; the commands of one step each, which go on with a run: `carom sysid`,
//! `diagnose`, …, `publish`; `carom report`: the HTML report again.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use crate::args::{Global, LogsArgs, SignArgs};
use crate::error::Output;
use crate::inputs::Inputs;
use crate::pipeline::{Step, pipeline};
use crate::steps::{advance, open};
use crate::{Error, report, signing};

/// `carom run`.
#[derive(Args, Debug)]
pub struct RunArgs {
    /// What to run on.
    #[command(flatten)]
    pub logs: LogsArgs,
    /// Who signs.
    #[command(flatten)]
    pub sign: SignArgs,
}

/// Runs the whole pipeline.
pub fn run(args: &RunArgs, global: Global) -> Result<Output, Error> {
    begin(&args.logs, Step::Publish, args.sign.key.as_deref(), global)
}

/// Reads logs and finds the strikes in them.
pub fn ingest(args: &LogsArgs, global: Global) -> Result<Output, Error> {
    begin(args, Step::Ingest, None, global)
}

/// A new run, or an earlier one with other logs.
fn begin(args: &LogsArgs, last: Step, key: Option<&Path>, global: Global) -> Result<Output, Error> {
    let inputs = Inputs::named(args)?;
    let store = signing::store(&args.out, key)?;
    let run = open(&args.out, global)?;
    inputs.keep(&args.out)?;
    advance(&run, &store, &inputs, last, global)
}

/// A run's folder.
#[derive(Args, Debug)]
pub struct DirArgs {
    /// Folder of a run that has ingested logs.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// `carom publish`.
#[derive(Args, Debug)]
pub struct PublishArgs {
    /// Folder of a run that has ingested logs.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Who signs.
    #[command(flatten)]
    pub sign: SignArgs,
}

/// Goes on with what the run was given, up to and with `last`.
pub fn proceed_to(args: &DirArgs, last: Step, global: Global) -> Result<Output, Error> {
    proceed(&args.out, None, last, global)
}

/// Publishes a version.
pub fn publish(args: &PublishArgs, global: Global) -> Result<Output, Error> {
    proceed(&args.out, args.sign.key.as_deref(), Step::Publish, global)
}

fn proceed(dir: &Path, key: Option<&Path>, last: Step, global: Global) -> Result<Output, Error> {
    let inputs = Inputs::kept(dir)?;
    let store = signing::store(dir, key)?;
    let run = open(dir, global)?;
    advance(&run, &store, &inputs, last, global)
}

/// `carom report`.
#[derive(Args, Debug)]
pub struct ReportArgs {
    /// Folder of a run.
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
}

/// Writes the report of what the run's cache holds; what is missing is computed, and nothing is published.
pub fn report(args: &ReportArgs, global: Global) -> Result<Output, Error> {
    let inputs = Inputs::kept(&args.dir)?;
    let run = open(&args.dir, global)?;
    let results = pipeline(&run, &inputs, Step::Publish)?;
    let path = report::write(&args.dir, &inputs, &results, None)?;
    Ok(Output::done(
        json!({ "report": path }),
        format!("report     {path}\n"),
    ))
}
