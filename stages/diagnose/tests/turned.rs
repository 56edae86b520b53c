//! A box that is put down turned, otherwise before each strike: a yaw that is tracked is no scatter and no gap.

use diagnose::{Diagnose, Diagnosed, Input, Verdict};
use ingest::{Ingest, assemble, ingest_log};
use rig::{Hidden, Hide, demo};
use stage::{Progress, Stage};
use values::{Rig, Shape, Strike};
use world::{Scatter, World};

/// Strikes of a demo whose box is put down by eye, or straight, as a tracker of poses sees them.
fn strikes(noise: &str) -> (Rig, Vec<Strike>) {
    let folder = tempfile::tempdir().expect("a folder");
    let mut settings = demo::Settings::new(Shape::Box, 120, 12, Some(Hidden::none()));
    settings.truth.noise = Hide::parse(&[noise]).expect("a noise").noise;
    settings.log_pose = true;
    let written = demo::write(&settings, folder.path()).expect("writes");
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
    };
    let fit = sysid::Sysid::default()
        .run(&identify, &Progress::hidden())
        .expect("identifies");
    let input = Input {
        rig: rig.clone(),
        world: fit.world.clone(),
        strikes,
    };
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
