//! From logs to strikes: what was really done is what is measured, once, in any file.

use crate::common::{
    EPOCH, Folder, IMPACT, Truth, ingest, ingest_samples, json_log, noted, point, session, time,
    truths, twist,
};
use ingest::{Ingest, LogFile, LogOutcome, StrikeSummary, assemble};
use logs::write::{Samples, Stamped};
use stage::ListStage;
use values::{End, Point, split_of};

#[test]
fn strikes_are_measured_as_they_were_made() {
    let truths = truths(12);
    let outcome = ingest_samples(&session(&truths));
    assert_eq!(outcome.rejects, []);
    assert!(
        outcome.whole && outcome.notes.is_empty(),
        "{:?}",
        outcome.notes
    );
    assert_eq!(outcome.strikes.len(), truths.len());
    for (strike, truth) in outcome.strikes.iter().zip(&truths) {
        assert!((strike.command.speed - truth.speed).abs() < 1e-9);
        assert!((strike.command.angle - truth.angle).abs() < 1e-9);
        // Noise of 0.7 mm, averaged over the frames of a rest.
        assert!(
            strike.initial.distance(truth.initial) < 0.0007,
            "{:?} {truth:?}",
            strike.initial
        );
        assert!(
            strike.stop.distance(truth.stop()) < 0.0009,
            "{:?} {:?}",
            strike.stop,
            truth.stop()
        );
        // The impact lies within one frame before the track's zero (two where one was dropped).
        let impact = EPOCH as f64 * 1e-9 + truth.start + IMPACT;
        let late = strike.t_start - impact;
        assert!((-0.004..2.2 / 60.0).contains(&late), "{late}");
        let rest = truth.release / truth.deceleration;
        let end = strike.track.t.last().copied().unwrap_or_default();
        assert!((rest - 0.1..rest + 0.15).contains(&end), "{end} {rest}");
        assert!(
            strike.track.len() as f64 > 0.85 * end * 60.0,
            "{}",
            strike.track.len()
        );
        assert_eq!(strike.split, split_of(&strike.id, 1));
        assert_eq!(
            (strike.log.as_str(), strike.conditions.session.as_str()),
            ("session.mcap", "session.mcap")
        );
    }
    let impacts: Vec<f64> = outcome
        .strikes
        .iter()
        .zip(&truths)
        .map(|(strike, truth)| strike.t_start - (EPOCH as f64 * 1e-9 + truth.start + IMPACT))
        .collect();
    let within = impacts
        .iter()
        .filter(|late| (-0.001..0.0185).contains(*late))
        .count();
    assert!(within >= impacts.len() - 2, "{impacts:?}");
}

#[test]
fn frames_that_jump_away_change_nothing_and_are_reported() {
    let truths = truths(3);
    let mut samples = session(&truths);
    let clean = ingest_samples(&samples);
    let during: Vec<usize> = (0..samples.centroids.len())
        .filter(|i| {
            let t = (samples.centroids[*i].stamp - EPOCH) as f64 * 1e-9;
            truths
                .iter()
                .any(|truth| (truth.start + 0.25..truth.start + 0.45).contains(&t))
        })
        .collect();
    for i in during.iter().step_by(5) {
        samples.centroids[*i].y += 0.08;
    }
    let outcome = ingest_samples(&samples);
    assert_eq!(outcome.strikes.len(), 3, "{:?}", outcome.rejects);
    for (strike, clean) in outcome.strikes.iter().zip(&clean.strikes) {
        assert!(
            strike.stop.distance(clean.stop) < 1e-4
                && strike.initial.distance(clean.initial) < 1e-4
        );
        assert!(strike.track.len() < clean.track.len());
        assert!(
            strike
                .track
                .y
                .windows(2)
                .all(|pair| (pair[1] - pair[0]).abs() < 0.04)
        );
    }
    noted(&outcome, "jump away");
}

/// A session's messages as a second log: JSON, one topic after the other where `topics_apart`, received an hour later.
fn as_json(samples: &Samples, topics_apart: bool) -> Vec<u8> {
    let mut messages: Vec<_> = samples.centroids.iter().map(point).collect();
    messages.extend(samples.commands.iter().map(twist));
    if !topics_apart {
        messages.sort_by_key(|(_, stamp, _)| *stamp);
    }
    json_log(&messages, 3_600_000_000_000)
}

/// The part of a session between two times.
fn part(samples: &Samples, from: f64, to: f64) -> Samples {
    let within = |s: &&Stamped| (from..to).contains(&time(s));
    Samples {
        centroids: samples.centroids.iter().filter(within).copied().collect(),
        commands: samples.commands.iter().filter(within).copied().collect(),
        states: Vec::new(),
    }
}

