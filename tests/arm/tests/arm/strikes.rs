//! Strikes that nothing disturbs, and those that are refused before anything moves.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use arm::{Emulator, Event, Listening, Model};
use strike::xarm::XArm;
use strike::{CommandPlanner, RobotError, execute};
use values::{Command, Point};

use crate::bench::{in_time, model, plan, ports, rig, run, undisturbed, wait_for};

const TO: Point = Point::new(0.62, 0.0);

/// Registers of the requests that came, in order.
fn registers(emulator: &Emulator) -> Vec<u8> {
    let events = emulator.events().into_iter();
    let register = |(_, event)| match event {
        Event::Request(request) => Some(request.register()),
        Event::Fault => None,
    };
    events.filter_map(register).collect()
}

/// The speed (m/s) that the arm delivers at the impact where it is commanded this one; none where the plan is refused.
pub fn delivered(speed: f64) -> Option<f64> {
    // A table on which the object may slide far: it is the arm that is looked at.
    let mut rig = rig();
    rig.table.x.high = 3.0;
    rig.robot.speed.low = 0.3;
    let planner = CommandPlanner::nominal(&rig)
        .unwrap()
        .good_for(Duration::from_secs(60));
    let command = Command { speed, angle: 0.0 };
    let plan = planner.plan(Point::new(0.36, 0.0), command, 1.0).ok()?;
    let (_, outcome) = undisturbed(&plan);
    outcome.unwrap().unwrap().delivered_speed
}

/// From the least to the greatest speed of the arm, in m/s.
pub const SPEEDS: [f64; 7] = [0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];

#[test]
fn from_the_least_to_the_greatest_speed_it_is_delivered_within_a_percent() {
    in_time(|| {
        for speed in SPEEDS {
            let delivered = delivered(speed).unwrap();
            println!("commanded {speed:.2} m/s, delivered {delivered:.4} m/s");
            assert!(
                (delivered / speed - 1.0).abs() < 0.01,
                "{delivered} of {speed}"
            );
        }
    });
}

#[test]
fn a_panic_stops_it_with_state_4_and_is_reported() {
    in_time(|| {
        let rig = rig();
        let plan = plan(&rig, TO);
        let emulator = Emulator::start(Listening::Free, model(), None).unwrap();
        let arm = XArm::connect("xarm", ports(&emulator), plan.rig(), Arc::default()).unwrap();
        let mut arm = arm.with_last_check(|| panic!("as a bug would"));
        let error = execute(&mut arm, &plan).unwrap_err().to_string();
        assert!(error.contains("panicked"), "{error}");
        assert_eq!(emulator.state(), 4);
        let written = registers(&emulator);
        let lines = written.iter().filter(|register| **register == 21).count();
        // Lift, travel and lower; not the strike.
        assert_eq!(lines, 3);
    });
}

#[test]
fn an_object_that_is_taken_away_before_the_strike_is_not_struck_at() {
    in_time(|| {
        let rig = rig();
        let plan = plan(&rig, TO);
        let emulator = Emulator::start(Listening::Free, model(), None).unwrap();
        let arm = XArm::connect("xarm", ports(&emulator), plan.rig(), Arc::default()).unwrap();
        let mut arm = arm.with_last_check(|| Err("it has moved by 30 mm".into()));
        let error = execute(&mut arm, &plan).unwrap_err();
        assert!(error.to_string().contains("moved by 30 mm"), "{error}");
        assert_eq!(emulator.state(), 4);
        assert!((emulator.pose()[0] * 1e-3 - plan.start.x).abs() < 1e-3);
    });
}

#[test]
fn the_arm_delivers_the_speed_at_the_impact_within_a_percent() {
    in_time(|| {
        let rig = rig();
        for to in [0.45, 0.55, 0.62, 0.70] {
            let plan = plan(&rig, Point::new(to, 0.0));
            let (emulator, outcome) = undisturbed(&plan);
            let struck = outcome.unwrap().unwrap();
            let delivered = struck.delivered_speed.unwrap();
            let off = (delivered / plan.speed - 1.0).abs();
            println!(
                "commanded {:.4} m/s, delivered {delivered:.4} m/s",
                plan.speed
            );
            assert!(off < 0.01, "{delivered} of {}", plan.speed);
            assert_eq!(struck.warning, None);
            // The strike is in the log: pose and speed from rest to rest.
            let samples = struck.samples;
            assert!(samples.states.len() > 60, "{}", samples.states.len());
            assert!(samples.commands.len() > 100);
            let top = samples
                .states
                .iter()
                .map(|state| state.velocity[0])
                .fold(0.0, f64::max);
            assert!((top / plan.speed - 1.0).abs() < 0.01);
            // It ends above the stop, at travel height.
            let [x, y, z, ..] = emulator.pose();
            assert!((x * 1e-3 - plan.stop.x).abs() < 1e-3 && (y * 1e-3 - plan.stop.y).abs() < 1e-3);
            assert!((z - 70.0).abs() < 1.0);
        }
    });
}

