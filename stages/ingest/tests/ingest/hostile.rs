//! What cameras, controllers and recorders do that no specification says: each strike is measured all the same, or rejected with
//! a reason.

use crate::common::{EPOCH, Truth, ingest_samples, noise, reasons, session, time, truths};
use ingest::LogOutcome;
use logs::write::{Samples, Stamped};
use values::Point;

fn at(t: f64, x: f64, y: f64) -> Stamped {
    Stamped::at(EPOCH + (t * 1e9).round() as u64, Point::new(x, y))
}

/// Every strike is kept and measured as it was made, within a few deviations of the camera's noise and `slack` in speed (a part).
#[track_caller]
fn kept(outcome: &LogOutcome, truths: &[Truth], slack: f64) {
    assert_eq!(outcome.strikes.len(), truths.len(), "{:?}", outcome.rejects);
    for (strike, truth) in outcome.strikes.iter().zip(truths) {
        assert!(
            (strike.command.speed / truth.speed - 1.0).abs() <= slack,
            "{} {truth:?}",
            strike.command.speed
        );
        assert!((strike.command.angle - truth.angle).abs() < 1e-6 + slack);
        let (begins, ends) = (
            strike.initial.distance(truth.initial),
            strike.stop.distance(truth.stop()),
        );
        assert!(begins < 0.001 && ends < 0.0015, "{begins} {ends} {truth:?}");
    }
}

/// The session as a camera at another rate sees it, with frames that come up to half a period late, and some dropped.
fn seen_at(truths: &[Truth], rate: f64) -> Samples {
    let mut samples = session(truths);
    let end = samples.centroids.last().map_or(0.0, time);
    samples.centroids = (0..(end * rate) as u64)
        .filter(|i| i % 23 != 5)
        .map(|i| {
            let t = (i as f64 + 0.5 * (i as f64 * 0.7).sin().abs()) / rate;
            let place = crate::common::place(truths, t);
            at(
                t,
                place.x + 0.0007 * noise(2 * i),
                place.y + 0.0007 * noise(2 * i + 1),
            )
        })
        .collect();
    samples
}

#[test]
fn cameras_from_30_to_240_hz_with_jitter_and_dropped_frames() {
    let truths = truths(6);
    for rate in [30.0, 50.0, 60.0, 120.0, 240.0] {
        let outcome = ingest_samples(&seen_at(&truths, rate));
        kept(&outcome, &truths, 1e-9);
        let is_noted = outcome
            .notes
            .iter()
            .any(|note| note.contains("camera.rate = 60"));
        assert_eq!(is_noted, rate != 60.0, "{rate}: {:?}", outcome.notes);
    }
}

#[test]
fn stamps_that_are_late_by_half_a_period_and_bunch_lose_no_strike() {
    let (truths, rate) = (truths(20), 60.0);
    let mut samples = session(&truths);
    let end = samples.centroids.last().map_or(0.0, time);
    let mut last = 0.0f64;
    samples.centroids = (0..(end * rate) as u64)
        .map(|i| {
            let t = i as f64 / rate;
            // By up to 24 ms; frames keep their order.
            let late = -0.008 * (0.5 + 0.28 * noise(7 * i + 3)).clamp(0.05, 1.0).ln();
            last = (t + late).max(last + 2e-5);
            let place = crate::common::place(&truths, t);
            at(
                last,
                place.x + 0.0007 * noise(2 * i),
                place.y + 0.0007 * noise(2 * i + 1),
            )
        })
        .collect();
    let outcome = ingest_samples(&samples);
    assert_eq!(outcome.strikes.len(), truths.len(), "{:?}", outcome.rejects);
}

#[test]
fn a_camera_that_shows_no_slide_is_reported_as_one() {
    let outcome = ingest_samples(&seen_at(&truths(2), 8.0));
    assert_eq!(
        reasons(&outcome.rejects),
        [(0, "frames_missing"), (1, "frames_missing")]
    );
    assert!(outcome.rejects[0].detail.contains("camera.rate = 60"));
}

#[test]
fn commands_come_at_20_to_1000_hz() {
    let truths = truths(5);
    for rate in [20.0, 50.0, 100.0, 500.0, 1000.0] {
        let mut samples = session(&truths);
        let end = samples.commands.last().map_or(0.0, time);
        samples.commands = (0..(end * rate) as u64)
            .map(|i| {
                let t = i as f64 / rate;
                let velocity = crate::common::velocity(&truths, t);
                at(t, velocity.x, velocity.y)
            })
            .collect();
        kept(&ingest_samples(&samples), &truths, 1e-9);
    }
}

