//! `strike`: plans a strike from an artifact, and makes it.

mod cli;

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    let args = cli::Args::parse();
    cli::run(&args).unwrap_or_else(|failure| {
        if args.json {
            let _ = writeln!(std::io::stdout(), "{}", failure.to_json());
        }
        strike::tell(&format!("strike: {failure}"));
        failure.code()
    })
}
