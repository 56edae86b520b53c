//! Strikes that nothing disturbs, and those that are refused before anything moves.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use arm::{Emulator, Event, Listening, Model};
use strike::xarm::XArm;
use strike::{CommandPlanner, Guarded, Look, RobotError, execute};
use values::{Command, Point};

use crate::bench::{
    Maker, connect, in_time, model, plan, ports, rig, run, strike, undisturbed, wait_for,
};

const TO: Point = Point::new(0.62, 0.0);

/// Registers of the requests that came, in order.
fn registers(emulator: &Emulator) -> Vec<u8> {
    let events = emulator.events().into_iter();
    let register = |(_, event)| match event {
        Event::Request(request) => Some(request.register()),
        _ => None,
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
        let mut arm = connect(&emulator, plan.rig()).unwrap();
        arm.look_first(|when| match when {
            Look::BeforeDescent => Ok(()),
            Look::BeforeStrike => panic!("as a bug would"),
        });
        let error = execute(&mut arm, &plan).unwrap_err().to_string();
        assert!(error.contains("panicked"), "{error}");
        assert_eq!(emulator.state(), 4);
        let written = registers(&emulator);
        let lines = written.iter().filter(|register| **register == 21).count();
        // Five that are only checked; then lift, travel and lower, and not the strike.
        assert_eq!(lines, 5 + 3);
    });
}

#[test]
fn an_object_that_is_not_where_it_was_is_neither_come_down_on_nor_struck_at() {
    in_time(|| {
        for (seen_at, height) in [(Look::BeforeDescent, 70.0), (Look::BeforeStrike, 20.0)] {
            let rig = rig();
            let plan = plan(&rig, TO);
            let emulator = Emulator::start(Listening::Free, model(), None).unwrap();
            let mut arm = connect(&emulator, plan.rig()).unwrap();
            arm.look_first(move |when| {
                if when == seen_at {
                    return Err("it has moved by 30 mm".into());
                }
                Ok(())
            });
            let error = execute(&mut arm, &plan).unwrap_err();
            assert!(error.to_string().contains("moved by 30 mm"), "{error}");
            assert_eq!(emulator.state(), 4);
            let [x, _, z, ..] = emulator.pose();
            assert!((x * 1e-3 - plan.start.x).abs() < 1e-3 && (z - height).abs() < 1.0);
            // What a strike changes is as it was.
            assert_eq!(emulator.ramp(), [1_000.0, 50_000.0]);
        }
    });
}

#[test]
fn whoever_stopped_the_arm_is_in_charge_until_the_program_is_started_again() {
    in_time(|| {
        let rig = rig();
        let plan = plan(&rig, TO);
        let switched_on = Model {
            is_stopped: true,
            ..model()
        };
        // An arm that was just switched on is made ready by a call, once.
        let emulator = Emulator::start(Listening::Free, switched_on, None).unwrap();
        let mut arm = connect(&emulator, plan.rig()).unwrap();
        execute(&mut arm, &plan).unwrap();
        assert_eq!(emulator.ramp(), [1_000.0, 50_000.0], "put back");
        emulator.operator_stops();
        thread::sleep(Duration::from_millis(50));
        let before = registers(&emulator).len();
        let error = execute(&mut arm, &plan).unwrap_err();
        assert!(matches!(error, RobotError::NotReady { .. }), "{error}");
        assert!(error.to_string().contains("is in charge"), "{error}");
        let after = registers(&emulator)[before..].to_vec();
        let changing = [11, 12, 19, 21, 31, 32];
        assert!(
            !after.iter().any(|register| changing.contains(register)),
            "{after:?}"
        );
        // A new call is a person's word.
        drop(arm);
        strike(&emulator, &plan).unwrap();
    });
}

#[test]
fn an_arm_of_another_maker_strikes_by_the_same_guard() {
    in_time(|| {
        let plan = plan(&Maker::Ur.rig(), TO);
        let (emulator, outcome) = Maker::Ur.run(None, &plan);
        let struck = outcome.unwrap().unwrap();
        let delivered = struck.delivered_speed.unwrap();
        assert!((delivered / plan.speed - 1.0).abs() < 0.01, "{delivered}");
        assert_eq!(struck.warning, None);
        let is_line = |(_, event): &(_, Event)| matches!(event, Event::Line);
        assert_eq!(
            emulator
                .events()
                .iter()
                .filter(|event| is_line(event))
                .count(),
            5
        );
        let [x, _, z, ..] = emulator.pose();
        assert!((x * 1e-3 - plan.stop.x).abs() < 1e-3 && (z - 70.0).abs() < 1.0);
    });
}

#[test]
fn one_program_drives_an_arm_at_a_time() {
    let rig = rig();
    let emulator = Emulator::start(Listening::Free, model(), None).unwrap();
    let first = connect(&emulator, &rig).unwrap();
    assert!(matches!(
        connect(&emulator, &rig),
        Err(RobotError::Busy { .. })
    ));
    drop(first);
    connect(&emulator, &rig).unwrap();
    // The same arm at another address.
    let same = Model {
        version: "7,7,XI77,AC1305,v2.4.0".into(),
        ..model()
    };
    let [one, other] =
        [same.clone(), same].map(|model| Emulator::start(Listening::Free, model, None).unwrap());
    let _first = connect(&one, &rig).unwrap();
    assert!(matches!(
        connect(&other, &rig),
        Err(RobotError::Busy { .. })
    ));
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
    let cases: [(Change, &str); 15] = [
        (|m| m.version = "8,8,SN,BOX,v2.4.0".into(), "xArm5"),
        (|m| m.version = "7,7,SN,BOX,v1.12.10".into(), "firmware"),
        (|m| m.codes = [1, 0], "error 1"),
        (|m| m.codes = [0, 11], "warning 11"),
        (|m| m.tool_offset[2] = 150.0, "tool offset"),
        (|m| m.payload = 1.0, "kg"),
        (|m| m.world_offset[2] = 10.0, "world offset"),
        (|m| m.world_offset[5] = 0.1, "world offset"),
        (|m| m.sensitivity = 0, "collisions"),
        (|m| m.modes[0] = true, "reduced mode"),
        (|m| m.modes[2] = true, "simulates"),
        (|m| m.gravity = [1.0, 0.0, 0.0], "upright"),
        (
            |m| {
                m.modes[1] = true;
                m.fence = [300, -300, 300, -300, 400, 0];
            },
            "fence",
        ),
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
        let changing = [11, 12, 16, 17, 19, 21, 31, 32];
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
    let error = connect(&emulator, &rig).unwrap_err();
    assert!(
        error.to_string().contains("lacks travel_height, payload"),
        "{error}"
    );
    assert!(registers(&emulator).is_empty());
}

/// Strikes, and stops in the middle of the strike's line by what is done from another thread.
fn stopped_by(
    stop: impl FnOnce(&Guarded<XArm>, &AtomicBool) -> Box<dyn FnOnce() + Send>,
    said: &str,
) {
    let rig = rig();
    let plan = plan(&rig, TO);
    let emulator = Emulator::start(Listening::Free, model(), None).unwrap();
    let interrupted = Arc::new(AtomicBool::new(false));
    let mut arm =
        Guarded::<XArm>::connect("xarm", &ports(&emulator), plan.rig(), interrupted.clone())
            .unwrap();
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
        let mut arm =
            Guarded::<XArm>::connect("xarm", &ports(&emulator), plan.rig(), flag.clone()).unwrap();
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
