//! The commands of one step each, which go on with a run: `carom sysid`, `diagnose`, …, `publish`.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::args::{Global, SignArgs};
use crate::error::Output;
use crate::inputs::Inputs;
use crate::pipeline::Step;
use crate::steps::{advance, open};
use crate::{Error, signing};

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
pub fn run(args: &DirArgs, last: Step, global: Global) -> Result<Output, Error> {
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
