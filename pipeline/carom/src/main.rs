//! `carom`: the pipeline's command line.

use std::process::ExitCode;

fn main() -> ExitCode {
    carom::program(std::env::args_os(), option_env!("CAROM_COMMIT")).into()
}
