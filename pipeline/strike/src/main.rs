//! `strike`: plans a strike from an artifact, and makes it.

mod cli;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    let args = cli::Args::parse();
    cli::run(&args).unwrap_or_else(|failure| {
        if args.json {
            println!("{}", failure.to_json());
        }
        eprintln!("strike: {failure}");
        failure.code()
    })
}
