//! `carom` with a fault set on purpose: `faulty FAULT STEP COMMAND…` runs a command of carom whose STEP-th step on the disk is
//! struck. `kill` ends the program there by SIGKILL, in the middle of a write; `full` and `io` fail that step as a full disk or
//! a broken one does. The last line on standard error says how many steps were taken, and the peak memory.

use std::io;
use std::process::{Command, ExitCode};
use std::thread;

use clap::Parser;

fn main() -> ExitCode {
    let mut words = std::env::args().skip(1);
    let (fault, step) = (
        words.next(),
        words.next().and_then(|step| step.parse().ok()),
    );
    let fault: fn() -> io::Error = match (fault.as_deref(), step) {
        (Some("kill"), Some(_)) => killed,
        (Some("full"), Some(_)) => || io::ErrorKind::StorageFull.into(),
        (Some("io"), Some(_)) => || io::Error::from_raw_os_error(5),
        _ => {
            eprintln!(
                "faulty: give kill, full or io, the number of a step (0 for none), and a command of carom"
            );
            return ExitCode::from(carom::Outcome::BadInput as u8);
        }
    };
    durable::faults::everywhere(step.unwrap_or(0), fault);
    let cli = carom::Cli::parse_from(
        ["carom".to_string(), "--quiet".to_string()]
            .into_iter()
            .chain(words),
    );
    let outcome = match carom::execute(&cli) {
        Ok(said) => {
            println!("{}", said.json);
            said.outcome
        }
        Err(error) => {
            eprintln!("carom: failed to {error}");
            error.outcome()
        }
    };
    let memory = tests::soak::peak_memory().unwrap_or(0);
    eprintln!("{} steps, {memory} bytes", durable::faults::taken());
    ExitCode::from(outcome as u8)
}

/// By the system's own SIGKILL: nothing is flushed, nothing cleaned up.
fn killed() -> io::Error {
    let own = std::process::id().to_string();
    if let Err(error) = Command::new("kill").args(["-9", &own]).status() {
        return error;
    }
    loop {
        thread::park();
    }
}
