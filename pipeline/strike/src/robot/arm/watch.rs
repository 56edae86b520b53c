//! The stream of reports on a thread of its own: it records what the arm does, and stops it where that is not what was commanded.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::connection::{is_nothing_yet, start, what_happened};
use super::driver::{Condition, Report, Reports, distance};
use super::guard::{ASIDE, Clocks, Guard, OnLine, STILL, Sample};
use super::line::Line;
use super::outlet::Outlet;

/// Time without a report after which the arm is stopped: at 250 Hz a dozen are missing, and at 1 m/s it has moved 5 cm.
const SILENCE: Duration = Duration::from_millis(50);
/// Time between two looks whether reports have ceased, or a signal came.
const TICK: Duration = Duration::from_millis(5);
/// Recent reports that are held, to see a rest in their positions.
const RECENT: Duration = Duration::from_millis(150);
/// Least number of recent reports: an arm that reports less often is not guarded in time.
const FEWEST: usize = 12;
/// Distance in m within which positions show an arm at rest: at least three quarters of those of that time lie within it.
const REST: f64 = 0.0003;

#[derive(Debug, Default)]
struct Seen {
    last: Option<Sample>,
    recent: Vec<Sample>,
    clocks: Clocks,
    /// All reports since the recording began.
    record: Vec<Sample>,
    is_recording: bool,
    guard: Option<Guard>,
    /// Position where the arm was found, or left after a strike: what moves it from there is somebody else.
    left: Option<[f64; 3]>,
    /// Whether its brakes are opening: an arm then sags by what the guard lets it be off.
    may_sag: bool,
    /// Why this program stopped the arm; the first reason stays.
    fault: Option<String>,
    /// Who else stopped the arm since this watch began, in the controller's words.
    taken: Option<String>,
    /// Why no report comes any more.
    broken: Option<String>,
}

#[derive(Debug)]
struct Shared {
    seen: Mutex<Seen>,
    news: Condvar,
    ends: AtomicBool,
    outlet: Outlet,
}

/// Stops the arm where the object is seen moved while the tip runs up to it.
#[derive(Clone, Debug)]
pub(crate) struct RunUp {
    shared: Arc<Shared>,
}

impl RunUp {
    /// Stops the arm because a message that came at a moment showed what must end the strike. Stops nothing where the tip may have touched the object
    /// by then.
    pub(crate) fn stop(&self, at: Instant, why: &str) {
        let mut seen = self.shared.lock();
        let line = seen.guard.as_ref().and_then(Guard::on_line);
        if line.is_some_and(|line| line.runs_up(at)) {
            stop(&self.shared.outlet, &mut seen, why.into());
            self.shared.news.notify_all();
        }
    }
}

#[derive(Debug)]
pub(super) struct Watch {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Watch {
    /// Reads reports from now on. The outlet's stop is used while a guard is set; `interrupted` is set by a signal.
    pub(super) fn start(
        reports: Box<dyn Reports>,
        outlet: Outlet,
        interrupted: Arc<AtomicBool>,
    ) -> io::Result<Self> {
        let shared = Arc::new(Shared {
            seen: Mutex::default(),
            news: Condvar::new(),
            ends: AtomicBool::new(false),
            outlet,
        });
        // One thread reads, and may wait for a second; the other one looks at the time.
        let reader = shared.clone();
        start("arm-reports", move || read(&reader, reports))?;
        let timer = shared.clone();
        let thread = start("arm-watch", move || watch_time(&timer, &interrupted))?;
        Ok(Self {
            shared,
            thread: Some(thread),
        })
    }

    /// A handle that stops the arm as the guard does, from the thread that receives the camera.
    pub(super) fn run_up(&self) -> RunUp {
        let shared = self.shared.clone();
        RunUp { shared }
    }

