//! What goes wrong on a robot: each strike is kept or rejected with its reason, and never guessed.

use crate::common::{
    EPOCH, Folder, IMPACT, Truth, ingest, ingest_samples, noted, reasons, session, time, truths,
};
use ingest::LogOutcome;
use logs::write::{Samples, Stamped};
use values::{End, Fence, Point};

/// A session of three strikes, with a fault put in around the second one.
fn with_fault(fault: impl Fn(&Truth, &mut Samples)) -> LogOutcome {
    let truths = truths(3);
    let mut samples = session(&truths);
    fault(&truths[1], &mut samples);
    ingest_samples(&samples)
}

/// Checks that the second strike is rejected for this reason, and the others are kept.
#[track_caller]
fn rejected(reason: &str, fault: impl Fn(&Truth, &mut Samples)) {
    let outcome = with_fault(fault);
    assert_eq!(
        reasons(&outcome.rejects),
        [(1, reason)],
        "{:?}",
        outcome.rejects
    );
    assert_eq!(
        outcome
            .strikes
            .iter()
            .map(|strike| strike.index)
            .collect::<Vec<_>>(),
        [0, 2]
    );
    assert!(
        outcome.rejects[0]
            .detail
            .chars()
            .any(|c| c.is_ascii_digit()),
        "{}",
        outcome.rejects[0].detail
    );
}

/// Drops the centroids between two times after the command's rise.
fn drop_frames(truth: &Truth, samples: &mut Samples, from: f64, to: f64) {
    samples
        .centroids
        .retain(|sample| !(from..to).contains(&(time(sample) - truth.start)));
}

#[test]
fn frames_missing_around_impact_rest_or_within_the_slide() {
    rejected("frames_missing", |truth, samples| {
        drop_frames(truth, samples, IMPACT - 0.05, IMPACT + 0.05)
    });
    let rest = |truth: &Truth| IMPACT + truth.release / truth.deceleration;
    rejected("frames_missing", |truth, samples| {
        drop_frames(truth, samples, rest(truth) - 0.15, rest(truth) + 0.15)
    });
    rejected("frames_missing", |truth, samples| {
        drop_frames(truth, samples, 0.22, 0.5)
    });
    rejected("frames_missing", |truth, samples| {
        let mut at = 0;
        samples.centroids.retain(|sample| {
            at += 1;
            at % 4 == 0 || !(0.22..0.6).contains(&(time(sample) - truth.start))
        });
    });
    rejected("no_rest_before", |truth, samples| {
        drop_frames(truth, samples, -1.5, 0.0)
    });
}

#[test]
fn an_object_that_is_not_at_rest_before_or_after() {
    let slide = |samples: &mut Samples, from: f64, to: f64, speed: f64| {
        for sample in samples
            .centroids
            .iter_mut()
            .filter(|sample| (from..to).contains(&time(sample)))
        {
            sample.y += speed * (time(sample) - from);
        }
    };
    rejected("no_rest_before", |truth, samples| {
        slide(samples, truth.start - 1.5, truth.start, 0.05)
    });
    rejected("no_rest_after", |truth, samples| {
        slide(samples, truth.start + IMPACT, truth.start + 4.4, 0.03)
    });
}

#[test]
fn an_object_that_is_missed_does_not_move() {
    rejected("no_motion", |truth, samples| {
        for sample in samples.centroids.iter_mut() {
            if (0.0..4.4).contains(&(time(sample) - truth.start)) {
                (sample.x, sample.y) = (truth.initial.x, truth.initial.y);
            }
        }
    });
}

#[test]
fn centroids_that_are_no_places_on_the_table() {
    let replace = |x: f64| {
        move |truth: &Truth, samples: &mut Samples| {
            let at = samples
                .centroids
                .iter()
                .position(|s| time(s) > truth.start + 0.3)
                .expect("a frame");
            samples.centroids[at].x = x;
        }
    };
    rejected("off_table", replace(1.2));
    rejected("off_table", replace(-0.3));
}

