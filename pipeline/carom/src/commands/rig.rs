//! `carom rig`: a rig file to begin with.

use std::path::{Path, PathBuf};

use clap::Subcommand;
use serde_json::json;
use values::Rig;

use crate::Error;
use crate::args::examples;
use crate::new_file::{ORDINARY, write_new};
use crate::output::Output;

/// `carom rig`.
#[derive(Debug, Subcommand)]
pub enum RigCommand {
    /// Write a commented rig file to start from.
    #[command(after_help = examples(&["carom rig init > rig.toml", "carom rig init --out rig.toml"]))]
    Init {
        /// File to write, which must not be there yet [default: stdout].
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
    },
}

/// Does what was asked.
pub fn run(command: &RigCommand) -> Result<Output, Error> {
    let RigCommand::Init { out } = command;
    let text = init(out.as_deref())?;
    Ok(Output::done(json!({ "rig": out }), text))
}

/// Writes the commented rig file to a file that is not there yet; without a file, returns the rig file itself.
fn init(out: Option<&Path>) -> Result<String, Error> {
    let Some(path) = out else {
        return Ok(Rig::template().into());
    };
    write_new(path, ORDINARY, Rig::template().as_bytes())?;
    Ok(format!("rig file   {}\n", path.display()))
}
