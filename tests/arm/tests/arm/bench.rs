//! A plan, a rig with an arm, and one strike against the emulator.

use std::fs;
use std::io::Write;
use std::panic::{self, AssertUnwindSafe};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use arm::{Emulator, Maker, Model, connect_to};
use strike::xarm::XArm;
use strike::{Guarded, Plan, Planner, RobotError, StrikeRecord};
use values::{Point, Rig};

use crate::fixture;

pub fn plan(rig: &Rig, to: Point) -> Plan {
    let planner = Planner::within(&fixture::artifact(), store::Model::Sysid, rig).unwrap();
    planner
        .good_for(Duration::from_secs(60))
        .plan(Point::new(0.36, 0.0), to)
        .unwrap()
}

pub fn rig() -> Rig {
    Maker::XArm.rig()
}

pub fn model() -> Model {
    Maker::XArm.near()
}

pub fn connect(emulator: &Emulator, rig: &Rig) -> Result<Guarded<XArm>, RobotError> {
    connect_to(emulator, rig, Arc::default())
}

/// A strike that nothing disturbs. This process shares its processors: where they are taken from it for longer than reports may fail
/// to come, the strike stops, as it should, and is made again, twice at the most.
pub fn undisturbed(
    maker: Maker,
    plan: &Plan,
) -> (Emulator, Result<Option<StrikeRecord>, RobotError>) {
    before_others();
    for _ in 0..2 {
        let (emulator, outcome) = maker.run(None, plan);
        match &outcome {
            Err(RobotError::Interrupted { why, .. })
                if why.starts_with("no report came") || why.starts_with("its reports lag") =>
            {
                println!("made again: {why}");
            }
            _ => return (emulator, outcome),
        }
    }
    maker.run(None, plan)
}

/// How long this process may be without a processor for a strike to be judged: the arm reports every 4 ms, and is stopped where none comes.
const STANDSTILL: Duration = Duration::from_millis(20);
/// How often a test is made at the most; the last time decides.
const ATTEMPTS: usize = 12;

/// Takes this thread, and those that it starts, before others that want the processors, as an arm's computer would; where that is not
/// permitted, nothing is changed.
pub fn before_others() {
    let itself = fs::read_link("/proc/thread-self").unwrap_or_default();
    if let Some(thread) = itself.file_name() {
        let mut renice = Command::new("renice");
        // What it says where it may not is of no use.
        let _ = renice.args(["-n", "-20", "-p"]).arg(thread).output();
    }
}

/// A test of what is sent in time. Where it fails, and the machine stood still meanwhile, as a shared one may, it is made again, which is
/// said on standard error, past what the harness holds back.
pub fn in_time(test: impl Fn()) {
    before_others();
    for attempt in 1..=ATTEMPTS {
        let over = AtomicBool::new(false);
        let (outcome, longest) = thread::scope(|scope| {
            let longest = scope.spawn(|| longest_standstill(&over));
            let outcome = panic::catch_unwind(AssertUnwindSafe(&test));
            over.store(true, Ordering::Relaxed);
            (outcome, longest.join().unwrap())
        });
        let Err(failure) = outcome else {
            return;
        };
        if longest < STANDSTILL || attempt == ATTEMPTS {
            panic::resume_unwind(failure);
        }
        let name = thread::current().name().unwrap_or_default().to_owned();
        let text = format!("made again: {name}: this machine stood still for {longest:?}\n");
        std::io::stderr().write_all(text.as_bytes()).unwrap();
    }
}

/// The longest time by which a sleep was late until it is over.
fn longest_standstill(over: &AtomicBool) -> Duration {
    let nap = Duration::from_millis(1);
    let mut longest = Duration::ZERO;
    while !over.load(Ordering::Relaxed) {
        let start = Instant::now();
        thread::sleep(nap);
        longest = longest.max(start.elapsed() - nap);
    }
    longest
}

/// Waits until something holds, or until it is too late for it.
pub fn wait_for(holds: impl Fn() -> bool) {
    let start = Instant::now();
    while !holds() && start.elapsed() < Duration::from_secs(20) {
        thread::sleep(Duration::from_millis(1));
    }
}
