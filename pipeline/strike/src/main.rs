//! `strike`: plans a strike from an artifact, and makes it.

mod cli;

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    strike::built_from(option_env!("CAROM_COMMIT"));
    if let Err(error) = strike::unblock_signals() {
        strike::tell(&format!("strike: failed to unblock signals: {error}"));
        return ExitCode::FAILURE;
    }
    // With a value `--version` names the artifact's; alone, or as `-V`, it asks for the program's own.
    if std::env::args_os().skip(1).eq(["--version"]) || std::env::args_os().skip(1).eq(["-V"]) {
        let about = strike::about(&[("versions", store::SCHEMA_VERSION)]);
        let said = writeln!(std::io::stdout(), "strike {about}");
        return said.map_or(ExitCode::FAILURE, |()| ExitCode::SUCCESS);
    }
    let args = strike::Args::parse();
    let is_json = args.json;
    cli::run(args).unwrap_or_else(|failure| {
        if is_json {
            let _ = writeln!(std::io::stdout(), "{}", failure.to_json());
        }
        strike::tell(&format!("strike: {failure}"));
        failure.code()
    })
}
