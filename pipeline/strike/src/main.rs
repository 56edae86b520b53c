//! `strike`: plans a strike from an artifact, and makes it.

mod cli;

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    // With a value it names an artifact's.
    if std::env::args_os().skip(1).eq(["--version"]) {
        let said = writeln!(std::io::stdout(), "strike {}", strike::BUILD);
        return said.map_or(ExitCode::FAILURE, |()| ExitCode::SUCCESS);
    }
    let args = cli::Args::parse();
    cli::run(&args).unwrap_or_else(|failure| {
        if args.json {
            let _ = writeln!(std::io::stdout(), "{}", failure.to_json());
        }
        strike::tell(&format!("strike: {failure}"));
        failure.code()
    })
}
