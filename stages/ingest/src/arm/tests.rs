use super::*;

/// A trapezoid to `speed`, with a plateau from 0.15 s to `fall`, at a time.
fn trapezoid(speed: f64, fall: f64, t: f64) -> f64 {
    speed * (t / 0.15).min((fall + 0.15 - t) / 0.15).clamp(0.0, 1.0)
}

/// Numbers that look random, uniform within ±1.
fn wobble(i: usize) -> f64 {
    let x = (i as f64 * 12.9898).sin() * 43_758.545_3;
    2.0 * (x - x.floor()) - 1.0
}

struct Case {
    /// Share of the command that is delivered, up to a cap in m/s, and angle.
    share: f64,
    cap: f64,
    angle: f64,
    /// How late the arm follows, and how late the camera is, in s.
    delay: f64,
    late: f64,
    /// States a second, and their noise in m/s.
    rate: f64,
    noise: f64,
}

const EXACT: Case = Case {
    share: 0.93,
    cap: 9.0,
    angle: 0.23,
    delay: 0.0,
    late: 0.0,
    rate: 250.0,
    noise: 0.0,
};

/// What is found of a strike at 0.8 m/s and 0.2 rad, whose contact is at 0.162 s, in the middle of a plateau of 25 ms.
fn found(case: &Case, phase: f64) -> Delivered {
    let nanoseconds = |t: f64| (t * 1e9).round() as i64;
    let (speed, contact, frame) = (0.8, 0.162, 1.0 / 60.0);
    let commands: Vec<Sample> = (0..=80)
        .map(|i| f64::from(i) / 250.0)
        .map(|t| (t, Point::polar(trapezoid(speed, 0.175, t), 0.2)))
        .map(|(t, v)| Sample::at(nanoseconds(t), v))
        .collect();
    let states: Vec<State> = (-20..120)
        .map(|i| (f64::from(i) + phase) / case.rate)
        .enumerate()
        .map(|(i, t)| {
            let speed = (case.share * trapezoid(speed, 0.175, t - case.delay)).min(case.cap);
            let noise = Point::new(wobble(2 * i), wobble(2 * i + 1)) * (case.noise * 3f64.sqrt());
            State {
                stamp: nanoseconds(t),
                velocity: Point::polar(speed, case.angle) + noise,
                position: Point::new(f64::NAN, f64::NAN),
            }
        })
        .collect();
    let (launch, first) = (1.1, contact + case.late + 0.4 * frame);
    let track_at = |t: f64| launch * t - t * t;
    let mut track = Track::default();
    for i in 0..30 {
        let t = f64::from(i) * frame;
        let at = Point::polar(track_at(t + 0.4 * frame), 0.2);
        track.t.push(t);
        track.x.push(at.x);
        track.y.push(at.y);
    }
    let context = LaunchContext {
        commands: &commands,
        command: Command { speed, angle: 0.2 },
        first_motion: nanoseconds(first),
        gap: frame,
        initial: Point::default(),
        track: &track,
        noise: 0.0007,
    };
    let (delivered, _) = delivered(&states, &context).expect("found");
    // The line through the first frames of a slide that slows down meets zero a millisecond early.
    assert!((delivered.contact + 0.4 * frame).abs() < 0.0015);
    assert!(!delivered.pushed_again);
    delivered
}

#[test]
fn a_scaled_and_turned_command_is_measured_exactly_at_any_rate_and_phase() {
    for rate in [50.0, 100.0, 250.0, 1000.0] {
        for phase in [0.0, 0.3, 0.6, 0.9] {
            let delivered = found(&Case { rate, ..EXACT }, phase);
            assert!(
                (delivered.tip_speed - 0.744).abs() < 1e-4,
                "{rate} {phase} {delivered:?}"
            );
            assert!(
                (delivered.tip_angle - 0.23).abs() < 1e-6,
                "{rate} {phase} {delivered:?}"
            );
        }
    }
}

#[test]
fn where_the_camera_is_late_the_arm_is_measured_before_it_brakes() {
    // An object that is met at 0.162 s is seen to move at 0.187 s, when the arm has braked for 12 ms.
    for (rate, phase) in [(50.0, 0.0), (50.0, 0.5), (250.0, 0.3)] {
        let case = Case {
            late: 0.025,
            rate,
            ..EXACT
        };
        let delivered = found(&case, phase);
        assert!(
            (delivered.tip_speed - 0.744).abs() < 0.002,
            "{rate} {phase} {delivered:?}"
        );
    }
}

