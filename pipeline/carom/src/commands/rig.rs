//! `carom rig`: a rig file to begin with.

use std::path::PathBuf;

use clap::Subcommand;
use serde_json::json;
use values::Rig;

use crate::Error;
use crate::args::examples;
use crate::error::Output;
use crate::outputs::{ORDINARY, write_new};
use crate::proposal::propose;

/// `carom rig`.
#[derive(Debug, Subcommand)]
pub enum RigCommand {
    /// Write a commented rig file to start from.
    #[command(after_help = examples(&["carom rig init > rig.toml", "carom rig init --from logs/day_1.mcap --out rig.toml"]))]
    Init {
        /// Log to take topics, fields, rates, noise, bounds and limits from: a file, or a rosbag2 folder.
        #[arg(long, value_name = "LOG")]
        from: Option<PathBuf>,
        /// File to write, which must not be there yet [default: stdout].
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
    },
}

/// Does what was asked.
pub fn run(command: &RigCommand) -> Result<Output, Error> {
    let RigCommand::Init { from, out } = command;
    let text = match from {
        Some(log) => propose(log)?,
        None => Rig::template().into(),
    };
    let json = json!({ "rig": out, "text": text });
    let Some(path) = out else {
        return Ok(Output::done(json, text));
    };
    write_new(path, ORDINARY, text.as_bytes())?;
    // What was found in a log stands in its first lines.
    let found = text.lines().take_while(|line| line.starts_with("# "));
    let found: String = found
        .filter(|_| from.is_some())
        .map(|line| format!("{}\n", &line[2..]))
        .collect();
    Ok(Output::done(
        json,
        format!("{found}rig file   {}\n", path.display()),
    ))
}