#[test]
fn an_arm_that_is_not_the_rigs_moves_nothing() {
    let rig = rig();
    let plan = plan(&rig, TO);
    type Change = fn(&mut Model);
    let cases: [(Change, &str); 8] = [
        (|m| m.version = "6,6,SN,BOX,v1.12.10".into(), "7 axes"),
        (|m| m.version = "7,7,SN,BOX,v1.6.0".into(), "firmware"),
        (|m| m.codes = [1, 0], "error 1"),
        (|m| m.codes = [0, 11], "warning 11"),
        (|m| m.tool_offset[2] = 150.0, "tool offset"),
        (|m| m.payload = 1.0, "kg"),
        (|m| m.pose[4] = 0.3, "tool points"),
        (|m| m.pose[0] = 60.0, "keep_out"),
    ];
    for (change, said) in cases {
        let mut model = model();
        change(&mut model);
        let (emulator, outcome) = run(model, None, &plan);
        let error = outcome.expect_err(said);
        assert!(matches!(error, RobotError::NotReady { .. }), "{error}");
        let text = error.to_string();
        assert!(
            text.contains(said) && text.contains("nothing has moved"),
            "{text}"
        );
        let changing = [11, 12, 16, 17, 19, 21];
        let written = registers(&emulator);
        assert!(
            !written.iter().any(|register| changing.contains(register)),
            "{written:?}"
        );
    }
}

#[test]
fn a_rig_file_that_lacks_what_an_arm_needs_is_reported_before_a_connection() {
    let mut rig = rig();
    rig.robot.payload = None;
    rig.robot.travel_height = None;
    let emulator = Emulator::start(Listening::Free, model(), None).unwrap();
    let interrupted = Arc::new(AtomicBool::new(false));
    let error = XArm::connect("xarm", ports(&emulator), &rig, interrupted).unwrap_err();
    assert!(
        error.to_string().contains("lacks travel_height, payload"),
        "{error}"
    );
    assert!(registers(&emulator).is_empty());
}

/// Strikes, and stops in the middle of the strike's line by what is done from another thread.
fn stopped_by(stop: impl FnOnce(&XArm, &AtomicBool) -> Box<dyn FnOnce() + Send>, said: &str) {
    let rig = rig();
    let plan = plan(&rig, TO);
    let emulator = Emulator::start(Listening::Free, model(), None).unwrap();
    let interrupted = Arc::new(AtomicBool::new(false));
    let mut arm = XArm::connect("xarm", ports(&emulator), plan.rig(), interrupted.clone()).unwrap();
    let stop = stop(&arm, &interrupted);
    let outcome = thread::scope(|scope| {
        scope.spawn(|| {
            // Low and on its way: the strike's line.
            wait_for(|| {
                let [x, _, z, ..] = emulator.pose();
                z < 21.0 && x > plan.start.x * 1e3 + 10.0
            });
            stop();
        });
        execute(&mut arm, &plan)
    });
    let error = outcome.unwrap_err();
    assert!(matches!(error, RobotError::Interrupted { .. }), "{error}");
    let text = error.to_string();
    assert!(
        text.contains(said) && text.contains("to `strike`"),
        "{text}"
    );
    assert!(
        !error.samples().unwrap().states.is_empty(),
        "what was recorded is kept"
    );
    assert_eq!(emulator.state(), 4);
    let written = registers(&emulator);
    let stop_at = written.iter().position(|register| *register == 12).unwrap();
    assert!(written[stop_at..].contains(&12));
    // It braked, and moved no farther.
    thread::sleep(Duration::from_millis(300));
    let rest = emulator.pose();
    thread::sleep(Duration::from_millis(100));
    assert_eq!(rest, emulator.pose());
    assert!(rest[0] < plan.stop.x * 1e3 - 5.0);
}

#[test]
fn a_stop_handle_stops_it_while_it_strikes() {
    in_time(|| {
        stopped_by(
            |arm, _| {
                let handle = arm.stop_handle();
                Box::new(move || handle.stop().unwrap())
            },
            "state 4",
        );
    });
}

#[test]
fn a_signal_stops_it_while_it_strikes() {
    in_time(|| {
        let flag: Arc<AtomicBool> = Arc::default();
        let rig = rig();
        let plan = plan(&rig, TO);
        let emulator = Emulator::start(Listening::Free, model(), None).unwrap();
        let mut arm = XArm::connect("xarm", ports(&emulator), plan.rig(), flag.clone()).unwrap();
        let outcome = thread::scope(|scope| {
            scope.spawn(|| {
                wait_for(|| emulator.pose()[2] <= 30.0);
                flag.store(true, Ordering::Relaxed);
            });
            execute(&mut arm, &plan)
        });
        let error = outcome.unwrap_err().to_string();
        assert!(error.contains("signal"), "{error}");
        assert_eq!(emulator.state(), 4);
    });
}