#[test]
fn a_plateau_that_ripples_is_known_by_its_middle() {
    let truths = truths(5);
    let mut samples = session(&truths);
    for (i, command) in samples.commands.iter_mut().enumerate() {
        let factor = 1.0 + 0.02 * (i as f64 * 1.3).sin();
        (command.x, command.y) = (command.x * factor, command.y * factor);
    }
    kept(&ingest_samples(&samples), &truths, 0.006);
}

#[test]
fn an_arm_that_goes_back_while_the_object_slides_cuts_no_slide() {
    let truths = truths(4);
    // At once or after a pause, slower than it struck or faster.
    for (pause, speed) in [(0.0, 0.25), (0.0, 0.95), (0.15, 0.3), (0.15, 0.95)] {
        let mut samples = session(&truths);
        for command in &mut samples.commands {
            let t = time(command);
            for truth in &truths {
                if (0.4 + pause..0.8 + pause).contains(&(t - truth.start)) {
                    let back = Point::polar(speed, truth.angle + 3.1);
                    (command.x, command.y) = (back.x, back.y);
                }
            }
        }
        let outcome = ingest_samples(&samples);
        kept(&outcome, &truths, 1e-9);
        // The ways back are seen, and are no strikes; those slower than any strike are not even rejected.
        let is_slow = speed < crate::common::rig().robot.speed.low;
        let rejected = if is_slow { 0 } else { truths.len() };
        assert_eq!(outcome.rejects.len(), rejected);
        for reject in &outcome.rejects {
            let reason = reject.reason.name();
            assert!(
                ["no_rest_before", "no_motion", "clock_skew"].contains(&reason),
                "{reject:?}"
            );
        }
    }
}

#[test]
fn brief_blips_of_the_command_cut_no_slide_and_are_no_strikes() {
    let truths = truths(4);
    let mut samples = session(&truths);
    for truth in &truths {
        for after in [-0.6, 0.55, 0.8] {
            let blip = samples
                .commands
                .iter_mut()
                .find(|command| time(command) >= truth.start + after)
                .expect("a command");
            (blip.x, blip.y) = (0.3, 0.0);
        }
    }
    let outcome = ingest_samples(&samples);
    kept(&outcome, &truths, 1e-9);
    assert_eq!(outcome.rejects.len(), 12, "{:?}", outcome.rejects);
    assert!(
        outcome
            .rejects
            .iter()
            .all(|reject| reject.reason.name() == "no_plateau")
    );
}

#[test]
fn an_object_that_is_struck_again_before_it_rests_keeps_neither_strike() {
    let mut truths = truths(3);
    // Struck again 0.35 s after the first command's fall, while it slides.
    (truths[0].release, truths[0].deceleration) = (0.8, 0.8);
    truths[1].start = truths[0].start + 0.75;
    let first = truths[0];
    let mut samples = session(&truths);
    let moving = |t: f64| {
        let before = crate::common::place(&[first], t.min(truths[1].start + crate::common::IMPACT));
        let since = (t - truths[1].start - crate::common::IMPACT).max(0.0);
        before + Point::polar(0.3 * since.min(0.5), truths[1].angle)
    };
    for centroid in &mut samples.centroids {
        let t = time(centroid);
        if t < truths[2].start - 1.5 {
            let place = moving(t);
            (centroid.x, centroid.y) = (place.x, place.y);
        }
    }
    let outcome = ingest_samples(&samples);
    assert_eq!(outcome.strikes.len(), 1, "{:?}", outcome.strikes);
    assert_eq!(outcome.strikes[0].index, 2);
    let [first, second] = &outcome.rejects[..] else {
        panic!("{:?}", outcome.rejects);
    };
    assert_eq!(first.reason.name(), "no_rest_after");
    // From its own centroids alone it cannot be distinguished from one whose clock is late.
    assert!(["no_rest_before", "clock_skew"].contains(&second.reason.name()));
}

#[test]
fn a_hand_that_puts_the_object_back_is_no_part_of_a_strike() {
    let truths = truths(3);
    let mut samples = session(&truths);
    for truth in &truths {
        let rests = truth.start + crate::common::IMPACT + truth.release / truth.deceleration;
        // Half a second after it rests, a hand carries it back within a second and drops it there.
        for centroid in &mut samples.centroids {
            let since = time(centroid) - rests - 0.5;
            if (0.0..2.0).contains(&since) {
                let part = since.min(1.0);
                let place = truth.stop() * (1.0 - part) + truth.initial * part;
                (centroid.x, centroid.y) = (place.x, place.y);
            }
        }
    }
    kept(&ingest_samples(&samples), &truths, 1e-9);
}
