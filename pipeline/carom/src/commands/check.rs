//! `carom check`: whether logs mean what the rig file says, before anything is fitted.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use crate::args::Global;
use crate::error::{Outcome, Output};
use crate::fetching::Fetch;
use crate::inputs::{find_logs, load_rig};
use crate::steps::open;
use crate::{Error, reading, summary};

/// `carom check`.
#[derive(Args, Debug)]
pub struct CheckArgs {
    /// MCAP files, or folders that are searched for them with all below.
    #[arg(required = true, value_name = "LOGS")]
    pub logs: Vec<PathBuf>,
    /// The rig file.
    #[arg(long, value_name = "FILE")]
    pub rig: PathBuf,
}

/// Reads the logs and says what is wrong or doubtful.
pub fn run(args: &CheckArgs, global: Global) -> Result<Output, Error> {
    let rig = load_rig(&args.rig)?;
    let logs = find_logs(
        &args.logs,
        &Fetch {
            rig: Some(&rig),
            run: None,
        },
    )?;
    let scratch = tempfile::tempdir().map_err(Error::failed)?;
    let run = open(scratch.path(), global)?;
    let read = reading::read(&run, &rig, &logs, 0)?;
    let outcome = if read.check.is_meaningless() {
        Outcome::Refused
    } else {
        read.outcome()
    };
    let mut text = format!(
        "strikes    {} kept, {} rejected\n",
        read.strikes.len(),
        read.rejects.len()
    );
    for note in &read.notes {
        text += &format!("           {note}\n");
    }
    text += &summary::measured(&read.check.measured);
    text += &summary::findings(&read.check, &rig, check::Severity::Told);
    if read
        .check
        .findings
        .iter()
        .all(|f| f.severity() == check::Severity::Told)
    {
        text += "check      frames, clocks and units are as the rig file says\n";
    }
    let json = json!({
        "strikes": read.strikes.len(),
        "rejects": read.rejects,
        "log_notes": read.notes,
        "findings": summary::findings_json(&read.check, &rig),
        "measured": read.check.measured,
        "meaningless": read.check.is_meaningless(),
    });
    Ok(Output::ended(outcome, json, text))
}
