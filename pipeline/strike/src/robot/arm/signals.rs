//! Signals that end a program, or stop it: the motion ends first, and the record is kept.

use std::fs;
use std::io::{self, Write};
use std::ops::RangeInclusive;
use std::os::unix::fs::MetadataExt;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, mpsc};
use std::thread;
use std::time::Duration;

use signal_hook::consts::signal as name;

/// Linux's signals, those for programs' own use among them, which end a program, too.
const ALL: RangeInclusive<i32> = 1..=64;
/// Those that are passed over: what cannot be caught, a program's own faults, what ends and stops nothing, and the two that are the C
/// library's.
const PASSED: [i32; 14] = [
    name::SIGKILL,
    name::SIGSTOP,
    name::SIGILL,
    name::SIGFPE,
    name::SIGSEGV,
    name::SIGBUS,
    name::SIGPIPE,
    name::SIGCHLD,
    name::SIGCONT,
    name::SIGURG,
    name::SIGWINCH,
    name::SIGXFSZ,
    32,
    33,
];

/// All that end or stop a program and can be caught. Ctrl-Z is one: a stopped program guards nothing.
fn ending() -> impl Iterator<Item = i32> {
    ALL.filter(|signal| !PASSED.contains(signal))
}

/// A flag that each of them sets, from now on. A file that grows beyond its limit is then an error of its write, which is reported, and no
/// end.
pub fn catch_signals() -> io::Result<Arc<AtomicBool>> {
    let caught = Arc::new(AtomicBool::new(false));
    for signal in ending() {
        signal_hook::flag::register(signal, caught.clone())?;
    }
    signal_hook::flag::register(name::SIGXFSZ, Arc::default())?;
    Ok(caught)
}

/// Tells a person something on standard error, wherever that leads, and whether or not anybody reads it: a terminal that is gone ends
/// nothing.
pub fn tell(what: &str) {
    let _ = told(what);
}

/// The same; errors where nothing can be written there, or where what is written is thrown away, as by a program that was started with
/// standard error closed.
pub(super) fn told(what: &str) -> io::Result<()> {
    let device = |path| fs::metadata(path).ok().map(|file| file.rdev());
    let null = device("/dev/null");
    if null.is_some() && device("/proc/self/fd/2") == null {
        return Err(io::Error::other("it is closed, or leads to /dev/null"));
    }
    io::stderr().write_all(format!("{what}\n").as_bytes())
}

/// The same at once, on standard output where standard error is gone: a terminal that holds back what is written (Ctrl-S, a pager, a slow
/// line) holds back nothing else.
pub(super) fn alarm(what: String) {
    beside(move || {
        // Where neither is left, nobody is.
        let _ = told(&what).or_else(|_| io::stdout().write_all(format!("{what}\n").as_bytes()));
    });
}

/// Does something on a thread of its own, and waits for it for a moment at the most.
fn beside(what: impl FnOnce() + Send + 'static) {
    /// Where nothing holds it back, a line is written within this time.
    const MOMENT: Duration = Duration::from_millis(20);
    let (done, is_done) = mpsc::channel();
    let does = move || {
        what();
        let _ = done.send(());
    };
    // A thread that cannot be had tells nothing; stopping goes on.
    if thread::Builder::new().spawn(does).is_ok() {
        let _ = is_done.recv_timeout(MOMENT);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::Ordering;

    use super::*;

    #[test]
    fn what_is_held_back_holds_back_nothing_else() {
        let (free, held) = mpsc::channel::<()>();
        beside(move || held.recv().unwrap_or_default());
        // It is held until now.
        free.send(()).expect("it still waits");
    }

    #[test]
    fn what_is_thrown_away_is_told_to_nobody() {
        use std::process::{Command, Stdio};
        const CHILD: &str = "CAROM_TEST_TELLS";
        if std::env::var(CHILD).is_ok_and(|reader| reader == "none") {
            told("stand clear").expect_err("it goes to /dev/null");
            return;
        }
        if std::env::var(CHILD).is_ok() {
            return told("stand clear").expect("it is read");
        }
        for (reader, stderr) in [("none", Stdio::null()), ("one", Stdio::piped())] {
            let path = std::env::current_exe().expect("this test");
            let child = Command::new(path)
                .arg("robot::arm::signals::tests::what_is_thrown_away_is_told_to_nobody")
                .arg("--exact")
                .args(["--nocapture", "--test-threads", "1"])
                .env(CHILD, reader)
                .stderr(stderr)
                .output()
                .expect("it runs");
            let told = String::from_utf8_lossy(&child.stdout);
            assert!(child.status.success(), "{reader}: {told}");
            assert!(told.contains("1 passed"), "{reader}: {told}");
        }
    }

    #[test]
    fn what_would_end_or_suspend_the_program_is_a_flag() {
        let caught = catch_signals().expect("caught");
        for signal in ending() {
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
