//! Messages out of order, in floods, and topics that a log may have beside the required ones.

use std::time::Instant;

use crate::common::{
    EPOCH, Folder, IMPACT, JsonMessage, Truth, ingest, ingest_samples, json_log, noted, point,
    session, time, truths, twist,
};
use logs::write::{Samples, Stamped, StateSample};
use values::Point;

/// A pose, turned by an angle.
fn pose(sample: &Stamped, yaw: f64) -> JsonMessage {
    let (sin, cos) = (0.5 * yaw).sin_cos();
    let body = format!(
        r#""pose":{{"position":{{"x":{:?},"y":{:?},"z":0.02}},"orientation":{{"x":0.0,"y":0.0,"z":{sin:?},"w":{cos:?}}}}}"#,
        sample.x, sample.y
    );
    ("/object/pose", sample.stamp, body)
}

#[test]
fn messages_that_overtook_each_other_change_nothing() {
    let samples = session(&truths(3));
    let mut messages: Vec<_> = samples.centroids.iter().map(point).collect();
    messages.extend(samples.commands.iter().map(twist));
    messages.sort_by_key(|(_, stamp, _)| *stamp);
    let folder = Folder::new();
    let path = folder.path("a.mcap");
    std::fs::write(&path, json_log(&messages, 0)).expect("writes");
    let in_order = ingest(&path);
    assert_eq!(in_order.strikes.len(), 3);
    // Two centroids, two commands and a handful of both, around the second strike's contact.
    let contact = EPOCH + ((truths(3)[1].start + IMPACT) * 1e9) as u64;
    let at = messages.partition_point(|(_, stamp, _)| *stamp < contact);
    let nth = |topic: &str, nth: usize| {
        (at..messages.len())
            .filter(|i| messages[*i].0 == topic)
            .nth(nth)
            .expect("a message")
    };
    for (a, b) in [
        (nth("/object/centroid", 2), nth("/object/centroid", 3)),
        (nth("/object/centroid", 6), nth("/object/centroid", 9)),
        (nth("/striker/command", 1), nth("/striker/command", 2)),
    ] {
        let mut swapped = messages.clone();
        swapped.swap(a, b);
        std::fs::write(&path, json_log(&swapped, 0)).expect("writes");
        let outcome = ingest(&path);
        assert_eq!(outcome.rejects, [], "{a} {b}");
        assert_eq!(outcome.strikes, in_order.strikes, "{a} {b}");
    }
    // Each up to 0.4 s later than its stamp says.
    let late = |i: usize| 400_000_000 * ((i * i * 7919 + i * 104_729) % 1000) as u64 / 1000;
    let mut shuffled: Vec<_> = messages.iter().cloned().enumerate().collect();
    shuffled.sort_by_key(|(i, message)| message.1 + late(*i));
    let shuffled: Vec<_> = shuffled.into_iter().map(|(_, message)| message).collect();
    std::fs::write(&path, json_log(&shuffled, 0)).expect("writes");
    let outcome = ingest(&path);
    assert_eq!(
        (outcome.rejects, outcome.strikes),
        (vec![], in_order.strikes)
    );
}

#[test]
fn a_flood_of_commands_takes_time_in_proportion() {
    // One command that never rests, at one stamp a microsecond: each message was once compared with all before.
    let seconds = |count: u64| {
        let mut samples = session(&[]);
        samples.commands = (0..count)
            .map(|i| Stamped::at(EPOCH + 1_000 * i, Point::new(0.7, 0.0)))
            .collect();
        let folder = Folder::new();
        let path = folder.write("a.mcap", &samples);
        let begun = Instant::now();
        let outcome = ingest(&path);
        assert_eq!(outcome.strikes, []);
        begun.elapsed().as_secs_f64()
    };
    let (few, many) = (seconds(40_000), seconds(160_000));
    // Four times the messages took thirteen times as long.
    assert!(many < 8.0 * few + 0.5, "{few} s, {many} s");
}

