//! A box that is put down turned, otherwise before each strike: a yaw that is tracked is no scatter and no gap.

use diagnose::{Diagnose, Diagnosed, Input, Verdict};
use ingest::{Ingest, assemble, ingest_log};
use rig::{Hidden, Hide, PlannedStrike, demo};
use stage::{Progress, Stage};
use values::{Point, Rig, Shape, Strike};
use world::{Scatter, World};

/// Strikes of a demo whose box is put down by eye, or straight, as a tracker of poses sees them.
fn strikes(noise: &str) -> (Rig, Vec<Strike>) {
    let mut settings = demo::Settings::new(Shape::Box, 120, 12, Some(Hidden::none()));
    settings.truth.noise = Hide::parse(&[noise]).expect("a noise").noise;
    settings.log_pose = true;
    ingested(&settings)
}

fn ingested(settings: &demo::Settings) -> (Rig, Vec<Strike>) {
    let folder = tempfile::tempdir().expect("a folder");
    let written = demo::write(settings, folder.path()).expect("writes");
    let rig = Rig::load(&written.rig).expect("the rig file is accepted");
    let read = |log| ingest_log(log, &rig, &Ingest::default()).expect("the log is read");
    let (strikes, _) = assemble(written.logs.iter().map(|log| read(log)).collect());
    (rig, strikes)
}

/// The scatter as identified, and the diagnosis.
fn found(rig: &Rig, strikes: Vec<Strike>) -> (Scatter, Diagnosed) {
    let identify = sysid::Input {
        rig: rig.clone(),
        world: World::nominal(),
        strikes: strikes.clone(),
        later: Vec::new(),
    };
    let fit = sysid::Sysid::default()
        .run(&identify, &Progress::hidden())
        .expect("identifies");
    let input = Input::of(rig.clone(), fit.world.clone(), strikes);
    let diagnosed = Diagnose::default().run(&input, &Progress::hidden());
    (fit.world.scatter, diagnosed.expect("diagnoses"))
}

#[test]
fn a_yaw_that_is_tracked_is_no_scatter_and_no_gap() {
    let (rig, put_straight) = strikes("none");
    let (_, put_by_eye) = strikes("yaw_scatter");
    let (straight, _) = found(&rig, put_straight);
    let (used, diagnosed) = found(&rig, put_by_eye.clone());
    let mut untracked = put_by_eye;
    for strike in &mut untracked {
        strike.conditions.yaw = None;
    }
    let (ignored, _) = found(&rig, untracked);
    let degrees = |scatter: Scatter| scatter.angle.to_degrees();
    println!(
        "scatter of the angle: put straight {:.3}°, tracked {:.3}°, untracked {:.3}°",
        degrees(straight),
        degrees(used),
        degrees(ignored)
    );
    assert!(used.angle < 1.2 * straight.angle, "{used:?} {straight:?}");
    assert!(ignored.angle > 1.5 * straight.angle, "{ignored:?}");
    let diagnosis = &diagnosed.diagnosis;
    assert_eq!(
        diagnosis.verdict,
        Verdict::Consistent,
        "{}",
        diagnosis.summary
    );
    let notes = diagnosis.notes.join("\n");
    assert!(notes.contains("poses show the box turned"), "{notes}");
}

#[test]
fn a_box_that_is_turned_to_face_each_strike_is_told_as_such() {
    // Struck straight on, then each strike turned about where it began, with its command: a box that was laid to face it.
    let mut settings = demo::Settings::new(Shape::Box, 80, 14, Some(Hidden::none()));
    let mut turns: Vec<f64> = Vec::new();
    let plan = (0..80).map(|i| {
        let part = |of: i32| f64::from(i % of) / f64::from(of - 1);
        turns.push(-0.45 + 0.9 * part(9));
        PlannedStrike {
            x0: 0.27 + 0.08 * part(5),
            y0: -0.06 + 0.12 * part(7),
            speed: 0.5 + 0.45 * part(4),
            angle: 0.0,
        }
    });
    settings.plan = Some(plan.collect());
    let (rig, mut facing) = ingested(&settings);
    for (strike, turn) in facing.iter_mut().zip(&turns) {
        let from = strike.initial;
        let turned = |point: Point| from + (point - from).rotated(*turn);
        strike.command.angle += turn;
        strike.stop = turned(strike.stop);
        for frame in 0..strike.track.len() {
            let point = turned(strike.track.point(frame));
            (strike.track.x[frame], strike.track.y[frame]) = (point.x, point.y);
        }
    }
    let is_told = |rig: &Rig, strikes: Vec<Strike>| {
        let (_, diagnosed) = found(rig, strikes);
        let diagnosis = diagnosed.diagnosis;
        let said = [diagnosis.summary.to_string(), diagnosis.notes.join("\n")].concat();
        said.contains("turned to face each strike")
    };
    assert!(is_told(&rig, facing));
    // A box that lies square, whether a tracker says so or not.
    let (rig, mut square) = strikes("none");
    for strike in &mut square {
        strike.conditions.yaw = None;
    }
    assert!(!is_told(&rig, square));
}
