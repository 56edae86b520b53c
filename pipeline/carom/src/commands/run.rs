//! `carom run`: the whole pipeline; `carom ingest`: its first step.

use std::path::Path;

use clap::Args;

use crate::args::{Global, LogsArgs, SignArgs};
use crate::error::Output;
use crate::inputs::Inputs;
use crate::pipeline::Step;
use crate::steps::{advance, open};
use crate::{Error, signing};

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
