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
mod view;
mod words;

use std::ffi::OsString;
use std::io::{ErrorKind, Write};

use clap::{CommandFactory, FromArgMatches};

pub use cli::{Cli, about, execute};
pub use error::{Error, Outcome, Output};

/// Runs a command line whose first word is the program's name, prints what comes of it, and gives the exit code. `commit` is what
/// it was built from.
pub fn program(words: impl IntoIterator<Item = OsString>, commit: Option<&'static str>) -> u8 {
    strike::built_from(commit);
    let parser = Cli::command().version(&*about().leak());
    let parsed = parser
        .try_get_matches_from(words)
        .and_then(|asked| Cli::from_arg_matches(&asked));
    let cli = match parsed {
        Ok(cli) => cli,
        // Help and version are such errors, too.
        Err(error) => {
            let _ = error.print();
            return u8::try_from(error.exit_code()).unwrap_or(Outcome::BadInput as u8);
        }
    };
    if let Some(threads) = cli.global.threads {
        // Fails only where a pool is there already, and none is.
        let _ = rayon::ThreadPoolBuilder::new()
            .num_threads(usize::from(threads))
            .build_global();
    }
    match execute(&cli) {
        Ok(output) => {
            let mut stdout = std::io::stdout().lock();
            let printed = if cli.global.json {
                writeln!(stdout, "{}", output.json)
            } else {
                write!(stdout, "{}", output.text)
            };
            match printed.and_then(|()| stdout.flush()) {
                // A reader that has gone, such as `head`, is no failure.
                Err(error) if error.kind() != ErrorKind::BrokenPipe => {
                    strike::tell(&format!("carom: failed to print the result: {error}"));
                    Outcome::Failed as u8
                }
                _ => output.outcome as u8,
            }
        }
        Err(error) => {
            if !cli.logs_json() {
                strike::tell(&format!("carom: failed to {error}"));
            }
            error.outcome() as u8
        }
    }
}
