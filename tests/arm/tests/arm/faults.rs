//! Every fault at every step: what is sent after it, whether the arm moves on, and what is kept. `tests/ARM.md` is the table.

use std::fmt::Write;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use arm::{Event, Fault, Step};
use strike::RobotError;
use values::Point;

use crate::bench::{model, plan, rig, run};
use crate::strikes::{SPEEDS, delivered};

/// Steps of a strike: from the connection on, and in the middle of each of its lines.
const STEPS: [(&str, Step); 8] = [
    ("connect", Step::Connect),
    ("check", Step::Check),
    ("enable", Step::Enable),
    ("lift", Step::Line(1)),
    ("travel", Step::Line(2)),
    ("lower", Step::Line(3)),
    ("strike", Step::Line(4)),
    ("raise", Step::Line(5)),
];
/// Emulators side by side: more would be late by themselves on a small machine.
const SIDE_BY_SIDE: usize = 3;
/// The arm brakes from 1 m/s within so many mm.
const BRAKING: f64 = 75.0;
/// From a fault that a report shows to the stop on the wire.
const LATENCY: Duration = Duration::from_millis(20);

struct Row {
    text: String,
    /// From fault to stop, where a report or a broken connection shows the fault at once.
    latency: Option<Duration>,
    wrong: Vec<String>,
}

fn one(name: &str, step: Step, fault: Fault) -> Row {
    let rig = rig();
    let plan = plan(&rig, Point::new(0.62, 0.0));
    let (emulator, outcome) = run(model(), Some((step, fault)), &plan);
    let events = emulator.events();
    let made = events
        .iter()
        .position(|(_, event)| matches!(event, Event::Fault));
    let after = made.map_or(&[][..], |made| &events[made + 1..]);
    let is = |event: &Event, register: u8, first: Option<u8>| match event {
        Event::Request(request) => {
            request.register() == register
                && first.is_none_or(|first| request.payload().first() == Some(&first))
        }
        Event::Fault => false,
    };
    let lines = after
        .iter()
        .filter(|(_, event)| is(event, 21, None))
        .count();
    let cleared = events
        .iter()
        .filter(|(_, event)| is(event, 16, None) || is(event, 17, None))
        .count();
    let stop: Option<Instant> = after
        .iter()
        .find(|(_, event)| is(event, 12, Some(4)))
        .map(|(at, _)| *at);
    let is_moving = matches!(step, Step::Line(_));
    let shown = matches!(
        fault,
        Fault::Garbage
            | Fault::Error(_)
            | Fault::EmergencyStop
            | Fault::OtherController
            | Fault::Paused
            | Fault::Jump
            | Fault::NotANumber
            | Fault::ShortFrame
    );
    let latency = (is_moving && shown)
        .then(|| stop.zip(made))
        .flatten()
        .map(|(stop, made)| stop.duration_since(events[made].0));
    thread::sleep(Duration::from_millis(150));
    let pose = emulator.pose();
    thread::sleep(Duration::from_millis(30));
    let comes_to_rest = pose
        .iter()
        .zip(emulator.pose())
        .take(3)
        .all(|(a, b)| (a - b).abs() < 0.01 || fault == Fault::OffLine);

    let mut wrong = Vec::new();
    let mut check = |holds: bool, what: &str| {
        if !holds {
            wrong.push(format!("{fault:?} at {name}: {what}"));
        }
    };
    let came = made.is_some();
    check(cleared == 0, "an error was cleared");
    // What the arm takes back, or what does not concern the step, may end the strike or not; what counts is that nothing moves on
    // after the end.
    let harmless = !came
        || (!is_moving
            && matches!(
                fault,
                Fault::Paused
                    | Fault::TooSlow
                    | Fault::Stuck
                    | Fault::OtherController
                    | Fault::OffLine
                    | Fault::Lag
                    | Fault::Jump
            ))
        // What was broken before the connection, and is not any more.
        || (step == Step::Connect && matches!(fault, Fault::Reset | Fault::HalfOpen))
        || (is_moving
            && matches!(
                fault,
                Fault::NeverReady | Fault::SlowReplies | Fault::GarbageReply
            ))
        // A line of travel that is slow is still on its way.
        || (fault == Fault::TooSlow && step != Step::Line(4));
    if harmless {
        check(
            outcome.is_ok() || comes_to_rest,
            "it failed, and the arm moves on",
        );
    } else {
        check(outcome.is_err(), "the strike was called made");
        check(lines == 0, "a line was sent after the fault");
        if is_moving && fault != Fault::Gone {
            check(stop.is_some(), "no stop was sent");
            check(comes_to_rest, "the arm moves on");
            check(
                emulator.moved_after_stop() <= BRAKING,
                "it moved too far after the stop",
            );
        }
        if matches!(step, Step::Line(4 | 5)) {
            let kept = outcome.as_ref().err().and_then(RobotError::samples);
            check(
                kept.is_some_and(|kept| !kept.states.is_empty()),
                "the record is lost",
            );
        }
        if fault == Fault::Gone && is_moving {
            let error_text = outcome
                .as_ref()
                .err()
                .map(ToString::to_string)
                .unwrap_or_default();
            check(
                error_text.contains("emergency stop"),
                "nobody is asked to press the emergency stop",
            );
        }
    }
    let (end, kept) = match &outcome {
        Ok(_) => ("struck (0)".to_owned(), "whole"),
        Err(error) => {
            let end = match error {
                RobotError::NotReady { .. } => "refused (4)",
                RobotError::Refused(_) => "refused (4)",
                RobotError::Connection { .. } => "failed (1)",
                RobotError::Interrupted { .. } => "stopped (1)",
                RobotError::Runaway { .. } => "stopped, not confirmed (1)",
            };
            let kept = error.samples().map_or("–", |_| "kept");
            (end.to_owned(), kept)
        }
    };
    let sent = match (came, stop) {
        (false, _) => "the fault did not come",
        (true, Some(_)) => "stop",
        (true, None) => "no stop",
    };
    let time = stop.zip(made).map_or("–".into(), |(stop, made)| {
        format!(
            "{:.0}",
            stop.duration_since(events[made].0).as_secs_f64() * 1e3
        )
    });
    Row {
        text: format!(
            "| {fault:?} | {name} | {sent} | {time} | {lines} | {:.0} | {end} | {kept} |",
            emulator.moved_after_stop()
        ),
        latency,
        wrong,
    }
}