#[test]
fn a_delay_of_the_arm_is_taken_into_account() {
    // 8 ms late: at contact the arm is on its plateau, though the nearest states at 50 Hz are not.
    for phase in [0.0, 0.25, 0.5, 0.75] {
        let delivered = found(
            &Case {
                delay: 0.008,
                rate: 50.0,
                ..EXACT
            },
            phase,
        );
        assert!(
            (delivered.tip_speed - 0.744).abs() < 0.004,
            "{phase} {delivered:?}"
        );
    }
}

#[test]
fn an_arm_that_saturates_is_measured_by_its_own_plateau() {
    for phase in [0.0, 0.25, 0.5, 0.75] {
        let delivered = found(
            &Case {
                share: 1.0,
                cap: 0.7,
                ..EXACT
            },
            phase,
        );
        assert!(
            (delivered.tip_speed - 0.7).abs() < 0.003,
            "{phase} {delivered:?}"
        );
    }
}

#[test]
fn noise_of_the_states_is_averaged() {
    let noise = 0.01;
    for (rate, most) in [(50.0, 0.9), (250.0, 0.45)] {
        let case = Case {
            rate,
            noise,
            ..EXACT
        };
        let errors: Vec<f64> = (0..40)
            .map(|i| found(&case, f64::from(i) / 40.0).tip_speed - 0.744)
            .collect();
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        assert!(rms < most * noise, "{rate} Hz: {rms}");
    }
}

#[test]
fn states_that_do_not_reach_contact_give_nothing() {
    let sample = |i: i64| Sample::at(i * 4_000_000, Point::new(0.7, 0.0));
    let commands: Vec<Sample> = (0..50).map(sample).collect();
    let track = Track {
        t: vec![0.0, 0.02, 0.04],
        x: vec![0.01, 0.03, 0.05],
        y: vec![0.0; 3],
        yaw: None,
        end: values::End::Rest,
    };
    let context = LaunchContext {
        commands: &commands,
        command: Command::new(0.7, 0.0),
        first_motion: 150_000_000,
        gap: 0.02,
        initial: Point::default(),
        track: &track,
        noise: 0.0007,
    };
    let state = |i: i64| State {
        stamp: i * 4_000_000,
        velocity: Point::new(0.7, 0.0),
        position: Point::default(),
    };
    let early: Vec<State> = (0..10).map(state).collect();
    assert_eq!(delivered(&early, &context), None);
    assert_eq!(delivered(&[], &context), None);
    let all: Vec<State> = (0..60).map(state).collect();
    assert!(delivered(&all, &context).is_some());
    let still: Vec<State> = all
        .iter()
        .map(|state| State {
            velocity: Point::default(),
            ..*state
        })
        .collect();
    assert_eq!(
        delivered(&still, &context),
        None,
        "an arm that did not move struck nothing"
    );
}

/// Whether an arm has pushed on that goes on behind the object, at a part of its speed after the impact: by its state.
fn pushed(goes_on: f64) -> bool {
    let commands: Vec<Sample> = (0..200)
        .map(|i| Sample::at(i * 4_000_000, Point::new(0.8, 0.0)))
        .collect();
    let mut track = Track::default();
    // It leaves at 1 m/s, slows down by 2 m/s², and is taken along by the tip where that is faster.
    let (mut object, mut tip, mut launch) = (0.0, 0.0, 1.0);
    let mut states = Vec::new();
    for i in 0..1000 {
        let t = f64::from(i) * 1e-3;
        let speed = if t < 0.1 { 0.8 } else { 0.8 * goes_on };
        if i % 4 == 0 {
            states.push(State {
                stamp: i64::from(i) * 1_000_000,
                velocity: Point::new(speed, 0.0),
                position: Point::new(tip, 0.3),
            });
        }
        if t >= 0.1 {
            if object - (tip - 0.08) <= 0.0 && launch < speed {
                launch = speed;
            }
            object += launch * 1e-3;
            launch = f64::max(launch - 2e-3, 0.0);
            if i % 16 == 4 {
                track.t.push(t - 0.104);
                track.x.push(object);
                track.y.push(0.0);
            }
        }
        tip += speed * 1e-3;
    }
    let context = LaunchContext {
        commands: &commands,
        command: Command::new(0.8, 0.0),
        first_motion: 104_000_000,
        gap: 0.016,
        initial: Point::default(),
        track: &track,
        noise: 0.0007,
    };
    delivered(&states, &context).expect("found").0.pushed_again
}

