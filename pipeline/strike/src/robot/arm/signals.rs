//! Signals that end a program, or stop it: the motion ends first, and the record is kept.

use std::fs;
use std::io::{self, Write};
use std::ops::RangeInclusive;
use std::os::fd::AsFd;
use std::os::unix::fs::MetadataExt;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

use nix::sys::signal::{SigSet, Signal};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use signal_hook::consts::signal as name;
use signal_hook::low_level::raise;

use super::connection::start;

/// Linux's signals, those for programs' own use among them, which end a program, too.
const ALL: RangeInclusive<i32> = 1..=64;
/// A program's own faults. Where one is met, the system ends the program; where somebody sends one, it is a signal like any other.
const FAULTS: [Signal; 4] = [
    Signal::SIGILL,
    Signal::SIGFPE,
    Signal::SIGSEGV,
    Signal::SIGBUS,
];
/// Signals that get no handler: what cannot be caught, faults, what ends and stops nothing, and the two that are the C library's.
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

/// The signals that end or stop a program and can be caught. Ctrl-Z is one: a stopped program guards nothing.
fn ending() -> impl Iterator<Item = i32> {
    ALL.filter(|signal| !PASSED.contains(signal))
}

/// Lets all signals through, whatever whoever started this program had blocked, and holds back [`FAULTS`], for this thread and those that it
/// starts: to be called before any is. Errors where the system refuses.
pub fn unblock_signals() -> io::Result<()> {
    Ok(faults().thread_set_mask()?)
}

fn faults() -> SigSet {
    FAULTS.into_iter().collect()
}

/// Installs handlers for the signals that end or stop a program, and returns the flag that each of them sets. From then on, a file that grows beyond
/// its limit is an error of its write, which is reported, and no end of the program.
pub fn catch_signals() -> io::Result<Arc<AtomicBool>> {
    let caught = Arc::new(AtomicBool::new(false));
    unblock_signals()?;
    // No handler: it would return to a fault that was met, for ever. Who waits for one sends another, which all flags are of.
    let waits = || while faults().wait().is_ok_and(|_| raise(name::SIGTERM).is_ok()) {};
    start("signals", waits)?;
    for signal in ending() {
        signal_hook::flag::register(signal, caught.clone())?;
    }
    signal_hook::flag::register(name::SIGXFSZ, Arc::default())?;
    Ok(caught)
}

/// Tells a person something on standard error, wherever that leads, and whether or not anybody reads it: a terminal that is gone ends
/// nothing, and what nobody takes holds back nothing for longer than a second.
pub fn tell(what: &str) {
    let _ = told(what, |waited| waited > Duration::from_secs(1));
}

/// Tells a person something on standard error. While nobody takes it, it waits until `gives_up`, asked with the time waited so far, says to stop.
/// Errors where nothing can be written there, or where what is written is thrown away, as by a program that was started with standard error closed.
pub fn told(what: &str, gives_up: impl Fn(Duration) -> bool) -> io::Result<()> {
    let line = format!("{what}\n");
    beside(move || write(&line), gives_up).unwrap_or_else(|| {
        Err(io::Error::other(
            "nobody reads it, and it is full or held back",
        ))
    })
}