#[test]
fn an_object_that_slides_off_the_table_is_kept_up_to_there_without_a_stop() {
    let outcome = with_fault(|truth, samples| {
        for sample in samples
            .centroids
            .iter_mut()
            .filter(|s| (0.2..4.4).contains(&(time(s) - truth.start)))
        {
            sample.y = truth.initial.y + 1.5 * (time(sample) - truth.start - 0.2);
        }
        drop_frames(truth, samples, 1.0, 4.4);
    });
    assert_eq!(outcome.rejects, []);
    let ends: Vec<End> = outcome
        .strikes
        .iter()
        .map(|strike| strike.track.end)
        .collect();
    assert_eq!(ends, [End::Rest, End::LeftView, End::Rest]);
    let track = &outcome.strikes[1].track;
    assert!(track.y.iter().all(|y| *y <= 0.6) && track.len() > 20);
}

/// From its impact on the second object does something else: its place along its way, in m, this long (s) after it, and its velocity, which
/// the object has to have for longer than it had.
fn moves_as(truth: &Truth, samples: &mut Samples, place: impl Fn(f64) -> f64) {
    for sample in &mut samples.centroids {
        let t = time(sample) - truth.start - IMPACT;
        if (0.0..4.0).contains(&t) {
            let until = t.min(truth.release / truth.deceleration);
            let gone = truth.release * until - 0.5 * truth.deceleration * until * until;
            let other = place(t) - gone;
            sample.x += other * truth.angle.cos();
            sample.y += other * truth.angle.sin();
        }
    }
}

/// A slide of 1.4 m/s.
fn slide(t: f64) -> f64 {
    1.4 * t - 1.25 * t * t
}

/// Checks that the second strike's track ends in a contact, within this time (s) before it.
#[track_caller]
fn ends_before(contact: f64, place: impl Fn(f64) -> f64) {
    let outcome = with_fault(|truth, samples| moves_as(truth, samples, &place));
    assert_eq!(outcome.rejects, []);
    let track = &outcome.strikes[1].track;
    assert_eq!(track.end, End::Contact, "{contact}");
    let last = *track.t.last().expect("frames");
    assert!(
        (contact - 0.06..contact + 0.01).contains(&last),
        "{contact} {last}"
    );
}

#[test]
fn an_object_that_a_hand_catches_has_no_stop_there() {
    // At 0.9 and 0.75 m/s.
    for caught in [0.2, 0.26] {
        ends_before(caught, |t| slide(t.min(caught)));
    }
    // At 0.9, 0.65 and 0.4 m/s; after a moment the hand carries it away, and lays it down.
    for caught in [0.2, 0.3, 0.4] {
        ends_before(caught, |t| {
            let carried = ((t - caught - 0.1) / 0.9).clamp(0.0, 1.0);
            slide(t.min(caught)) + 0.25 * carried * carried * (3.0 - 2.0 * carried)
        });
    }
}

#[test]
fn an_object_that_something_turns_round_has_no_stop_after_that() {
    // It comes back at half its speed, from something that stands at no line.
    let (met, back) = (0.2, 0.4);
    ends_before(met, |t| {
        let s = (t - met).clamp(0.0, back / 2.5);
        slide(t.min(met)) - back * s + 1.25 * s * s
    });
}

#[test]
fn an_object_that_rests_at_a_fence_has_touched_it() {
    let truths = truths(3);
    let truth = truths[1];
    let mut rig = crate::common::rig();
    // Its edge stops a millimetre before it.
    let middle = truth.stop() + Point::polar(rig.object.solid.reach() + 0.001, truth.angle);
    let along = Point::polar(0.02, truth.angle + std::f64::consts::FRAC_PI_2);
    rig.table.fences.push(Fence {
        from: middle - along,
        to: middle + along,
    });
    let folder = Folder::new();
    let log = folder.write("session.mcap", &session(&truths));
    let read = ingest::ingest_log(&log, &rig, &ingest::Ingest::default()).expect("reads");
    let ends: Vec<End> = read.strikes.iter().map(|s| s.track.end).collect();
    assert_eq!(ends[..2], [End::Rest, End::Contact]);
}

