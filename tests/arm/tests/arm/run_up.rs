//! An object that is moved while the tip runs up to it is not struck; one that lies still is.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::Duration;

use arm::{Emulator, Maker, Table, connect_to};
use ingest::{Ingest, ingest_log};
use strike::arm::Arm;
use strike::ur::Ur;
use strike::xarm::XArm;
use strike::{
    Destination, Live, Memory, OpenLog, RobotError, Seen, StrikeRecord, Watched, strike_and_keep,
};
use values::Point;

use crate::bench::{in_time, plan, wait_for};

const TO: Point = Point::new(0.62, 0.0);
/// How long an object is waited for.
const HANGS: Duration = Duration::from_secs(20);

/// An arm of a maker, its object where the plan wants it, and the address of its camera.
fn lab(maker: Maker) -> (Emulator, String) {
    let rig = maker.rig();
    maker.at_table(&rig, plan(&rig, TO).from, false)
}

type Outcome = (Result<Option<StrikeRecord>, RobotError>, Option<Seen>);

/// Strikes where the camera sees the object.
fn watched<D: Arm>(maker: Maker, (emulator, url): &(Emulator, String)) -> Outcome {
    let (rig, folder) = (maker.rig(), tempfile::tempdir().unwrap());
    let (never, plan) = (AtomicBool::new(false), plan(&rig, TO));
    let live = Arc::new(Live::connect(url, &rig).unwrap());
    let rest = live.wait_for_rest(HANGS, &never).unwrap();
    let mut arm = connect_to::<D>(emulator, &rig, Arc::default()).unwrap();
    let mut memory = Memory::open(folder.path(), arm.serial()).unwrap();
    let watched = Watched::new(live, rest);
    strike_and_keep(&mut arm, &plan, Some(&watched), &mut memory, &never)
}

/// How often the object was struck.
fn met(emulator: &Emulator) -> usize {
    emulator.table(|table| table.counts.0).unwrap()
}

#[test]
fn an_object_that_is_moved_or_covered_during_the_run_up_is_not_struck() {
    let pushed = |table: &mut Table| table.push(Point::new(0.03, 0.0));
    let covered = |table: &mut Table| table.cover(HANGS);
    in_time(|| moved::<XArm>(Maker::XArm, pushed, "moved during the run-up"));
    in_time(|| moved::<Ur>(Maker::Ur, pushed, "moved during the run-up"));
    in_time(|| moved::<XArm>(Maker::XArm, covered, "seen no more during the run-up"));
    in_time(|| moved::<Ur>(Maker::Ur, covered, "seen no more during the run-up"));

    fn moved<D: Arm>(maker: Maker, by: fn(&mut Table), said: &str) {
        let lab = lab(maker);
        let emulator = &lab.0;
        let (outcome, seen) = thread::scope(|scope| {
            scope.spawn(|| {
                // Lift, travel, lower; and the strike, as it begins.
                wait_for(|| emulator.lines() == 4);
                emulator.table(by);
            });
            watched::<D>(maker, &lab)
        });
        let error = outcome.unwrap_err();
        assert!(matches!(error, RobotError::Interrupted { .. }), "{error}");
        let text = error.to_string();
        assert!(text.contains(said), "{maker:?}: {text}");
        assert!(
            text.contains("mm before where it was to touch"),
            "{maker:?}: {text}"
        );
        assert_eq!(met(emulator), 0, "{text}");
        // Its log is no strike to learn from.
        let (folder, rig) = (tempfile::tempdir().unwrap(), maker.rig());
        let path = folder.path().join("log.mcap");
        let log = OpenLog::open(Destination::File(path.clone())).unwrap();
        let received = seen.unwrap().received;
        log.write_with(error.samples().unwrap(), &received, &rig.topics)
            .unwrap();
        let read = ingest_log(&path, &rig, &Ingest::default()).unwrap();
        assert!(read.strikes.is_empty(), "{:?}", read.strikes);
    }
}

#[test]
fn an_object_that_lies_still_is_struck_whatever_it_does_then() {
    fn still<D: Arm>(maker: Maker) {
        for _ in 0..2 {
            let lab = lab(maker);
            let (outcome, seen) = watched::<D>(maker, &lab);
            outcome.unwrap();
            let seen = seen.unwrap();
            assert_eq!((seen.doubt(), met(&lab.0)), (None, 1));
        }
    }
    in_time(|| still::<XArm>(Maker::XArm));
    in_time(|| still::<Ur>(Maker::Ur));
}