fn write(line: &str) -> io::Result<()> {
    const NOWHERE: [&str; 4] = ["/dev/null", "/dev/zero", "/dev/random", "/dev/urandom"];
    let device = |path| fs::metadata(path).ok().map(|file| file.rdev());
    let to = device("/proc/self/fd/2").filter(|device| *device != 0);
    if let Some(path) = NOWHERE
        .iter()
        .find(|path| to.is_some() && device(path) == to)
    {
        let why = format!("it is closed, or leads to {path}");
        return Err(io::Error::other(why));
    }
    // Not by the standard library's own handle, which takes what cannot be written for written.
    let mut left = line.as_bytes();
    while !left.is_empty() {
        match rustix::io::write(io::stderr(), left) {
            Ok(count) => left = &left[count..],
            Err(Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
    }
    Ok(())
}

/// Whether standard error still has a reader, without a word to it. Errors with why not.
pub(super) fn is_read() -> Result<(), String> {
    let is_read = has_reader(io::stderr());
    is_read.then_some(()).ok_or_else(|| {
        "whoever read standard error is gone, so that nobody would be told what the arm does".into()
    })
}

fn has_reader(to: impl AsFd) -> bool {
    let mut asked = [PollFd::new(&to, PollFlags::empty())];
    let gone = PollFlags::ERR | PollFlags::HUP | PollFlags::NVAL;
    let answer = poll(&mut asked, Some(&Timespec::default()));
    answer.is_ok() && !asked[0].revents().intersects(gone)
}

/// Tells at once, on standard output where standard error is gone: a terminal that holds back what is written (Ctrl-S, a pager, a slow
/// line) holds back nothing else.
pub(super) fn alarm(what: String) {
    let line = format!("{what}\n");
    let tells = move || {
        // Where neither is left, nobody is.
        let _ = write(&line).or_else(|_| io::stdout().write_all(line.as_bytes()));
    };
    beside(tells, |_| true);
}

/// Runs a function on a thread of its own and waits for it until `gives_up`, asked with the time waited so far, says to stop: its value, or none
/// where it was given up. Where no thread can be had, it runs here.
fn beside<T: Send + 'static>(
    what: impl Fn() -> T + Send + Sync + 'static,
    gives_up: impl Fn(Duration) -> bool,
) -> Option<T> {
    /// Where nothing holds it back, a line is written within this time.
    const MOMENT: Duration = Duration::from_millis(20);
    let (begun, (done, is_done)) = (Instant::now(), mpsc::channel());
    let what = Arc::new(what);
    let does = what.clone();
    if start("tells", move || done.send(does())).is_err() {
        return Some(what());
    }
    loop {
        match is_done.recv_timeout(MOMENT) {
            Err(RecvTimeoutError::Timeout) if !gives_up(begun.elapsed()) => {}
            outcome => return outcome.ok(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;
    use std::sync::atomic::Ordering;
    use std::thread;

    use nix::sys::signal::kill;
    use nix::unistd::Pid;

    use super::*;

    #[test]
    fn what_is_held_back_holds_back_nothing_else() {
        let (free, held) = mpsc::channel::<()>();
        let held = Mutex::new(held);
        let waits = move || {
            held.lock()
                .map_or((), |held| held.recv().unwrap_or_default())
        };
        let outcome = beside(waits, |_| true);
        assert_eq!(outcome, None);
        // It is held until now.
        free.send(()).expect("it still waits");
    }

    #[test]
    fn what_must_be_told_is_told_where_no_thread_can_be_had() {
        const CHILD: &str = "CAROM_TEST_NO_THREAD";
        if std::env::var_os(CHILD).is_some() {
            start("one", || ()).expect_err("no stack is so large");
            alarm("press it".into());
            return told("stand clear", |_| true).expect("it is told");
        }
        let child = std::process::Command::new(std::env::current_exe().expect("this test"))
            .arg("robot::arm::signals::tests::what_must_be_told_is_told_where_no_thread_can_be_had")
            .args(["--exact", "--nocapture", "--test-threads", "1"])
            .env(CHILD, "1")
            .env("RUST_MIN_STACK", (1u64 << 50).to_string())
            .output()
            .expect("it runs");
        let told = String::from_utf8_lossy(&child.stderr);
        assert!(child.status.success(), "{child:?}");
        assert!(
            told.contains("press it") && told.contains("stand clear"),
            "{told}"
        );
    }

    #[test]
    fn a_reader_that_is_gone_is_seen_before_a_word_is_written() {
        let (reader, writer) = io::pipe().expect("a pipe");
        assert!(has_reader(&writer));
        drop(reader);
        assert!(!has_reader(&writer));
    }

    #[test]
    fn what_is_thrown_away_or_read_by_nobody_is_told_to_nobody() {
        use std::process::{Command, Stdio};
        const CHILD: &str = "CAROM_TEST_TELLS";
        let words = || told("stand clear", |waited| waited > Duration::from_millis(50));
        match std::env::var(CHILD).as_deref() {
            Ok("one") => return words().expect("it is read"),
            Ok(_) => {
                words().expect_err("it goes nowhere, or nobody takes it");
                // A program's last words are not waited for for ever.
                return tell("it failed");
            }
            Err(_) => {}
        }
        let (_unread, mut full) = io::pipe().expect("a pipe");
        rustix::io::ioctl_fionbio(&full, true).expect("set");
        while full.write(&[0; 4096]).is_ok() {}
        rustix::io::ioctl_fionbio(&full, false).expect("set");
        let opened = |path: &str, writes: bool| {
            let file = fs::OpenOptions::new()
                .read(!writes)
                .write(writes)
                .open(path);
            file.expect("opens").into()
        };
        for (reader, stderr) in [
            ("none", Stdio::null()),
            ("none", opened("/dev/zero", true)),
            ("none", opened("/dev/zero", false)),
            // Open, and not writable.
            ("none", opened("/proc/self/exe", false)),
            ("one", Stdio::piped()),
            ("one that sleeps", full.into()),
        ] {
            let path = std::env::current_exe().expect("this test");
            let child = Command::new(path)
                .arg("robot::arm::signals::tests::what_is_thrown_away_or_read_by_nobody_is_told_to_nobody")
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
    fn signals_that_were_blocked_before_or_tell_of_faults_are_a_flag_too() {
        const CHILD: &str = "CAROM_TEST_BLOCKED";
        if std::env::var_os(CHILD).is_some() {
            let caught = catch_signals().expect("caught");
            for signal in FAULTS.into_iter().chain([Signal::SIGTERM, Signal::SIGHUP]) {
                caught.store(false, Ordering::Relaxed);
                kill(Pid::this(), signal).expect("sent");
                let sent = Instant::now();
                while !caught.load(Ordering::Relaxed) {
                    assert!(sent.elapsed() < Duration::from_secs(20), "{signal}");
                    thread::sleep(Duration::from_millis(1));
                }
            }
            return;
        }
        let child = thread::spawn(|| {
            SigSet::all().thread_block().expect("blocked");
            std::process::Command::new(std::env::current_exe().expect("this test"))
                .arg("robot::arm::signals::tests::signals_that_were_blocked_before_or_tell_of_faults_are_a_flag_too")
                .args(["--exact", "--nocapture", "--test-threads", "1"])
                .env(CHILD, "1")
                .output()
        });
        let child = child.join().expect("ends").expect("it runs");
        let told = String::from_utf8_lossy(&child.stdout);
        assert!(
            child.status.success() && told.contains("1 passed"),
            "{child:?}"
        );
    }

    #[test]
    fn what_would_end_or_suspend_the_program_is_a_flag() {
        let caught = catch_signals().expect("caught");
        for signal in ending() {
            caught.store(false, Ordering::Relaxed);
            raise(signal).expect("raised");
            assert!(caught.load(Ordering::Relaxed), "signal {signal}");
        }
        caught.store(false, Ordering::Relaxed);
        raise(name::SIGXFSZ).expect("raised");
        assert!(
            !caught.load(Ordering::Relaxed),
            "a file that is too large ends nothing"
        );
    }
}