#[test]
fn commands_that_all_come_before_the_centroids_are_held_within_bounds() {
    // Two million of them, more than wait; none of their strikes is lost without a word.
    let strikes = 400;
    let mut messages: Vec<JsonMessage> = Vec::new();
    let samples = session(&truths(2));
    messages.extend(samples.commands.iter().map(twist));
    messages.extend(samples.centroids.iter().map(point));
    let folder = Folder::new();
    let path = folder.path("a.mcap");
    std::fs::write(&path, json_log(&messages, 0)).expect("writes");
    assert_eq!(ingest(&path).strikes.len(), 2, "two strikes wait");

    let mut flood = Samples::default();
    let later = EPOCH + 1_000_000_000_000;
    for strike in 0..strikes {
        for i in 0..5_000_u64 {
            let speed = if i < 4_900 { 0.7 } else { 0.0 };
            flood.commands.push(Stamped::at(
                later + (strike * 5_000 + i) * 2_000_000,
                Point::new(speed, 0.0),
            ));
        }
    }
    let outcome = ingest(&folder.write("b.mcap", &flood));
    assert_eq!(outcome.rejects.len(), strikes as usize);
    noted(&outcome, "before the centroids of their time");
}

/// A session with the arm's states at a rate: the commanded profile, a share of it, turned.
fn with_states(truths: &[Truth], rate: f64, share: f64, turn: f64) -> Samples {
    let mut samples = session(truths);
    let end = samples.commands.last().map_or(0, |last| last.stamp) - EPOCH;
    samples.states = (0..(end as f64 * 1e-9 * rate) as u64)
        .map(|i| (i as f64 + 0.4) / rate)
        .map(|t| {
            let velocity = crate::common::velocity(truths, t).rotated(turn) * share;
            StateSample {
                stamp: EPOCH + (t * 1e9) as u64,
                position: [0.0, 0.0],
                velocity: [velocity.x, velocity.y],
            }
        })
        .collect();
    samples
}

#[test]
fn what_the_arm_delivered_is_read_where_it_is_logged() {
    let truths = truths(6);
    let plain = ingest_samples(&session(&truths));
    assert!(
        plain
            .strikes
            .iter()
            .all(|strike| strike.delivered.is_none())
    );
    for rate in [50.0, 250.0] {
        let outcome = ingest_samples(&with_states(&truths, rate, 0.92, 0.03));
        assert_eq!(outcome.rejects, []);
        assert_eq!(outcome.strikes.len(), truths.len());
        for ((strike, truth), plain) in outcome.strikes.iter().zip(&truths).zip(&plain.strikes) {
            let delivered = strike.delivered.expect("it is logged");
            assert!(
                (delivered.tip_speed - 0.92 * truth.speed).abs() < 1e-3,
                "{delivered:?}"
            );
            assert!(
                (delivered.tip_angle - truth.angle - 0.03).abs() < 1e-3,
                "{delivered:?}"
            );
            let contact = strike.t_start + delivered.contact - EPOCH as f64 * 1e-9;
            assert!(
                (contact - truth.start - IMPACT).abs() < 0.006,
                "{delivered:?}"
            );
            assert!(!delivered.pushed_again);
            assert_eq!(strike.id, plain.id, "the state makes no other strike of it");
        }
    }
}

#[test]
fn a_log_without_commands_is_read_by_the_arms_state() {
    let truths = truths(6);
    for rate in [50.0, 250.0] {
        let samples = Samples {
            commands: Vec::new(),
            ..with_states(&truths, rate, 0.92, 0.03)
        };
        let outcome = ingest_samples(&samples);
        assert_eq!(outcome.rejects, []);
        assert_eq!(outcome.strikes.len(), truths.len());
        for (strike, truth) in outcome.strikes.iter().zip(&truths) {
            let (speed, angle) = (0.92 * truth.speed, truth.angle + 0.03);
            assert!(
                (strike.command.speed - speed).abs() < 0.02 * speed,
                "{:?}",
                strike.command
            );
            assert!(
                (strike.command.angle - angle).abs() < 1e-3,
                "{:?}",
                strike.command
            );
        }
        noted(&outcome, "no command is logged");
    }
}