#[test]
fn frames_in_which_the_tracker_saw_nothing_are_left_out_and_counted() {
    let truths = truths(6);
    for lost in [f64::NAN, f64::INFINITY, 0.0] {
        let mut samples = session(&truths);
        let whole = ingest_samples(&samples);
        let mut count = 0;
        // One frame in 37, and bursts of five that take a fifth of the slides.
        for (i, sample) in samples.centroids.iter_mut().enumerate() {
            if i % 37 == 5 || i % 25 > 20 && (0.3..1.0).contains(&((time(sample) - 2.0) % 6.0)) {
                (sample.x, sample.y) = (lost, lost);
                count += 1;
            }
        }
        let outcome = ingest_samples(&samples);
        assert_eq!(outcome.rejects, []);
        assert_eq!(outcome.seen.lost, count);
        noted(&outcome, "frames are lost");
        for (strike, whole) in outcome.strikes.iter().zip(&whole.strikes) {
            assert!(strike.stop.distance(whole.stop) < 1e-3);
            assert!(strike.initial.distance(whole.initial) < 1e-3);
        }
    }
}

#[test]
fn commands_that_are_no_number_between_others_are_left_out_and_counted() {
    let mut samples = session(&truths(6));
    let whole = ingest_samples(&samples);
    let commands = samples.commands.iter_mut().enumerate();
    // At rest, on ramps and on plateaus; the last of all, too.
    let wrong = commands.filter(|(i, _)| i % 31 == 5);
    let count = wrong.map(|(_, s)| (s.x, s.y) = (f64::NAN, 0.0)).count();
    let outcome = ingest_samples(&samples);
    assert_eq!(outcome.rejects, []);
    noted(
        &outcome,
        &format!("{count} commands between others are no number"),
    );
    for (one, other) in outcome.strikes.iter().zip(&whole.strikes) {
        assert!((one.command.speed - other.command.speed).abs() < 1e-9);
        assert_eq!(one.track, other.track);
    }
    assert_eq!(outcome.strikes.len(), whole.strikes.len());
}

#[test]
fn the_arms_slow_ways_back_are_no_strikes_and_none_is_rejected() {
    let truths = truths(6);
    let mut samples = session(&truths);
    let whole = ingest_samples(&samples);
    let slow = 0.4 * crate::common::rig().robot.speed.low;
    for truth in &truths {
        let back = Point::polar(-slow, truth.angle);
        for command in samples.commands.iter_mut() {
            if (0.6..1.6).contains(&(time(command) - truth.start)) {
                (command.x, command.y) = (back.x, back.y);
            }
        }
    }
    let outcome = ingest_samples(&samples);
    assert_eq!(outcome.rejects, []);
    noted(&outcome, "6 commands slower than any strike");
    assert_eq!(outcome.seen.commands.len(), 6);
    let tracks = |outcome: &LogOutcome| -> Vec<_> {
        let strikes = outcome.strikes.iter();
        strikes.map(|strike| strike.track.clone()).collect()
    };
    assert_eq!(tracks(&outcome), tracks(&whole));
}

#[test]
fn commands_that_are_no_strikes() {
    let at_plateau =
        |truth: &Truth, sample: &Stamped| (0.15..0.25).contains(&(time(sample) - truth.start));
    rejected("not_finite", |truth, samples| {
        let commands = samples.commands.iter_mut();
        commands
            .filter(|s| at_plateau(truth, s))
            .for_each(|s| s.y = f64::NAN);
    });
    rejected("no_plateau", |truth, samples| {
        for sample in samples
            .commands
            .iter_mut()
            .filter(|s| (0.0..0.4).contains(&(time(s) - truth.start)))
        {
            let factor = 1.0 - (time(sample) - truth.start - 0.2).abs() / 0.2;
            (sample.x, sample.y) = (0.8 * factor, 0.0);
        }
    });
}

#[test]
fn units_that_are_others() {
    let millimetres = |samples: &mut [Stamped]| {
        for sample in samples {
            (sample.x, sample.y) = (sample.x * 1e3, sample.y * 1e3);
        }
    };
    for fault in [0, 1] {
        let mut samples = session(&truths(3));
        millimetres(if fault == 0 {
            &mut samples.centroids
        } else {
            &mut samples.commands
        });
        let outcome = ingest_samples(&samples);
        let reason = "units_implausible";
        assert_eq!(
            reasons(&outcome.rejects),
            [(0, reason), (1, reason), (2, reason)],
            "{:?}",
            outcome.rejects
        );
        assert!(
            outcome.rejects[0].detail.contains("mm"),
            "{}",
            outcome.rejects[0].detail
        );
    }
}

