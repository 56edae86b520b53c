//! Strikes that nothing disturbs, and those that are refused before anything moves.

use std::io::{self, BufRead, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::process::{Command as Program, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, mpsc};
use std::thread;
use std::time::{Duration, Instant};

use arm::{Emulator, Event, Fault, Maker, Model, Step, connect_to};
use strike::arm::{Arm, LineRequest};
use strike::ur::Ur;
use strike::xarm::{Register, XArm, request};
use strike::{CommandPlanner, Guarded, Look, Memory, Plan, RobotError, execute, strike_and_keep};
use values::{Command, Point, Rig};

use crate::bench::{connect, in_time, model, plan, rig, undisturbed, wait_for};

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

/// A test of this file as a program of its own, which the variable tells that it is one.
fn itself(test: &str, variable: &str) -> Program {
    let mut program = Program::new(std::env::current_exe().unwrap());
    program
        .arg(format!("strikes::{test}"))
        .args(["--exact", "--nocapture", "--test-threads", "1"])
        .env(variable, "1");
    program
}

/// A plan, a maker's arm, and what is connected to it.
fn ready<D: Arm>(maker: Maker) -> (Plan, Arc<Emulator>, Guarded<D>) {
    let plan = plan(&maker.rig(), TO);
    let emulator = Arc::new(maker.emulator(None));
    let arm = connect_to::<D>(&emulator, plan.rig(), Arc::default()).unwrap();
    (plan, emulator, arm)
}

/// What is done as the object is looked at then.
fn as_it_looks<D: Arm>(arm: &mut Guarded<D>, at: Look, mut done: impl FnMut() + Send + 'static) {
    arm.look_first(move |when| {
        if when == at {
            done();
        }
        Ok(())
    });
}

/// Asserts that an arm is not struck with, for a reason that has these words.
fn assert_not_ready(error: &RobotError, words: &[&str]) {
    assert!(matches!(error, RobotError::NotReady { .. }), "{error}");
    let text = error.to_string();
    assert!(words.iter().all(|words| text.contains(words)), "{text}");
}

/// The speed (m/s) that a maker's arm delivers at the impact where it is commanded this one; none where the plan is refused.
pub fn delivered(maker: Maker, speed: f64) -> Option<f64> {
    // A table on which the object may slide far: it is the arm that is looked at.
    let mut rig = maker.rig();
    rig.table.x.high = 3.0;
    rig.robot.speed.low = 0.3;
    let planner = CommandPlanner::nominal(&rig)
        .unwrap()
        .good_for(Duration::from_secs(60));
    let command = Command { speed, angle: 0.0 };
    let plan = planner.plan(Point::new(0.36, 0.0), command, 1.0).ok()?;
    let (_, outcome) = undisturbed(maker, &plan);
    outcome.unwrap().unwrap().delivered_speed
}

/// From the least to the greatest speed of the arm, in m/s.
pub const SPEEDS: [f64; 7] = [0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];

#[test]
fn from_the_least_to_the_greatest_speed_it_is_delivered_and_told_within_a_thousandth() {
    in_time(|| {
        for (maker, speed) in [Maker::XArm, Maker::Ur]
            .into_iter()
            .flat_map(|maker| SPEEDS.map(|speed| (maker, speed)))
        {
            let delivered = delivered(maker, speed).unwrap();
            println!("{maker:?}: commanded {speed:.2} m/s, delivered {delivered:.4} m/s");
            assert!(
                (delivered / speed - 1.0).abs() < 1e-3,
                "{maker:?}: {delivered} of {speed}"
            );
        }
    });
}

#[test]
fn half_a_turn_to_the_left_is_half_a_turn_to_the_right() {
    in_time(|| {
        for maker in [Maker::XArm, Maker::Ur] {
            let mut turned = maker.near();
            turned.pose[3] *= -1.0;
            let emulator = maker.listening(turned, None);
            let outcome = maker.strike(&emulator, &plan(&maker.rig(), TO));
            assert!(matches!(outcome, Ok(Some(_))), "{maker:?}: {outcome:?}");
        }
    });
}

#[test]
fn a_motor_that_stays_off_when_all_are_switched_on_is_seen_before_a_line_is_sent() {
    in_time(|| {
        let plan = plan(&rig(), TO);
        let broken = Model {
            off: 0b100,
            ..model()
        };
        let (emulator, outcome) = Maker::XArm.run_of(broken, None, &plan);
        let error = outcome.unwrap_err().to_string();
        assert!(error.contains("motor is still off"), "{error}");
        assert_eq!(emulator.lines(), 0);
    });
}

#[test]
fn an_arm_that_sags_as_its_brakes_open_is_nobodys_and_one_that_falls_is() {
    in_time(|| {
        let plan = plan(&rig(), TO);
        for (sag, strikes) in [(3.0, true), (6.0, false)] {
            let mut sags = Model { sag, ..model() };
            sags.pose[2] = 71.0;
            let (emulator, outcome) = Maker::XArm.run_of(sags, None, &plan);
            assert_eq!(outcome.is_ok(), strikes, "{sag}: {outcome:?}");
            let told = outcome
                .err()
                .map_or(String::new(), |error| error.to_string());
            assert!(strikes || told.contains("was moved by 6.0 mm"), "{told}");
            assert_eq!(emulator.lines() > 0, strikes);
        }
    });
}

#[test]
fn an_arm_that_was_paused_before_is_told_as_paused_and_not_as_somebodys_since_then() {
    in_time(|| {
        for (maker, fault, said) in [
            (Maker::XArm, Fault::Paused, "held (paused, state 3)"),
            (Maker::Ur, Fault::FreeDrive, "free drive"),
        ] {
            let plan = plan(&maker.rig(), TO);
            let emulator = maker.emulator(Some((Step::Connect, fault)));
            let error = maker.strike(&emulator, &plan).unwrap_err().to_string();
            assert!(error.contains(said), "{maker:?}: {error}");
            assert!(!error.contains("since this program was started"), "{error}");
            assert_eq!(emulator.lines(), 0);
        }
    });
}

#[test]
fn a_panic_stops_it_with_state_4_and_is_reported() {
    in_time(|| {
        let (plan, emulator, mut arm) = ready::<XArm>(Maker::XArm);
        as_it_looks(&mut arm, Look::BeforeStrike, || panic!("as a bug would"));
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
            let (plan, emulator, mut arm) = ready::<XArm>(Maker::XArm);
            arm.look_first(move |when| match when == seen_at {
                true => Err("it has moved by 30 mm".into()),
                false => Ok(()),
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
        let emulator = Maker::XArm.listening(switched_on, None);
        let mut arm = connect(&emulator, plan.rig()).unwrap();
        execute(&mut arm, &plan).unwrap();
        assert_eq!(emulator.ramp(), [1_000.0, 50_000.0], "put back");
        emulator.make(Fault::OperatorStop);
        thread::sleep(Duration::from_millis(50));
        let before = registers(&emulator).len();
        assert_not_ready(&execute(&mut arm, &plan).unwrap_err(), &["is in charge"]);
        let after = registers(&emulator)[before..].to_vec();
        let changing = [11, 12, 19, 21, 31, 32];
        assert!(
            !after.iter().any(|register| changing.contains(register)),
            "{after:?}"
        );
        // A new call is a person's word.
        drop(arm);
        Maker::XArm.strike(&emulator, &plan).unwrap();
    });
}

#[test]
fn who_stops_an_arm_that_waits_for_the_first_or_next_strike_or_moves_it_is_in_charge() {
    fn before<D: Arm>(maker: Maker, strikes: u32, fault: Fault, said: &str) {
        let (plan, emulator, mut arm) = ready::<D>(maker);
        for _ in 0..strikes {
            execute(&mut arm, &plan).unwrap();
        }
        let (rest, lines) = (emulator.pose(), emulator.lines());
        emulator.make(fault);
        match fault {
            Fault::OtherLine => wait_for(|| (emulator.pose()[1] - rest[1]).abs() > 59.9),
            _ => thread::sleep(Duration::from_millis(300)),
        }
        println!("{maker:?} {fault:?}");
        let error = execute(&mut arm, &plan).unwrap_err();
        assert_not_ready(&error, &["is in charge", said]);
        assert_eq!(emulator.lines(), lines);
    }
    in_time(|| {
        before::<XArm>(Maker::XArm, 1, Fault::OperatorStop, "state 4");
        before::<Ur>(Maker::Ur, 1, Fault::OperatorStop, "no program runs");
        before::<Ur>(Maker::Ur, 1, Fault::FreeDrive, "free drive");
        before::<XArm>(Maker::XArm, 1, Fault::OtherLine, "was moved");
        before::<Ur>(Maker::Ur, 1, Fault::OtherLine, "was moved");
        // By hand: an emulated arm that was not made ready takes no line.
        before::<XArm>(Maker::XArm, 0, Fault::Jogged, "was moved");
        before::<Ur>(Maker::Ur, 0, Fault::Jogged, "was moved");
    });
}

#[test]
fn motors_that_were_off_between_two_strikes_end_it_though_they_are_on_again() {
    let off_for = |off: Duration| {
        let (plan, emulator, mut arm) = ready::<XArm>(Maker::XArm);
        execute(&mut arm, &plan).unwrap();
        let lines = emulator.lines();
        // Another client, which makes it ready again, too.
        let mut other = TcpStream::connect(emulator.ports[0]).unwrap();
        for (register, content) in [
            (Register::MotionEnable, &[8, 0][..]),
            (Register::MotionEnable, &[8, 1]),
            (Register::SetState, &[0]),
        ] {
            other.write_all(&request(1, register, content)).unwrap();
            thread::sleep(off);
        }
        assert_not_ready(&execute(&mut arm, &plan).unwrap_err(), &["is in charge"]);
        assert_eq!(emulator.lines(), lines);
    };
    // The state shows what is over before motors are told of.
    in_time(|| off_for(Duration::from_millis(20)));
    in_time(|| off_for(Duration::from_secs(1)));
}

#[test]
fn whoever_is_told_to_press_the_emergency_stop_is_told_once_the_arm_rests() {
    const CHILD: &str = "CAROM_TEST_LOSES_STOPS";
    if std::env::var_os(CHILD).is_some() {
        // Stops are lost; the line, of a second and more, ends by itself. A machine that stalls may end the strike before that.
        let mut is_made = false;
        while !is_made {
            let mut far = model();
            far.pose[1] += 130.0;
            let (emulator, outcome) =
                Maker::XArm.run_of(far, Some((Step::Line(2), Fault::NoStop)), &plan(&rig(), TO));
            outcome.unwrap_err();
            let events = emulator.events();
            let mut what = events.iter().map(|(_, event)| event);
            // The first of both: a stop that came before was not lost.
            let first = what.find(|event| matches!(event, Event::Fault | Event::Stop));
            is_made = matches!(first, Some(Event::Fault));
        }
        return;
    }
    in_time(|| {
        let name = "whoever_is_told_to_press_the_emergency_stop_is_told_once_the_arm_rests";
        let child = itself(name, CHILD).output().unwrap();
        let told = String::from_utf8_lossy(&child.stderr);
        let prompt = told.find("PRESS THE EMERGENCY STOP");
        let rests = told.find("the arm rests now");
        assert!(prompt.is_some() && rests > prompt, "{told}");
    });
}

#[test]
fn a_stop_right_after_the_arm_was_made_ready_is_not_overridden() {
    in_time(|| {
        let plan = plan(&Maker::Ur.rig(), TO);
        let emulator = Maker::Ur.emulator(None);
        thread::scope(|scope| {
            scope.spawn(|| {
                wait_for(|| emulator.is_running());
                // It takes commands now, and its settings are being read again.
                thread::sleep(Duration::from_millis(15));
                emulator.make(Fault::OperatorStop);
            });
            let error = Maker::Ur.strike(&emulator, &plan).unwrap_err().to_string();
            assert!(error.contains("is in charge"), "{error}");
        });
        assert_eq!(emulator.lines(), 0);
    });
}

#[test]
fn whoever_stops_the_arm_while_it_is_looked_at_the_object_is_not_overridden() {
    fn stopped_in<D: Arm>(maker: Maker, look: Look, time: Duration) {
        let (plan, emulator, mut arm) = ready::<D>(maker);
        let (operator, before) = (emulator.clone(), Arc::new(Mutex::new(None)));
        let sent = before.clone();
        as_it_looks(&mut arm, look, move || {
            *sent.lock().unwrap() = Some(operator.lines());
            operator.make(Fault::OperatorStop);
            // Until a camera has seen it once more.
            thread::sleep(time);
        });
        let error = execute(&mut arm, &plan).unwrap_err();
        let before = before.lock().unwrap().expect("it was looked");
        assert_eq!(emulator.lines(), before, "{maker:?} {look:?}: {error}");
        assert!(!emulator.is_running());
    }
    for look in [Look::BeforeDescent, Look::BeforeStrike] {
        for time in [40, 200].map(Duration::from_millis) {
            in_time(|| stopped_in::<XArm>(Maker::XArm, look, time));
            in_time(|| stopped_in::<Ur>(Maker::Ur, look, time));
        }
    }
}

#[test]
fn a_fence_that_is_set_while_the_arm_is_made_ready_is_kept() {
    in_time(|| {
        let plan = plan(&rig(), TO);
        let emulator = Maker::XArm.emulator(None);
        thread::scope(|scope| {
            scope.spawn(|| {
                wait_for(|| registers(&emulator).contains(&11));
                emulator.change(|model| {
                    // It ends before the object.
                    model.fence = [300, 100, 300, -300, 300, 0];
                    model.modes[1] = true;
                });
            });
            let error = Maker::XArm
                .strike(&emulator, &plan)
                .unwrap_err()
                .to_string();
            assert!(error.contains("own fence"), "{error}");
        });
        assert_eq!(emulator.lines(), 0);
    });
}

#[test]
fn a_strike_is_sent_right_after_the_last_look_or_not_at_all() {
    in_time(|| {
        let (plan, emulator, mut arm) = ready::<XArm>(Maker::XArm);
        let (looked, holds) = (Arc::new(Mutex::new(None)), emulator.clone());
        let at = looked.clone();
        // Reports cease when it is looked for the last time: what waits for one of them waits while the object may be moved.
        as_it_looks(&mut arm, Look::BeforeStrike, move || {
            *at.lock().unwrap() = Some(Instant::now());
            holds.make(Fault::Burst);
        });
        execute(&mut arm, &plan).unwrap_err();
        let looked = looked.lock().unwrap().expect("it was looked at");
        let events = emulator.events();
        let is_line =
            |(at, event): &&(Instant, Event)| *at > looked && matches!(event, Event::Line);
        let later = events.iter().find(is_line).map(|(at, _)| *at - looked);
        assert!(
            later.is_none_or(|later| later < Duration::from_millis(100)),
            "{later:?}"
        );
    });
}

#[test]
fn whoever_is_told_to_step_back_has_the_time_for_it_and_may_stop_the_arm() {
    fn told<D: Arm>(maker: Maker) {
        for is_stopped in [false, true] {
            let (plan, emulator, mut arm) = ready::<D>(maker);
            let pause = Duration::from_secs(1);
            arm.pause(pause);
            let begun = Instant::now();
            let outcome = thread::scope(|scope| {
                scope.spawn(|| {
                    thread::sleep(pause / 2);
                    if is_stopped {
                        emulator.make(Fault::OtherController);
                    }
                });
                execute(&mut arm, &plan)
            });
            let is_line = |(_, event): &&(Instant, Event)| matches!(event, Event::Line);
            let events = emulator.events();
            let first = events.iter().find(is_line);
            assert_eq!(first.is_none(), is_stopped, "{maker:?}: {outcome:?}");
            assert_eq!(outcome.is_err(), is_stopped, "{maker:?}: {outcome:?}");
            assert!(first.is_none_or(|(at, _)| at.duration_since(begun) >= pause));
        }
    }
    in_time(|| told::<XArm>(Maker::XArm));
    in_time(|| told::<Ur>(Maker::Ur));
}

#[test]
fn a_pose_that_freezes_as_a_line_begins_is_told_within_a_tenth_of_a_second() {
    fn frozen<D: Arm>(maker: Maker, fault: Fault) {
        let (plan, emulator, mut arm) = ready::<D>(maker);
        let freezes = emulator.clone();
        as_it_looks(&mut arm, Look::BeforeStrike, move || freezes.make(fault));
        let error = execute(&mut arm, &plan).unwrap_err();
        let events = emulator.events();
        let last = |is: fn(&Event) -> bool| {
            let found = events.iter().rev().find(|(_, event)| is(event));
            found.map(|(at, _)| *at).unwrap()
        };
        let line = last(|event| matches!(event, Event::Line));
        let stop = events
            .iter()
            .find(|(at, event)| *at > line && matches!(event, Event::Stop));
        let took = stop.unwrap().0.duration_since(line);
        assert!(
            took <= Duration::from_millis(100),
            "{maker:?}: {took:?}, {error}"
        );
    }
    for fault in [Fault::Frozen, Fault::Stale, Fault::Repeated] {
        in_time(|| frozen::<XArm>(Maker::XArm, fault));
        in_time(|| frozen::<Ur>(Maker::Ur, fault));
    }
}

#[test]
fn an_arm_that_answers_nothing_is_not_waited_for_longer_than_allowed() {
    fn asked<D: Arm>() -> Duration {
        let silent = [(); 4].map(|()| TcpListener::bind(("127.0.0.1", 0)).unwrap());
        let ports = silent.each_ref().map(|port| port.local_addr().unwrap());
        let begun = Instant::now();
        let mut driver = D::connect(&ports, Duration::from_millis(100)).unwrap();
        driver.pose().unwrap_err();
        begun.elapsed()
    }
    in_time(|| {
        for waited in [asked::<XArm>(), asked::<Ur>()] {
            assert!(waited < Duration::from_millis(400), "{waited:?}");
        }
    });
}

#[test]
fn an_arm_that_gets_no_sign_of_life_any_more_stops_by_itself() {
    in_time(|| {
        let plan = plan(&Maker::Ur.rig(), TO);
        let (emulator, outcome) = Maker::Ur.run(Some((Step::Line(4), Fault::Deaf)), &plan);
        outcome.unwrap_err();
        let events = emulator.events();
        let first = |is_it: fn(&Event) -> bool| events.iter().position(|(_, event)| is_it(event));
        let by_itself = first(|event| matches!(event, Event::Lifeless)).unwrap();
        let by_us = first(|event| matches!(event, Event::Stop)).unwrap();
        assert!(by_itself < by_us);
        let deaf = first(|event| matches!(event, Event::Fault)).unwrap();
        let after = events[by_itself].0 - events[deaf].0;
        println!("stopped by itself after {after:?}");
    });
}

#[test]
fn the_controller_is_asked_about_every_line_from_where_the_one_before_it_ends() {
    in_time(|| {
        let plan = plan(&rig(), TO);
        let (emulator, outcome) = undisturbed(Maker::XArm, &plan);
        outcome.unwrap();
        let events = emulator.events();
        let checked: Vec<(f64, f64)> = events
            .iter()
            .filter_map(|(_, event)| match event {
                Event::Checked(from, to) => Some((*from, *to)),
                _ => None,
            })
            .collect();
        assert_eq!(checked.len(), 5);
        assert!((checked[0].0 - model().pose[0]).abs() < 1e-3);
        for pair in checked.windows(2) {
            assert!((pair[1].0 - pair[0].1).abs() < 1e-3, "{checked:?}");
        }
        for maker in [Maker::XArm, Maker::Ur] {
            let plan = self::plan(&maker.rig(), TO);
            let emulator = maker.emulator(None);
            // In the middle of the strike's line.
            let wall = 0.5e3 * (plan.start.x + plan.stop.x);
            emulator.change(|arm| arm.wall = wall);
            let error = maker.strike(&emulator, &plan).unwrap_err().to_string();
            assert!(error.contains("cannot `strike`"), "{maker:?}: {error}");
            assert_eq!(emulator.lines(), 0);
        }
    });
}

#[test]
fn an_arm_that_its_pendant_has_or_another_program_is_not_moved() {
    let plan = plan(&Maker::Ur.rig(), TO);
    type Change = fn(&Emulator);
    let cases: [(Change, &str); 5] = [
        (|arm| arm.change(|model| model.is_local = true), "pendant"),
        (|arm| arm.make(Fault::SlowedDown), "slider"),
        (|arm| arm.make(Fault::FreeDrive), "free drive"),
        (|arm| arm.make(Fault::ToolChanged), "tool offset"),
        (Emulator::is_claimed, "another program"),
    ];
    for (change, said) in cases {
        let emulator = Maker::Ur.emulator(None);
        change(&emulator);
        let error = Maker::Ur.strike(&emulator, &plan).unwrap_err();
        let text = error.to_string();
        assert!(text.contains(said), "{said}: {text}");
        // Who may try again later is told so.
        let is_busy = matches!(error, RobotError::Busy { .. });
        assert_eq!(is_busy, said == "another program", "{text}");
        assert_eq!(emulator.lines(), 0);
    }
}

/// A way to an address on which all that is sent arrives late, once it is to.
fn late(to: SocketAddr, is_late: &Arc<AtomicBool>, by: Duration) -> SocketAddr {
    let is_late = is_late.clone();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let at = listener.local_addr().unwrap();
    thread::spawn(move || {
        for from in listener.incoming().map_while(Result::ok) {
            let mut onward = TcpStream::connect(to).unwrap();
            let is_late = is_late.clone();
            let (mut replies, mut back) = (onward.try_clone().unwrap(), from.try_clone().unwrap());
            thread::spawn(move || io::copy(&mut replies, &mut back));
            let (sent, held) = mpsc::channel::<(Instant, Vec<u8>)>();
            thread::spawn(move || {
                for (at, bytes) in held {
                    thread::sleep(at.saturating_duration_since(Instant::now()));
                    if onward.write_all(&bytes).is_err() {
                        break;
                    }
                }
            });
            thread::spawn(move || {
                let (mut from, mut bytes) = (from, [0; 4096]);
                while let Ok(count @ 1..) = from.read(&mut bytes) {
                    let later = by * u32::from(is_late.load(Ordering::Relaxed));
                    let came = (Instant::now() + later, bytes[..count].to_vec());
                    if sent.send(came).is_err() {
                        break;
                    }
                }
            });
        }
    });
    at
}

#[test]
fn a_line_that_comes_late_is_waited_for_until_the_stop_has_come_too() {
    fn held_up(ports: std::ops::Range<usize>) {
        let plan = plan(&Maker::Ur.rig(), TO);
        let emulator = Maker::Ur.emulator(None);
        let (mut late_ports, is_late) = (emulator.ports, Arc::new(AtomicBool::new(false)));
        for port in &mut late_ports[ports] {
            *port = late(*port, &is_late, Duration::from_millis(600));
        }
        let connected = Guarded::<Ur>::connect("arm", &late_ports, plan.rig(), Arc::default());
        let mut arm = connected.unwrap();
        arm.look_first(move |when| {
            is_late.store(when == Look::BeforeStrike, Ordering::Relaxed);
            Ok(())
        });
        execute(&mut arm, &plan).unwrap_err();
        drop(arm);
        let left = emulator.pose();
        thread::sleep(Duration::from_secs(1));
        let [x, y, z, ..] = emulator.pose();
        let moved = (x - left[0]).hypot(y - left[1]).hypot(z - left[2]);
        assert!(moved < 0.1, "{moved} mm after it was given up");
    }
    // Signs of life, which bring a line's number; and the stop, too.
    in_time(|| held_up(2..3));
    in_time(|| held_up(0..3));
}

#[test]
fn an_arm_of_either_maker_strikes_by_one_guard_and_what_it_did_is_in_the_log() {
    in_time(|| {
        for maker in [Maker::XArm, Maker::Ur] {
            let plan = plan(&maker.rig(), TO);
            let (emulator, outcome) = undisturbed(maker, &plan);
            let struck = outcome.unwrap().unwrap();
            assert_eq!(struck.warning, None);
            assert_eq!(emulator.lines(), 5);
            // Pose and speed from rest to rest.
            let samples = struck.samples;
            assert!(samples.states.len() > 60 && samples.commands.len() > 100);
            let speeds = samples.states.iter().map(|state| state.velocity[0]);
            let top = speeds.fold(0.0, f64::max);
            assert!((top / plan.speed - 1.0).abs() < 0.01, "{top}");
            // It ends above the stop, at travel height.
            let [x, y, z, ..] = emulator.pose();
            assert!((x * 1e-3 - plan.stop.x).abs() < 1e-3 && (y * 1e-3 - plan.stop.y).abs() < 1e-3);
            assert!((z - 70.0).abs() < 1.0);
        }
    });
}

#[test]
fn a_program_of_another_computer_that_sends_the_same_lines_is_seen() {
    in_time(|| {
        let plan = plan(&rig(), TO);
        let emulator = Maker::XArm.emulator(None);
        let mut other = XArm::connect(&emulator.ports, Duration::from_secs(1)).unwrap();
        let outcome = thread::scope(|scope| {
            scope.spawn(|| {
                // On its way to the start.
                wait_for(|| emulator.lines() == 2 && emulator.is_running());
                let mut to = other.pose().unwrap();
                to.at = [plan.start.x, plan.start.y, to.at[2]];
                let same = LineRequest {
                    to,
                    speed: 0.1,
                    acceleration: 0.5,
                };
                other.line(&same).unwrap();
            });
            Maker::XArm.strike(&emulator, &plan)
        });
        let error = outcome.unwrap_err().to_string();
        assert!(error.contains("another program"), "{error}");
    });
}

#[test]
fn one_program_drives_an_arm_at_a_time() {
    let rig = rig();
    let emulator = Maker::XArm.emulator(None);
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
    let [one, other] = [same.clone(), same].map(|model| Maker::XArm.listening(model, None));
    let _first = connect(&one, &rig).unwrap();
    assert!(matches!(
        connect(&other, &rig),
        Err(RobotError::Busy { .. })
    ));
}

#[test]
fn another_arm_at_the_address_of_the_rigs_is_not_moved() {
    fn exchanged<D: Arm>(maker: Maker) {
        let [own, other] = [(); 2].map(|()| maker.emulator(None));
        let mut rig = maker.rig();
        let connect =
            |emulator: &Emulator, rig: &Rig| connect_to::<D>(emulator, rig, Arc::default());
        rig.robot.serial = Some(connect(&own, &rig).unwrap().serial().to_owned());
        connect(&own, &rig).unwrap();
        let error = connect(&other, &rig).err().unwrap();
        assert_not_ready(&error, &["robot.serial"]);
    }
    exchanged::<XArm>(Maker::XArm);
    exchanged::<Ur>(Maker::Ur);
}

#[test]
fn a_base_whose_height_is_wrong_moves_no_arm_down_into_the_table() {
    in_time(|| {
        for maker in [Maker::XArm, Maker::Ur] {
            for (height, said) in [
                (0.3, "367.0 mm above"),
                (0.05, "bring the tip to travel height"),
                (-0.05, "bring the tip to travel height"),
                (-0.3, "inside it"),
            ] {
                let mut rig = maker.rig();
                rig.robot.base_height = Some(height);
                let emulator = maker.emulator(None);
                let error = maker.strike(&emulator, &plan(&rig, TO)).unwrap_err();
                assert_not_ready(&error, &[said, "robot.base_height"]);
                assert_eq!(emulator.lines(), 0);
            }
        }
    });
}

#[test]
fn an_arm_strikes_from_travel_height_alone_as_far_as_half_the_tips_clearance_goes() {
    in_time(|| {
        for maker in [Maker::XArm, Maker::Ur] {
            // The tip strikes 8 mm above the table.
            for (height, strikes) in [(20.0, false), (65.0, false), (73.0, true), (75.0, false)] {
                let mut model = maker.near();
                model.pose[2] = height;
                let emulator = maker.listening(model, None);
                let outcome = maker.strike(&emulator, &plan(&maker.rig(), TO));
                assert_eq!(outcome.is_ok(), strikes, "{maker:?}: {outcome:?}");
                assert_eq!(emulator.lines() > 0, strikes, "{maker:?}");
            }
        }
    });
}

#[test]
fn an_arm_that_carom_stopped_low_goes_on_from_there_alone_and_by_the_same_heights() {
    in_time(|| {
        let (rig, memory) = (rig(), tempfile::tempdir().unwrap());
        let emulator = Maker::XArm.emulator(None);
        let call = |rig: &Rig, is_moved: bool| {
            let mut arm = connect(&emulator, rig).unwrap();
            let mut memory = Memory::open(memory.path(), arm.serial()).unwrap();
            arm.look_first(move |when| match (when, is_moved) {
                (Look::BeforeStrike, true) => Err("it has moved".into()),
                _ => Ok(()),
            });
            let (plan, never) = (plan(rig, TO), AtomicBool::new(false));
            strike_and_keep(&mut arm, &plan, None, &mut memory, &never).0
        };
        let stopped = call(&rig, true).unwrap_err();
        assert!(stopped.to_string().contains("has moved"), "{stopped}");
        let [_, _, low, ..] = emulator.pose();
        assert!((low - 20.0).abs() < 1.0, "{low}");
        // Who edits the rig file meanwhile says that it stands elsewhere. A call that is refused forgets nothing.
        let (mut higher, before) = (rig.clone(), emulator.lines());
        higher.robot.base_height = Some(0.05);
        assert_not_ready(&call(&higher, false).unwrap_err(), &["base_height"]);
        assert_eq!(emulator.lines(), before);
        call(&rig, false).unwrap();
    });
}

#[test]
fn nothing_is_struck_once_whoever_read_standard_error_is_gone() {
    const CHILD: &str = "CAROM_TEST_UNHEARD";
    if std::env::var_os(CHILD).is_some() {
        let (plan, emulator, mut arm) = ready::<XArm>(Maker::XArm);
        as_it_looks(&mut arm, Look::BeforeStrike, || {
            println!("looks");
            // Until the reader of standard error is gone.
            io::stdin().read_line(&mut String::new()).unwrap();
        });
        let error = execute(&mut arm, &plan).unwrap_err().to_string();
        println!("{} lines; {error}", emulator.lines());
        return;
    }
    in_time(|| {
        let name = "nothing_is_struck_once_whoever_read_standard_error_is_gone";
        let mut child = itself(name, CHILD)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut said = io::BufReader::new(child.stdout.take().unwrap()).lines();
        let looks = said.find(|line| line.as_ref().is_ok_and(|line| line.ends_with("looks")));
        assert!(looks.is_some());
        drop(child.stderr.take());
        child.stdin.take().unwrap().write_all(b"\n").unwrap();
        let told: Vec<String> = said.map_while(Result::ok).collect();
        let told = told.join("\n");
        child.wait().unwrap();
        // Lift, travel and lower.
        assert!(
            told.contains("3 lines;") && told.contains("standard error is gone"),
            "{told}"
        );
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
        let (emulator, outcome) = Maker::XArm.run_of(model, None, &plan);
        assert_not_ready(&outcome.expect_err(said), &[said, "nothing has moved"]);
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
    let emulator = Maker::XArm.emulator(None);
    let error = connect(&emulator, &rig).unwrap_err();
    assert!(
        error.to_string().contains("lacks travel_height, payload"),
        "{error}"
    );
    assert!(registers(&emulator).is_empty());
}

/// Strikes, and stops in the middle of the strike's line by what is done from another thread.
fn stopped_by(
    stop: impl FnOnce(&Guarded<XArm>, &Arc<AtomicBool>) -> Box<dyn FnOnce() + Send>,
    said: &str,
) {
    let rig = rig();
    let plan = plan(&rig, TO);
    let emulator = Maker::XArm.emulator(None);
    let interrupted = Arc::new(AtomicBool::new(false));
    let mut arm = connect_to::<XArm>(&emulator, plan.rig(), interrupted.clone()).unwrap();
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
        stopped_by(
            |_, interrupted| {
                let interrupted = interrupted.clone();
                Box::new(move || interrupted.store(true, Ordering::Relaxed))
            },
            "signal",
        );
    });
}
