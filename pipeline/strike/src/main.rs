//! `strike`: plans a strike from an artifact, and makes it.

mod cli;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    cli::run(&cli::Args::parse()).unwrap_or_else(|failure| {
        eprintln!("strike: {failure}");
        failure.code()
    })
}