#[test]
fn clocks_that_do_not_agree() {
    for skew in [-2_000_000_000_i64, -400_000_000, 1_200_000_000] {
        let mut samples = session(&truths(3));
        for sample in &mut samples.centroids {
            sample.stamp = sample.stamp.saturating_add_signed(skew);
        }
        let outcome = ingest_samples(&samples);
        assert_eq!(outcome.strikes, [], "{skew}");
        assert_eq!(outcome.rejects.len(), 3);
        let names = |reason: &str| {
            outcome
                .rejects
                .iter()
                .filter(|reject| reject.reason.name() == reason)
                .count()
        };
        // The last one's motion may lie beyond the log's end.
        assert!(names("clock_skew") >= 2, "{skew} {:?}", outcome.rejects);
    }
}

#[test]
fn a_clock_that_is_set_back() {
    let all = session(&truths(3));
    // During the slide of the second strike, and while nothing happens before it: everything after lies 3 s before.
    for (at, lost) in [
        (truths(3)[1].start + 0.5, Some(1)),
        (truths(3)[1].start - 2.0, None),
    ] {
        let split = |samples: &[Stamped], late: bool| -> Vec<Stamped> {
            samples
                .iter()
                .filter(|s| (time(s) >= at) == late)
                .map(|s| Stamped {
                    stamp: s.stamp - if late { 3_000_000_000 } else { 0 },
                    ..*s
                })
                .collect()
        };
        let half = |late| Samples {
            centroids: split(&all.centroids, late),
            commands: split(&all.commands, late),
            states: Vec::new(),
        };
        let folder = Folder::new();
        let outcome = ingest(&folder.write_parts("a.mcap", &[&half(false), &half(true)]));
        let expected: Vec<_> = lost
            .into_iter()
            .map(|index| (index, "clock_backwards"))
            .collect();
        assert_eq!(reasons(&outcome.rejects), expected, "{:?}", outcome.rejects);
        assert_eq!(outcome.strikes.len() + outcome.rejects.len(), 3);
    }
}

#[test]
fn stamps_that_are_all_zero() {
    for (centroids, commands) in [(true, true), (true, false), (false, true)] {
        let all = session(&truths(2));
        let folder = Folder::new();
        // In order of receipt, a tenth of a second at a time.
        let parts: Vec<Samples> = (0..120)
            .map(|i| {
                let within = |s: &&Stamped| (i..i + 1).contains(&((time(s) * 10.0) as i32));
                let zeroed = |samples: &[Stamped], zero: bool| -> Vec<Stamped> {
                    let zero = |s: &Stamped| Stamped {
                        stamp: if zero { 0 } else { s.stamp },
                        ..*s
                    };
                    samples.iter().filter(within).map(zero).collect()
                };
                Samples {
                    centroids: zeroed(&all.centroids, centroids),
                    commands: zeroed(&all.commands, commands),
                    states: Vec::new(),
                }
            })
            .collect();
        let outcome = ingest(&folder.write_parts("a.mcap", &parts.iter().collect::<Vec<_>>()));
        assert_eq!(outcome.strikes, []);
        assert!(!outcome.rejects.is_empty());
        let all_clock = outcome
            .rejects
            .iter()
            .all(|reject| reject.reason.name() == "clock_backwards");
        assert!(all_clock, "{centroids} {commands} {:?}", outcome.rejects);
    }
}

#[test]
fn a_log_that_ends_before_the_object_rests() {
    let truths = truths(2);
    let mut samples = session(&truths);
    let end = EPOCH + ((truths[1].start + 0.35) * 1e9) as u64;
    samples.centroids.retain(|sample| sample.stamp < end);
    samples.commands.retain(|sample| sample.stamp < end);
    let outcome = ingest_samples(&samples);
    assert_eq!(reasons(&outcome.rejects), [(1, "no_rest_after")]);
    assert_eq!(outcome.strikes.len(), 1);
}

#[test]
fn a_log_without_strikes_is_no_fault() {
    let outcome = ingest_samples(&session(&[]));
    assert_eq!((outcome.strikes.len(), outcome.rejects.len()), (0, 0));
    assert!(outcome.messages > 100);
}
