//! Signals that end a program, or stop it: the motion ends first, and the record is kept.

use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use signal_hook::consts::signal as name;

/// All that end or stop a program and can be caught, those of its own faults aside. Ctrl-Z is one: a stopped program guards nothing. A file
/// that grows beyond its limit is then an error of its write, which is reported, and no end.
const ENDING: [i32; 14] = [
    name::SIGHUP,
    name::SIGINT,
    name::SIGQUIT,
    name::SIGTERM,
    name::SIGTSTP,
    name::SIGTTIN,
    name::SIGUSR1,
    name::SIGUSR2,
    name::SIGALRM,
    name::SIGVTALRM,
    name::SIGPROF,
    name::SIGXCPU,
    name::SIGIO,
    name::SIGABRT,
];

/// A flag that each of them sets, from now on.
pub fn catch_signals() -> io::Result<Arc<AtomicBool>> {
    let caught = Arc::new(AtomicBool::new(false));
    for signal in ENDING {
        signal_hook::flag::register(signal, caught.clone())?;
    }
    signal_hook::flag::register(name::SIGXFSZ, Arc::default())?;
    Ok(caught)
}

/// Tells a person something on standard error, wherever that leads, and whether or not anybody reads it: a terminal that is gone ends
/// nothing.
pub fn tell(what: &str) {
    use io::Write;
    let _ = io::stderr().write_all(format!("{what}\n").as_bytes());
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::Ordering;

    use super::*;

    #[test]
    fn what_would_end_or_suspend_the_program_is_a_flag() {
        let caught = catch_signals().expect("caught");
        for signal in ENDING {
            caught.store(false, Ordering::Relaxed);
            signal_hook::low_level::raise(signal).expect("raised");
            assert!(caught.load(Ordering::Relaxed), "signal {signal}");
        }
        caught.store(false, Ordering::Relaxed);
        signal_hook::low_level::raise(name::SIGXFSZ).expect("raised");
        assert!(
            !caught.load(Ordering::Relaxed),
            "a file that is too large ends nothing"
        );
    }
}