#[test]
fn whatever_fails_at_whatever_step_the_arm_rests_and_the_record_is_kept() {
    let cases: Vec<_> = Fault::ALL
        .iter()
        .flat_map(|fault| STEPS.iter().map(move |(name, step)| (*name, *step, *fault)))
        .collect();
    let next = AtomicUsize::new(0);
    let rows = Mutex::new(Vec::new());
    thread::scope(|scope| {
        for _ in 0..SIDE_BY_SIDE {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some((name, step, fault)) = cases.get(index) else {
                        return;
                    };
                    let row = one(name, *step, *fault);
                    rows.lock().unwrap().push((index, row));
                }
            });
        }
    });
    let mut rows = rows.into_inner().unwrap();
    rows.sort_by_key(|(index, _)| *index);
    let mut latencies: Vec<Duration> = rows.iter().filter_map(|(_, row)| row.latency).collect();
    latencies.sort();
    let wrong: Vec<&String> = rows.iter().flat_map(|(_, row)| &row.wrong).collect();
    let worst = latencies.last().copied().unwrap_or_default();
    let mut table = String::new();
    for (_, row) in &rows {
        writeln!(table, "{}", row.text).unwrap();
    }
    if let Ok(path) = std::env::var("ARM_PAGE") {
        std::fs::write(path, page(&table, rows.len(), &wrong, &latencies)).unwrap();
    }
    println!(
        "{table}\n{} faults × {} steps = {} strikes",
        Fault::ALL.len(),
        STEPS.len(),
        rows.len()
    );
    println!(
        "from fault to stop: {} measured, median {:?}, worst {worst:?}",
        latencies.len(),
        latencies[latencies.len() / 2]
    );
    assert!(wrong.is_empty(), "{wrong:#?}");
    // What a busy machine adds is no fault of the driver: the median must hold the limit here, the page gives the 99th percentile.
    assert!(latencies[latencies.len() / 2] <= LATENCY, "{latencies:?}");
}

/// `tests/ARM.md`.
fn page(table: &str, strikes: usize, wrong: &[&String], latencies: &[Duration]) -> String {
    let share = |share: f64| {
        let index = (share * latencies.len() as f64).ceil() as usize;
        latencies[index.clamp(1, latencies.len()) - 1].as_secs_f64() * 1e3
    };
    let frames = include_str!("../sdk_frames.txt").lines().count();
    let mut page = String::from(
        "# A strike of the emulated xArm7 under every fault\n\n\
         `make arm` drives the emulator with the maker's SDK (xarm-python-sdk 1.18.4, unchanged), compares the bytes that it sends with \
         those that the driver's tests hold, and makes every fault at every step of a strike; then it writes this page. No arm was at \
         hand: the emulator is what was measured.\n\n",
    );
    writeln!(page, "| | measured |\n|---|---|").unwrap();
    writeln!(
        page,
        "| frames of the SDK that the driver's are compared with | {frames} |"
    )
    .unwrap();
    writeln!(
        page,
        "| faults × steps | {} × {} = {strikes} |",
        Fault::ALL.len(),
        STEPS.len()
    )
    .unwrap();
    writeln!(
        page,
        "| of these: moved on, a line after the fault, an error cleared, or a record lost | {} |",
        wrong.len()
    )
    .unwrap();
    writeln!(
        page,
        "| from a fault that a report shows to the stop on the wire | {} measured: median {:.1} ms, 99th percentile {:.1} ms, worst {:.1} ms |",
        latencies.len(),
        share(0.5),
        share(0.99),
        share(1.0)
    )
    .unwrap();
    page.push_str(
        "\nDelivered speed at contact, with the xArm7's jerk limit of 100 m/s³; the emulator's motion is two moving averages of a \
         rectangle, no code of the planner's:\n\n| commanded, m/s | delivered, m/s | off |\n|---|---|---|\n",
    );
    for speed in SPEEDS {
        match delivered(speed) {
            Some(delivered) => writeln!(
                page,
                "| {speed:.2} | {delivered:.4} | {:+.2} % |",
                100.0 * (delivered / speed - 1.0)
            ),
            None => writeln!(page, "| {speed:.2} | refused | |"),
        }
        .unwrap();
    }
    page.push_str(
        "\nA fault of a line is made in the middle of that line. Silence is a fault once it lasts 50 ms; reports that lag, once they \
         lag by 50 ms; a speed that is not reached, 10 mm before the object. `Gone` takes no connection any more: the program says to \
         press the emergency stop. What is broken before the connection, what the arm takes back, and a line of travel that is slow do \
         not end a strike. The emulator brakes at 8 m/s².\n\n\
         | fault | at | sent after it | after, ms | lines after it | moved after the stop, mm | end (exit code) | record |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    page + table
}
