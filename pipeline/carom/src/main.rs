//! `carom`: the pipeline's command line.

use std::io::Write;
use std::process::ExitCode;

use carom::{Cli, Outcome, execute};
use clap::Parser;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let code = |outcome: Outcome| ExitCode::from(outcome as u8);
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
            // A reader that has gone, such as `head`, is no failure.
            drop(printed);
            code(output.outcome)
        }
        Err(error) => {
            if !cli.logs_json() {
                eprintln!("carom: failed to {error}");
            }
            code(error.outcome())
        }
    }
}