/// A session without commands whose tip meets each object so far aside (rad) of the line through its centre, and goes on in its direction. The
/// measured place is that of `late` seconds ago.
fn touching(truths: &[Truth], aside: f64, late: f64) -> Samples {
    let mut samples = with_states(truths, 250.0, 1.0, aside);
    let rig = crate::common::rig();
    let reach = rig.object.solid.reach() + rig.striker.radius;
    let share = |s: f64| {
        let (rise, plateau) = (s.clamp(0.0, 0.15), (s - 0.15).clamp(0.0, 0.1));
        let fall = (s - 0.25).clamp(0.0, 0.15);
        rise * rise / 0.3 + plateau + fall - fall * fall / 0.3
    };
    for state in &mut samples.states {
        let t = (state.stamp - EPOCH) as f64 * 1e-9 - late;
        let near = truths.iter().rev().find(|truth| truth.start - 1.0 <= t);
        let truth = near.unwrap_or(&truths[0]);
        let gone = truth.speed * (share(t - truth.start) - share(IMPACT));
        let touch = truth.initial - Point::polar(reach, truth.angle);
        let place = touch + Point::polar(gone, truth.angle + aside);
        state.position = [place.x, place.y];
    }
    Samples {
        commands: Vec::new(),
        ..samples
    }
}

#[test]
fn without_commands_a_round_object_is_pushed_along_the_line_of_centres() {
    let truths = truths(8);
    for aside in [0.0, 0.4, -0.5] {
        let outcome = ingest_samples(&touching(&truths, aside, 0.0));
        assert_eq!(
            (outcome.rejects.len(), outcome.strikes.len()),
            (0, truths.len())
        );
        for (strike, truth) in outcome.strikes.iter().zip(&truths) {
            let speed = truth.speed * f64::cos(aside);
            let (command, stop) = (strike.command, truth.stop());
            assert!(
                (command.speed - speed).abs() < 0.03 * speed,
                "{aside} {command:?}"
            );
            assert!(
                (command.angle - truth.angle).abs() < 0.02,
                "{aside} {command:?} {truth:?}"
            );
            assert_eq!(strike.conditions.moving, None);
            assert!(strike.has_stop(), "{:?}", strike.track.end);
            assert!(
                strike.stop.distance(stop) < 0.003,
                "{:?} {stop:?}",
                strike.stop
            );
            assert!(strike.initial.distance(truth.initial) < 0.001);
        }
    }
}

#[test]
fn how_far_the_encoder_lies_behind_the_camera_is_measured_at_touches() {
    let truths = truths(8);
    for late in [0.0, 0.008] {
        let outcome = ingest_samples(&touching(&truths, 0.0, late));
        let delays: Vec<f64> = outcome.seen.delays.iter().map(|d| d.seconds).collect();
        assert_eq!(delays.len(), truths.len());
        let mean = delays.iter().sum::<f64>() / delays.len() as f64;
        assert!((mean + late).abs() < 0.003, "{late} {delays:?}");
    }
}

/// A session in which a hand pushes each object towards the robot before it is struck: it moves at the impact.
fn pushed(truths: &[Truth], moving: f64) -> Samples {
    let mut samples = touching(truths, 0.0, 0.0);
    samples.commands = session(truths).commands;
    for centroid in &mut samples.centroids {
        let t = time(centroid);
        for truth in truths {
            let before = truth.start + IMPACT - t;
            if (0.0..1.2).contains(&before) {
                centroid.x += moving * before;
            }
        }
    }
    samples
}

#[test]
fn an_object_that_moves_is_struck_under_a_command_too_where_the_state_is_logged() {
    let truths = truths(8);
    let samples = pushed(&truths, 0.3);
    let outcome = ingest_samples(&samples);
    assert!(outcome.strikes.len() >= 7, "{:?}", outcome.rejects);
    for strike in &outcome.strikes {
        let moving = strike.conditions.moving.expect("it moved");
        assert!(moving.distance(Point::new(-0.3, 0.0)) < 0.05, "{moving:?}");
        let truth = &truths[strike.index as usize];
        // The tip goes at it, and it comes to meet the tip.
        let met = truth.speed + 0.3 * truth.angle.cos();
        assert!(
            (strike.command.speed - met).abs() < 0.04 * met,
            "{:?}",
            strike.command
        );
        assert!((strike.command.angle - truth.angle).abs() < 0.04);
    }
    // Without the state nothing tells what the tip met.
    let plain = ingest_samples(&Samples {
        states: Vec::new(),
        ..samples
    });
    assert!(plain.rejects.len() >= 7 && plain.strikes.len() <= 1);
}

