//! A rig file whose sizes of a box are wrong: launch angles that are off by a share are told, and are no effect of the arm.

use diagnose::{Diagnose, Diagnosis, Input, Verdict};
use ingest::{Ingest, assemble, ingest_log};
use rig::{Hidden, demo};
use stage::{Progress, Stage};
use values::{Rig, Shape};
use world::World;

/// The diagnosis of a demo's strikes of a box, with a rig file whose half side and tip's radius are wrong by these factors.
fn diagnosed(hidden: &str, half_side: f64, radius: f64, seed: u64) -> Diagnosis {
    let folder = tempfile::tempdir().expect("a folder");
    let hidden = Hidden::parse(&[hidden]).expect("effects");
    let settings = demo::Settings::new(Shape::Box, 120, seed, Some(hidden));
    let written = demo::write(&settings, folder.path()).expect("writes");
    let mut rig = Rig::load(&written.rig).expect("the rig file is accepted");
    rig.object.solid = rig.object.solid.scaled(half_side);
    rig.striker.radius *= radius;
    let read = |log| ingest_log(log, &rig, &Ingest::default()).expect("the log is read");
    let (strikes, _) = assemble(written.logs.iter().map(|log| read(log)).collect());
    let world = World::nominal();
    let world = world.with("friction", 0.2).with("restitution", 0.45);
    let input = Input::of(rig, world, strikes);
    let found = Diagnose::default().run(&input, &Progress::hidden());
    found.expect("a diagnosis").diagnosis
}

fn says_so(found: &Diagnosis) -> bool {
    let mut notes = found.notes.iter();
    notes.any(|note| note.contains("measure both sizes"))
}

#[test]
fn sizes_that_are_wrong_are_told_and_are_no_effect_of_the_arm() {
    for (half_side, radius, seed) in [(0.9, 1.1, 61), (1.1, 0.9, 62)] {
        let found = diagnosed("none", half_side, radius, seed);
        assert_eq!(found.verdict, Verdict::Consistent, "{}", found.summary);
        assert!(says_so(&found), "{:?}", found.notes);
    }
}

#[test]
fn sizes_that_are_right_are_not_doubted() {
    let found = diagnosed("none", 1.0, 1.0, 63);
    assert_eq!(found.verdict, Verdict::Consistent, "{}", found.summary);
    assert!(!says_so(&found), "{:?}", found.notes);
}

#[test]
fn an_arm_whose_angles_are_off_by_more_than_sizes_are_is_named() {
    for (half_side, radius, seed) in [(1.0, 1.0, 64), (0.9, 1.1, 65), (1.1, 0.9, 66)] {
        let found = diagnosed("striker_angle_error=gain:0.2", half_side, radius, seed);
        let names: Vec<&str> = found.effects.iter().map(|e| e.name.as_str()).collect();
        assert_eq!(names, ["striker_angle_error"], "{}", found.summary);
        assert!(says_so(&found), "{:?}", found.notes);
    }
}