#[test]
fn a_strike_is_one_row_whatever_files_hold_it() {
    let samples = session(&truths(6));
    let folder = Folder::new();
    let original = ingest(&folder.write("b.mcap", &samples));
    let mut copies: Vec<LogOutcome> = vec![original.clone()];
    for (name, topics_apart) in [("c.mcap", false), ("d.mcap", true)] {
        let path = folder.path(name);
        std::fs::write(&path, as_json(&samples, topics_apart)).expect("writes");
        copies.push(ingest(&path));
    }
    // Splits that overlap: strikes 0 to 3, and 2 to 5, the first of them with little rest before.
    copies.push(ingest(&folder.write("a0.mcap", &part(&samples, 0.0, 24.0))));
    copies.push(ingest(
        &folder.write("a1.mcap", &part(&samples, 13.4, 99.0)),
    ));
    assert_eq!(
        copies
            .iter()
            .map(|copy| copy.strikes.len())
            .collect::<Vec<_>>(),
        [6, 6, 6, 4, 4]
    );

    let (strikes, rejects) = assemble(copies.clone());
    let ids = |strikes: &[values::Strike]| {
        strikes
            .iter()
            .map(|strike| strike.id.clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(ids(&strikes), ids(&original.strikes));
    assert_eq!(rejects.len(), 20);
    assert!(
        rejects
            .iter()
            .all(|reject| reject.reason == values::RejectReason::Duplicate)
    );
    assert_eq!(
        strikes
            .iter()
            .map(|s| s.conditions.order as u32)
            .collect::<Vec<_>>(),
        [0, 1, 2, 3, 4, 5]
    );
    // Strikes differ from each other.
    let distinct: std::collections::BTreeSet<_> = ids(&strikes).into_iter().collect();
    assert_eq!(distinct.len(), 6);

    copies.reverse();
    assert_eq!(
        assemble(copies),
        (strikes, rejects),
        "whatever the order of the logs"
    );
}

#[test]
fn the_stage_answers_by_content_and_reports_a_log_that_changed() {
    let folder = Folder::new();
    let path = folder.write("a.mcap", &session(&truths(2)));
    let log = LogFile::open(&path).expect("hashes");
    let mut kept = Vec::new();
    let mut run = || {
        Ingest { seed: 1 }.run_item(&crate::common::rig(), &log, &mut |strike| kept.push(strike))
    };
    let answer = run().expect("ingests");
    assert_eq!(answer.sha256, log.sha256);
    folder.write("a.mcap", &session(&truths(3)));
    // No answer: one would be kept for the bytes that were hashed, and found when they are back.
    let changed = run().expect_err("no answer");
    assert!(changed.to_string().contains("changes"), "{changed}");
    std::fs::write(&path, "no log at all").expect("writes");
    let changed = run().expect_err("no answer");
    assert!(changed.to_string().contains("changes"), "{changed}");
    // What never was a log is answered as one that is left out.
    let other = LogFile::open(&path).expect("hashes");
    let outcome = Ingest { seed: 1 }.run_item(&crate::common::rig(), &other, &mut |_| ());
    assert!(outcome.expect("answers").left_out.is_some());

    kept.truncate(2);
    assert_eq!(
        answer.strikes,
        kept.iter().map(StrikeSummary::from).collect::<Vec<_>>()
    );
}

#[test]
fn a_stamp_that_no_message_has_is_reported_and_the_log_time_taken() {
    let folder = Folder::new();
    let path = folder.path("a.mcap");
    std::fs::write(&path, as_json(&session(&truths(2)), false)).expect("writes");
    let mut rig = crate::common::rig();
    rig.topics.command.stamp = "header.time".into();
    rig.topics.centroid.stamp = "header.time".into();
    let outcome = ingest::ingest_log(&path, &rig, &Ingest::default()).expect("the log is read");
    assert_eq!(outcome.strikes.len(), 2);
    for topic in ["/object/centroid", "/striker/command"] {
        let note = format!("{topic} has no `header.time`: log times were taken");
        crate::common::noted(&outcome, &note);
    }
}

#[test]
fn topics_that_are_not_there_are_named() {
    let folder = Folder::new();
    let path = folder.write("a.mcap", &session(&truths(1)));
    let mut rig = crate::common::rig();
    rig.topics.centroid.name = "/puck".into();
    let error = ingest::ingest_log(&path, &rig, &Ingest::default())
        .expect_err("refused")
        .to_string();
    assert!(
        error.contains("/puck") && error.contains("/object/centroid"),
        "{error}"
    );
}

#[test]
fn what_is_pushed_on_while_it_rests_for_a_moment_is_no_stop() {
    let truths = truths(6);
    let slides = |truth: &Truth| truth.release / truth.deceleration;
    // After so short a rest a hand pushes it aside for 0.4 s.
    for pause in [0.06, 0.12] {
        let mut samples = session(&truths);
        for sample in &mut samples.centroids {
            let t = time(sample);
            let struck = truths.iter().rev().find(|truth| truth.start <= t);
            let Some(truth) = struck.filter(|truth| t < truth.start + 4.0) else {
                continue;
            };
            let pushed = truth.start + IMPACT + slides(truth) + pause;
            let aside = Point::polar(0.3 * (t - pushed).clamp(0.0, 0.4), truth.angle + 1.5);
            (sample.x, sample.y) = (sample.x + aside.x, sample.y + aside.y);
        }
        let outcome = ingest_samples(&samples);
        assert_eq!(outcome.strikes.len(), truths.len(), "{:?}", outcome.rejects);
        for (strike, truth) in outcome.strikes.iter().zip(&truths) {
            assert_eq!(strike.track.end, End::Contact, "{pause}: {strike:?}");
            let until = strike.track.t.last().copied().unwrap_or_default();
            let pushed = slides(truth) + pause;
            assert!(until < pushed + 0.05, "{until} {pushed}");
        }
    }
    let outcome = ingest_samples(&session(&truths));
    assert!(
        outcome
            .strikes
            .iter()
            .all(|strike| strike.track.end == End::Rest)
    );
}