#[test]
fn an_arm_that_reaches_the_object_again_has_pushed_it_again() {
    assert!(pushed(1.0) && pushed(0.8));
    assert!(!pushed(0.0) && !pushed(0.1));
}

#[test]
fn an_arm_whose_states_lie_beside_its_commands_is_seen_to() {
    let sample = |t: f64, speed: f64| Sample::at((t * 1e9).round() as i64, Point::new(speed, 0.0));
    let speed = |t: f64| trapezoid(0.8, 0.175, t);
    let commands: Vec<Sample> = (0..=33)
        .map(|i| f64::from(i) / 100.0)
        .map(|t| sample(t, speed(t)))
        .collect();
    for rate in [50.0, 125.0] {
        for late in [-0.3, -0.02, 0.0, 0.05, 0.4] {
            let states: Vec<State> = (0..(2.0 * rate) as usize)
                .map(|i| {
                    let t = i as f64 / rate - 0.6;
                    // Half a second later it goes to its next place.
                    let goes = 0.3 * trapezoid(1.0, 0.4, t - late - 0.8);
                    State {
                        stamp: (t * 1e9).round() as i64,
                        velocity: Point::polar(0.9 * speed(t - late) + goes, 0.4)
                            + Point::new(wobble(2 * i), wobble(2 * i + 1)) * 0.01,
                        position: Point::default(),
                    }
                })
                .collect();
            let found = behind(&states, &commands).expect("it moves");
            assert!((found - late).abs() < 0.006, "{rate} {late}: {found}");
        }
    }
    assert_eq!(behind(&[], &commands), None);
}

/// Whether an arm has pushed on that is commanded to go on for so long (s) after an impact by which the object leaves at this multiple of its speed:
/// by its command. A table brakes by 3 m/s²; the arm delivers this part of the command.
fn pushed_by_command(lasts: f64, gain: f64, delivers: f64) -> bool {
    const SPEED: f64 = 0.7;
    let commands: Vec<Sample> = (0..80)
        .map(|i| Sample {
            stamp: i * 10_000_000,
            x: if i as f64 * 0.01 <= 0.1 + lasts {
                SPEED
            } else {
                0.0
            },
            y: 0.0,
        })
        .collect();
    let (mut object, mut tip, mut speed) = (0.0, 0.0, gain * delivers * SPEED);
    let mut track = Track::default();
    for i in 0..1000 {
        if i % 16 == 4 {
            track.t.push(f64::from(i - 4) * 1e-3);
            track.x.push(object);
            track.y.push(0.0);
        }
        let arm = if f64::from(i) * 1e-3 < lasts {
            delivers * SPEED
        } else {
            0.0
        };
        if object <= tip && speed < arm {
            speed = arm;
        }
        object += speed * 1e-3;
        tip += arm * 1e-3;
        speed = f64::max(speed - 3e-3, 0.0);
    }
    let context = LaunchContext {
        commands: &commands,
        command: Command::new(SPEED, 0.0),
        first_motion: 104_000_000,
        gap: 0.016,
        initial: Point::default(),
        track: &track,
        noise: 0.0005,
    };
    pushes_on(&context, Point::new(object, 0.0))
}

#[test]
fn an_arm_that_is_commanded_to_go_on_behind_a_slow_object_pushes_it_on() {
    assert!(pushed_by_command(0.1, 1.02, 1.0) && pushed_by_command(0.15, 1.1, 1.0));
    // It ends at the impact, or the object is faster, or the arm is slower than it is told to be.
    assert!(!pushed_by_command(0.0, 1.02, 1.0) && !pushed_by_command(0.02, 1.02, 1.0));
    assert!(!pushed_by_command(0.1, 1.4, 1.0) && !pushed_by_command(0.1, 1.4, 0.7));
}
