//! The real-time report on a thread of its own: it records what the arm does, and stops it where that is not what was commanded.

use std::io::{self, ErrorKind};
use std::net::{SocketAddr, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::control::{CONNECT, StopHandle};
use super::guard::{Guard, Line, Sample, norm};
use super::wire;

/// The arm is stopped where no report comes for so long: at 250 Hz a dozen are missing, and at 1 m/s it has moved 5 cm.
const SILENCE: Duration = Duration::from_millis(50);
/// The watch looks so often whether it is silent, or a signal came.
const TICK: Duration = Duration::from_millis(5);

/// What the watch knows.
#[derive(Debug, Default)]
struct Seen {
    last: Option<Sample>,
    /// All reports since the recording began.
    record: Vec<Sample>,
    is_recording: bool,
    guard: Option<Guard>,
    /// Why the arm was stopped; the first reason stays.
    fault: Option<String>,
}

#[derive(Debug)]
struct Shared {
    seen: Mutex<Seen>,
    news: Condvar,
    ends: AtomicBool,
    stop: StopHandle,
}

/// The thread, and what it knows.
#[derive(Debug)]
pub(super) struct Watch {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Watch {
    /// Connects to the real-time report. `stop` is used while a guard is set; `interrupted` is set by a signal.
    pub(super) fn start(
        address: SocketAddr,
        stop: StopHandle,
        interrupted: Arc<AtomicBool>,
    ) -> io::Result<Self> {
        let stream = TcpStream::connect_timeout(&address, CONNECT)?;
        stream.set_nodelay(true)?;
        let shared = Arc::new(Shared {
            seen: Mutex::default(),
            news: Condvar::new(),
            ends: AtomicBool::new(false),
            stop,
        });
        // One thread reads, and may wait for ever; the other one looks at the time.
        let reader = shared.clone();
        thread::Builder::new()
            .name("xarm-report".into())
            .spawn(move || read(&reader, stream))?;
        let timer = shared.clone();
        let thread = thread::Builder::new()
            .name("xarm-watch".into())
            .spawn(move || watch_time(&timer, &interrupted))?;
        Ok(Self {
            shared,
            thread: Some(thread),
        })
    }

    /// The next report: one that came before may be the last there is.
    pub(super) fn next(&self, patience: Duration) -> Option<Sample> {
        let asked = Instant::now();
        let until = asked + patience;
        let mut seen = self.shared.lock();
        loop {
            if let Some(last) = seen.last
                && last.at >= asked
            {
                return Some(last);
            }
            let left = until.checked_duration_since(Instant::now())?;
            let waited = self.shared.news.wait_timeout(seen, left.min(TICK));
            seen = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Why the arm was stopped; none where it was not.
    pub(super) fn fault(&self) -> Option<String> {
        self.shared.lock().fault.clone()
    }

    /// Records from now on.
    pub(super) fn record(&self) {
        let mut seen = self.shared.lock();
        seen.record.clear();
        seen.is_recording = true;
    }

    /// What was recorded until now.
    pub(super) fn recorded(&self) -> Vec<Sample> {
        self.shared.lock().record.clone()
    }

    /// Stops the arm where it does not keep to the line, from now on.
    pub(super) fn guard(&self, line: Line) {
        let mut seen = self.shared.lock();
        seen.guard = Some(Guard::new(line, seen.last));
    }

    /// Waits until the arm rests at the end of the guarded line. Errors with why it was stopped, or that the time is over.
    pub(super) fn wait_for_end(&self, patience: Duration) -> Result<(), String> {
        let until = Instant::now() + patience;
        let mut seen = self.shared.lock();
        loop {
            if let Some(fault) = &seen.fault {
                return Err(fault.clone());
            }
            let is_over = seen
                .guard
                .as_ref()
                .is_some_and(|guard| seen.last.is_some_and(|last| guard.is_over(&last)));
            if is_over {
                seen.guard = None;
                return Ok(());
            }
            let now = Instant::now();
            if now >= until {
                let why = format!("it was not over within {:.1} s", patience.as_secs_f64());
                stop(&self.shared.stop, &mut seen, why.clone());
                return Err(why);
            }
            let waited = self.shared.news.wait_timeout(seen, until - now);
            seen = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Whether the arm is seen stopped and at rest within this time; no where reports cease.
    pub(super) fn rests_within(&self, patience: Duration) -> bool {
        /// Slower than this, in mm/s, is rest.
        const REST: f64 = 1.0;
        /// State of a controller that was stopped; what is above it is an error's.
        const STOPPED: u8 = 4;
        let until = Instant::now() + patience;
        while Instant::now() < until {
            let last = self.shared.lock().last;
            let Some(last) = last.filter(|last| last.at.elapsed() <= SILENCE) else {
                return false;
            };
            if norm(last.report.velocity) < REST && last.report.state >= STOPPED {
                return true;
            }
            thread::sleep(TICK);
        }
        false
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.shared.ends.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // It ends within a tick; that it panicked is known by now.
            let _ = thread.join();
        }
    }
}

impl Shared {
    fn lock(&self) -> std::sync::MutexGuard<'_, Seen> {
        self.seen.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Notes why, and stops the arm.
fn stop(handle: &StopHandle, seen: &mut Seen, why: String) {
    let sent = handle.stop();
    let why = match sent {
        Ok(()) => why,
        Err(error) => format!("{why}; and the stop could not be sent: {error}"),
    };
    seen.fault.get_or_insert(why);
    seen.guard = None;
}

/// Reads reports until the connection ends.
fn read(shared: &Shared, mut stream: TcpStream) {
    // So that the thread ends with the watch even where nothing comes any more.
    let _ = stream.set_read_timeout(Some(Duration::from_secs(1)));
    loop {
        let read = wire::read_realtime(&mut stream);
        if shared.ends.load(Ordering::Relaxed) {
            return;
        }
        let mut seen = shared.lock();
        match read {
            Ok(report) => {
                let sample = Sample {
                    at: Instant::now(),
                    report,
                };
                let verdict = match &mut seen.guard {
                    Some(guard) => guard.judge(&sample),
                    None => Ok(()),
                };
                seen.last = Some(sample);
                if seen.is_recording {
                    seen.record.push(sample);
                }
                if let Err(why) = verdict {
                    stop(&shared.stop, &mut seen, why);
                }
            }
            Err(error) => {
                if seen.guard.is_some() {
                    let silent =
                        matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut);
                    let why = if silent {
                        "its reports ceased".to_owned()
                    } else {
                        format!("its reports broke off: {error}")
                    };
                    stop(&shared.stop, &mut seen, why);
                }
                // What broke off is not taken up again: the next strike connects anew.
                shared.news.notify_all();
                return;
            }
        }
        drop(seen);
        shared.news.notify_all();
    }
}

/// Stops the arm where no report comes, or a signal did.
fn watch_time(shared: &Shared, interrupted: &AtomicBool) {
    while !shared.ends.load(Ordering::Relaxed) {
        thread::sleep(TICK);
        let mut seen = shared.lock();
        let Some(since) = seen.guard.as_ref().map(Guard::begun) else {
            continue;
        };
        if interrupted.load(Ordering::Relaxed) {
            stop(
                &shared.stop,
                &mut seen,
                "it was interrupted by a signal".into(),
            );
            shared.news.notify_all();
            continue;
        }
        let last = seen.last.map_or(since, |last| last.at.max(since));
        let silent = last.elapsed();
        if silent > SILENCE {
            let why = format!("no report came for {} ms", silent.as_millis());
            stop(&shared.stop, &mut seen, why);
            shared.news.notify_all();
        }
    }
}