#[test]
fn states_may_lie_behind_all_else_in_the_file_or_be_of_another_kind() {
    let truths = truths(3);
    let samples = with_states(&truths, 100.0, 0.9, 0.0);
    let states = Samples {
        states: samples.states.clone(),
        ..Samples::default()
    };
    let folder = Folder::new();
    let outcome = ingest(&folder.write_parts("a.mcap", &[&session(&truths), &states]));
    assert_eq!(outcome.strikes.len(), 3);
    assert!(
        outcome
            .strikes
            .iter()
            .all(|strike| strike.delivered.is_some())
    );

    // A topic of that name that is something else takes no strike with it, and is reported.
    let mut messages: Vec<_> = session(&truths).centroids.iter().map(point).collect();
    messages.extend(session(&truths).commands.iter().map(twist));
    messages.push(("/striker/state", EPOCH, r#""text":"ready""#.into()));
    messages.push(("/object/pose", EPOCH, r#""text":"ready""#.into()));
    let path = folder.path("b.mcap");
    std::fs::write(&path, json_log(&messages, 0)).expect("writes");
    let outcome = ingest(&path);
    assert_eq!(outcome.strikes.len(), 3);
    for topic in ["/striker/state", "/object/pose"] {
        let is_noted = outcome
            .notes
            .iter()
            .any(|note| note.contains(topic) && note.contains("could not be decoded"));
        assert!(is_noted, "{:?}", outcome.notes);
    }
}

#[test]
fn poses_stand_in_for_centroids_and_give_the_yaw() {
    let truths = truths(3);
    let samples = session(&truths);
    let by_centroids = ingest_samples(&samples);
    // It turns by 2 rad/s while it slides.
    let yaw = |stamp: u64| {
        let t = (stamp - EPOCH) as f64 * 1e-9;
        let since = |truth: &Truth| t - truth.start - IMPACT;
        let last = truths.iter().rev().find(|truth| since(truth) > -1.7);
        let slides = last.map_or(0.0, |truth| {
            since(truth).clamp(0.0, truth.release / truth.deceleration)
        });
        0.4 + 2.0 * slides
    };
    let poses = || samples.centroids.iter().map(|s| pose(s, yaw(s.stamp)));
    let folder = Folder::new();
    for with_centroids in [false, true] {
        let mut messages: Vec<_> = samples.commands.iter().map(twist).collect();
        messages.extend(poses());
        if with_centroids {
            messages.extend(samples.centroids.iter().map(point));
        }
        messages.sort_by_key(|(_, stamp, _)| *stamp);
        let path = folder.path("a.mcap");
        std::fs::write(&path, json_log(&messages, 0)).expect("writes");
        let outcome = ingest(&path);
        assert_eq!(outcome.rejects, [], "{:?}", outcome.notes);
        for ((strike, plain), truth) in outcome
            .strikes
            .iter()
            .zip(&by_centroids.strikes)
            .zip(&truths)
        {
            assert_eq!((strike.initial, strike.stop), (plain.initial, plain.stop));
            let found = strike.track.yaw.as_ref().expect("tracked");
            // Frames before it is seen to move count as rest, in which it may turn by a milliradian.
            assert!((found.initial - 0.4).abs() < 2e-3, "{}", found.initial);
            assert_eq!(found.track.len(), strike.track.len());
            let last = found.track.last().expect("frames");
            let turned = 2.0 * truth.release / truth.deceleration;
            assert!((last - 0.4 - turned).abs() < 1e-6, "{last} {turned}");
        }
    }
}