    /// The next report that is not late: one that came before may be the last there is, and what was held on its way says what was.
    pub(super) fn next(&self, patience: Duration) -> Result<Sample, String> {
        let asked = Instant::now();
        let mut seen = self.shared.lock();
        loop {
            if let Some(last) = seen.last
                && last.at >= asked
                && Clocks::judge((last.at - last.made).as_secs_f64()).is_ok()
            {
                return Ok(last);
            }
            if let Some(broken) = &seen.broken {
                return Err(broken.clone());
            }
            let Some(left) = patience.checked_sub(asked.elapsed()) else {
                return Err("no report comes".into());
            };
            let waited = self.shared.news.wait_timeout(seen, left.min(TICK));
            seen = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Why this program stopped the arm; none where it was not.
    pub(super) fn fault(&self) -> Option<String> {
        self.shared.lock().fault.clone()
    }

    /// Who else has stopped the arm, or taken it, since this watch began.
    pub(super) fn taken(&self) -> Option<String> {
        self.shared.lock().taken.clone()
    }

    /// Why no report comes any more.
    pub(super) fn broken(&self) -> Option<String> {
        self.shared.lock().broken.clone()
    }

    pub(super) fn record(&self) {
        let mut seen = self.shared.lock();
        seen.record.clear();
        seen.is_recording = true;
    }

    /// Ends the recording, and returns what was recorded.
    pub(super) fn recorded(&self) -> Vec<Sample> {
        let mut seen = self.shared.lock();
        seen.is_recording = false;
        std::mem::take(&mut seen.record)
    }

    /// Stops the arm where it does not keep to the line, from now on.
    pub(super) fn guard(&self, line: Line) {
        let mut seen = self.shared.lock();
        let on_line = OnLine::new(line, seen.last);
        seen.guard = Some(Guard::Line(Box::new(on_line)));
        seen.left = None;
    }

    /// Stops the arm where it moves, from now on.
    pub(super) fn guard_rest(&self) {
        let mut seen = self.shared.lock();
        seen.guard = Some(Guard::Rest(None));
        (seen.left, seen.may_sag) = (None, false);
    }

    /// Notes that the brakes open: until rest is guarded, the arm may sag by as much as it may be off a line. What was checked is checked again after
    /// that.
    pub(super) fn brakes_open(&self) {
        self.shared.lock().may_sag = true;
    }

    /// Stops the arm no more; whether anybody moves it is still seen.
    pub(super) fn release(&self) {
        let mut seen = self.shared.lock();
        seen.guard = None;
        seen.left = seen.last.map(|last| last.report.pose.at);
    }

    /// Waits until the arm rests at the end of the guarded line; from then on its rest is guarded. Errors with why it was stopped, or that
    /// the time is over.
    pub(super) fn wait_for_end(&self, patience: Duration) -> Result<(), String> {
        let until = Instant::now() + patience;
        let mut seen = self.shared.lock();
        loop {
            if let Some(fault) = &seen.fault {
                return Err(fault.clone());
            }
            let line = seen.guard.as_ref().and_then(Guard::on_line);
            if line.is_some_and(OnLine::is_over) {
                seen.guard = Some(Guard::Rest(None));
                return Ok(());
            }
            let now = Instant::now();
            if now >= until {
                let why = format!("it was not over within {:.1} s", patience.as_secs_f64());
                stop(&self.shared.outlet, &mut seen, why.clone());
                return Err(why);
            }
            let waited = self.shared.news.wait_timeout(seen, until - now);
            seen = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Whether the tip has come along the guarded line.
    pub(super) fn has_begun(&self) -> bool {
        let seen = self.shared.lock();
        let line = seen.guard.as_ref().and_then(Guard::on_line);
        line.is_some_and(OnLine::has_begun)
    }

    /// Whether the last report is new and its condition satisfies `is_such`.
    pub(super) fn shows(&self, is_such: impl FnOnce(Condition) -> bool) -> bool {
        let seen = self.shared.lock();
        let last = seen.last.filter(|last| last.at.elapsed() <= SILENCE);
        last.is_some_and(|last| is_such(last.report.condition))
    }

    /// Whether the positions of the last reports show the arm at rest; none where reports have ceased, come too seldom, or repeat one.
    pub(super) fn rests(&self) -> Option<bool> {
        let seen = self.shared.lock();
        let last = seen.last.filter(|last| last.at.elapsed() <= SILENCE)?;
        let first = seen
            .recent
            .first()
            .filter(|_| seen.recent.len() >= FEWEST)?;
        let is_long = last.at.duration_since(first.at) >= RECENT.mul_f64(0.75);
        // The same report again and again says nothing.
        if is_long && last.report.clock <= first.report.clock {
            return None;
        }
        let is_still = seen.recent.iter().all(|sample| {
            let place = sample.report.pose.at;
            distance(place, last.report.pose.at) <= REST
        });
        Some(is_long && is_still)
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

fn stop(outlet: &Outlet, seen: &mut Seen, why: String) {
    let sent = outlet.stop();
    let why = match sent {
        Ok(()) => why,
        Err(error) => format!("{why}; and the stop could not be sent: {error}"),
    };
    seen.fault.get_or_insert(why);
    seen.guard = None;
}

/// Reads reports until the connection ends.
fn read(shared: &Shared, mut reports: Box<dyn Reports>) {
    loop {
        let read = reports.next().and_then(Report::checked);
        if shared.ends.load(Ordering::Relaxed) {
            return;
        }
        let mut seen = shared.lock();
        match read {
            Ok(report) => {
                let at = Instant::now();
                let (made, late) = seen.clocks.made(at, report.clock);
                let sample = Sample { at, made, report };
                let before = seen.last.map(|last| last.report.condition);
                let was_free = before
                    .is_some_and(|before| matches!(before, Condition::Ready | Condition::Moving));
                let most = if seen.may_sag { ASIDE } else { STILL };
                let moved = seen.left.map(|left| distance(left, report.pose.at));
                let moved = moved.filter(|moved| *moved > most);
                let was_held = before.is_none_or(|before| matches!(before, Condition::Held(_)));
                let taken = match report.condition {
                    Condition::Stopped(said) if was_free => Some(said.to_string()),
                    Condition::Held(said) if !was_held => Some(said.to_string()),
                    _ => moved.map(|moved| format!("it was moved by {:.1} mm", moved * 1e3)),
                };
                if let Some(said) = taken
                    && !shared.outlet.is_stopped()
                {
                    seen.taken.get_or_insert(said);
                }
                let verdict = match &mut seen.guard {
                    Some(guard) => Clocks::judge(late).and_then(|()| guard.judge(&sample)),
                    None => Ok(()),
                };
                seen.last = Some(sample);
                seen.recent
                    .retain(|old| at.saturating_duration_since(old.at) <= RECENT);
                seen.recent.push(sample);
                if seen.is_recording {
                    seen.record.push(sample);
                }
                if let Err(why) = verdict {
                    stop(&shared.outlet, &mut seen, why);
                }
            }
            Err(error) => {
                let why = if is_nothing_yet(&error) {
                    "its reports ceased".to_owned()
                } else {
                    format!("its reports broke off: {}", what_happened(&error))
                };
                if seen.guard.is_some() {
                    stop(&shared.outlet, &mut seen, why.clone());
                }
                // What broke off is not taken up again: a stop that came meanwhile would be passed over.
                seen.broken = Some(why);
                shared.news.notify_all();
                return;
            }
        }
        drop(seen);
        shared.news.notify_all();
    }
}

/// Watches the time: stops the arm where no report comes on a line, a signal did, or it could be stopped no more.
fn watch_time(shared: &Shared, interrupted: &AtomicBool) {
    while !shared.ends.load(Ordering::Relaxed) {
        thread::sleep(TICK);
        let mut seen = shared.lock();
        let Some(guard) = &seen.guard else {
            continue;
        };
        let ends = if interrupted.load(Ordering::Relaxed) {
            Some("it was interrupted by a signal")
        } else if shared.outlet.is_closed() {
            Some("a connection that it would be stopped over was closed from there")
        } else {
            None
        };
        if let Some(why) = ends {
            stop(&shared.outlet, &mut seen, why.into());
            shared.news.notify_all();
            continue;
        }
        let Some(since) = guard.on_line().map(OnLine::sent) else {
            continue;
        };
        let last = seen.last.map_or(since, |last| last.at.max(since));
        let silent = last.elapsed();
        if silent > SILENCE {
            let why = format!("no report came for {} ms", silent.as_millis());
            stop(&shared.outlet, &mut seen, why);
            shared.news.notify_all();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{self, Receiver};

    use super::*;
    use crate::robot::arm::{Pose, Turn};

    /// Reports that come when the test sends their clocks, and where (m) the tip is.
    struct Sent(Receiver<(f64, f64)>);

    impl Reports for Sent {
        fn next(&mut self) -> io::Result<Report> {
            let (clock, x) = self.0.recv().map_err(io::Error::other)?;
            Ok(Report {
                clock,
                pose: Pose {
                    at: [x, 0.0, 0.0],
                    turn: Turn::vector([0.0; 3]),
                },
                velocity: [0.0; 3],
                condition: Condition::Ready,
                wanted: None,
            })
        }
    }

    #[test]
    fn a_report_that_was_held_on_its_way_is_no_news() {
        let (send, sent) = mpsc::channel();
        let begun = Instant::now();
        let clock = || begun.elapsed().as_secs_f64();
        let outlet = Outlet::new(Vec::new());
        let watch = Watch::start(Box::new(Sent(sent)), outlet, Arc::default()).expect("starts");
        let news = |at: &dyn Fn() -> f64| {
            thread::scope(|scope| {
                let asked = scope.spawn(|| watch.next(Duration::from_millis(200)));
                while !asked.is_finished() {
                    send.send((at(), 0.0)).expect("is read");
                    thread::sleep(Duration::from_millis(4));
                }
                asked.join().expect("ends")
            })
        };
        // A machine that stalls makes reports late by itself.
        assert!((0..100).any(|_| news(&clock).is_ok()));
        // Ten seconds old: what was before it is not taken for what is.
        assert!(news(&|| clock() - 10.0).is_err());
        assert!((0..100).any(|_| news(&clock).is_ok()));
        drop(send);
    }

    #[test]
    fn reports_that_come_seldom_show_no_rest() {
        let (send, sent) = mpsc::channel();
        let outlet = Outlet::new(Vec::new());
        let watch = Watch::start(Box::new(Sent(sent)), outlet, Arc::default()).expect("starts");
        // As of 25 Hz: never more than four in the time that is looked at, however slow this machine is.
        let begun = Instant::now();
        for _ in 0..12 {
            send.send((begun.elapsed().as_secs_f64(), 0.3))
                .expect("is read");
            thread::sleep(Duration::from_millis(40));
            assert_eq!(watch.rests(), None);
        }
        drop(send);
    }

    #[test]
    fn an_arm_that_is_moved_a_little_after_a_strike_is_somebody_elses() {
        for (moved, is_taken) in [(0.0005, false), (0.002, true)] {
            let (send, sent) = mpsc::channel();
            let outlet = Outlet::new(Vec::new());
            let watch = Watch::start(Box::new(Sent(sent)), outlet, Arc::default()).expect("starts");
            let seen = |count: usize| {
                while watch.shared.lock().record.len() < count {
                    thread::sleep(Duration::from_millis(1));
                }
            };
            watch.record();
            send.send((0.0, 0.3)).expect("is read");
            seen(1);
            watch.release();
            send.send((0.001, 0.3 + moved)).expect("is read");
            seen(2);
            assert_eq!(watch.taken().is_some(), is_taken, "{moved}");
            drop(send);
        }
    }
}
