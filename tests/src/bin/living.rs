//! `make living`: tables that change, in the closed loop, and the page that is committed.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::PathBuf;

use anyhow::Context;
use clap::Parser;
use tests::living::nights::{NightOutcome, nights, table};
use tests::living::{Outcome, measure, page::page};

/// Strikes rigs whose tables change, and writes the page.
#[derive(Debug, Parser)]
struct Args {
    /// Rigs.
    #[arg(long, default_value_t = 30)]
    rigs: u64,
    /// Number of the first one.
    #[arg(long, default_value_t = 1)]
    first: u64,
    /// Rigs that are struck for ten nights, steady and with a change.
    #[arg(long, default_value_t = 3)]
    nights: u64,
    /// Outcomes so far, a line each: a run goes on where it was stopped.
    #[arg(long)]
    outcomes: PathBuf,
    /// The page.
    #[arg(long)]
    page: PathBuf,
}

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    let text = fs::read_to_string(&args.outcomes).unwrap_or_default();
    let mut outcomes: Vec<Outcome> = text
        .lines()
        .map(serde_json::from_str)
        .collect::<Result<_, _>>()
        .with_context(|| args.outcomes.display().to_string())?;
    for number in args.first..args.first + args.rigs {
        if outcomes.iter().any(|outcome| outcome.rig == number) {
            continue;
        }
        let scratch = tempfile::tempdir()?;
        let measured = measure(number, scratch.path())?;
        let mut file = OpenOptions::new()
            .create(true)
            .append(true)
            .open(&args.outcomes)?;
        for outcome in &measured {
            writeln!(file, "{}", serde_json::to_string(outcome)?)?;
        }
        println!("rig {number}: {} strikes at targets", measured.len());
        outcomes.extend(measured);
    }
    outcomes.retain(|o| (args.first..args.first + args.rigs).contains(&o.rig));
    let file = args.outcomes.with_extension("nights.json");
    let mut kept: Vec<NightOutcome> = match fs::read(&file) {
        Ok(bytes) => serde_json::from_slice(&bytes)?,
        Err(_) => Vec::new(),
    };
    for number in args.first..args.first + args.nights {
        for changes in [false, true] {
            if kept.iter().any(|o| (o.rig, o.changes) == (number, changes)) {
                continue;
            }
            let scratch = tempfile::tempdir()?;
            kept.extend(nights(number, changes, scratch.path())?);
            fs::write(&file, serde_json::to_vec(&kept)?)?;
        }
    }
    fs::write(&args.page, page(&outcomes) + "\n" + &table(&kept))?;
    Ok(())
}
