//! `carom`: the pipeline's command line.

use std::process::ExitCode;

fn main() -> ExitCode {
    if let Err(error) = strike::unblock_signals() {
        strike::tell(&format!("carom: failed to unblock signals: {error}"));
        return ExitCode::FAILURE;
    }
    carom::program(std::env::args_os(), option_env!("CAROM_COMMIT")).into()
}
