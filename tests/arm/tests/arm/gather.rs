//! A collection on the emulated arm, whose camera is a live topic: the object where it is seen, one log a strike, a session at the end.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use arm::{Emulator, Event, Fault, Maker, connect_to};
use ingest::{Ingest, ingest_log};
use strike::collect::{ArmStation, CollectError, CollectEvent, Collected, collect};
use strike::xarm::XArm;
use strike::{CommandPlanner, Live, Memory, RobotError, execute, strike_and_keep};
use tempfile::TempDir;
use values::{Command, Point, Rig};

use crate::bench::{self, in_time, rig, wait_for};

/// An arm at a table, the address of its camera, and the folder of what is kept by arm.
type Lab = (Emulator, String, TempDir);

/// A lab whose object a hand puts back or not.
fn lab(rig: &Rig, puts_back: bool) -> Lab {
    let (emulator, url) = Maker::XArm.at_table(rig, Point::new(0.34, 0.02), puts_back);
    (emulator, url, tempfile::tempdir().unwrap())
}

/// Gathers strikes until `report` says that it is over.
fn gather(
    lab: &Lab,
    rig: &Rig,
    folder: &Path,
    strikes: usize,
    report: &mut dyn FnMut(CollectEvent) -> bool,
) -> Result<Collected, CollectError> {
    gather_by(SystemTime::now, lab, rig, folder, strikes, report)
}

/// Gathers strikes, stamped by `clock`, until `report` says that it is over.
fn gather_by(
    clock: fn() -> SystemTime,
    (emulator, url, memory): &Lab,
    rig: &Rig,
    folder: &Path,
    strikes: usize,
    report: &mut dyn FnMut(CollectEvent) -> bool,
) -> Result<Collected, CollectError> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let live = Live::connect(url, rig).unwrap();
    let pause = Duration::from_millis(500);
    let arm = connect_to::<XArm>(emulator, rig, interrupted.clone()).unwrap();
    let mut station = ArmStation::new(arm, live, pause, interrupted.clone(), memory.path())?;
    let planner = CommandPlanner::nominal(rig).unwrap().by_clock(clock);
    let is_over = || interrupted.load(Ordering::Relaxed);
    collect(
        &mut station,
        &planner,
        folder,
        strikes,
        &[],
        &is_over,
        &mut |news| {
            interrupted.fetch_or(report(news), Ordering::Relaxed);
        },
    )
}

/// Over once so many strikes are kept, all of which can be used.
fn over_at(most: usize) -> impl FnMut(CollectEvent) -> bool {
    move |news| match news {
        CollectEvent::Kept { strikes, warning } => {
            assert_eq!(warning, None);
            strikes >= most
        }
        CollectEvent::Useless(why) => panic!("{why}"),
        _ => false,
    }
}

/// Gathers; the object is waited for to be put elsewhere, and not struck again.
fn waits_for_a_hand(lab: &Lab, rig: &Rig, folder: &Path) {
    let mut waits = false;
    let ended = gather(lab, rig, folder, 2, &mut |news| {
        if let CollectEvent::Waiting(why) = news {
            waits |= why.contains("put it elsewhere");
        }
        waits || met(lab) > 1
    });
    assert!(waits, "{ended:?}");
    assert_eq!(met(lab), 1);
}

/// How often the object was struck.
fn met(lab: &Lab) -> usize {
    lab.0.table(|table| table.counts.0).unwrap()
}

#[test]
fn strikes_are_gathered_where_the_camera_sees_the_object_and_go_on_after_an_end() {
    in_time(|| {
        let (rig, folder) = (rig(), tempfile::tempdir().unwrap());
        let lab = lab(&rig, true);
        // Ended after the first of three.
        let first = gather(&lab, &rig, folder.path(), 3, &mut over_at(1)).unwrap();
        assert_eq!((first.strikes, first.made, &first.session), (1, 1, &None));
        assert!(folder.path().join("strike_000001.mcap").exists());
        let rest = gather(&lab, &rig, folder.path(), 3, &mut over_at(9)).unwrap();
        assert_eq!((rest.strikes, rest.made, rest.useless), (3, 2, 0));
        // All three are in one session, and no log is left of a single one.
        let session = rest.session.unwrap();
        let logs: Vec<_> = std::fs::read_dir(folder.path())
            .unwrap()
            .filter_map(|entry| entry.unwrap().file_name().into_string().ok())
            .filter(|name| name.ends_with(".mcap"))
            .collect();
        assert_eq!(logs, [session.file_name().unwrap().to_str().unwrap()]);
        let outcome = ingest_log(&session, &rig, &Ingest::default()).unwrap();
        assert!(outcome.rejects.is_empty(), "{:?}", outcome.rejects);
        assert_eq!(outcome.strikes.len(), 3);
        for strike in &outcome.strikes {
            let delivered = strike.delivered.unwrap();
            println!(
                "from {:?} at {:.4} m/s, {:.4} rad; delivered {:.4} m/s, {:.4} rad; stopped at {:?}",
                strike.initial,
                strike.command.speed,
                strike.command.angle,
                delivered.tip_speed,
                delivered.tip_angle,
                strike.stop
            );
            assert!((delivered.tip_speed / strike.command.speed - 1.0).abs() < 0.01);
            assert!((delivered.tip_angle - strike.command.angle).abs() < 0.01);
            assert!(!strike.is_pushed_again());
            assert!(strike.path().norm() > 0.05);
        }
        let (met, again) = lab.0.table(|table| table.counts).unwrap();
        assert_eq!((met, again), (3, 0));
        // Nothing is left to do.
        let done = gather(&lab, &rig, folder.path(), 3, &mut over_at(9)).unwrap();
        assert_eq!((done.made, done.session), (0, None));
    });
}

#[test]
fn an_object_that_was_not_seen_to_rest_is_not_struck_until_it_was_put_elsewhere() {
    in_time(|| {
        let (rig, folder) = (rig(), tempfile::tempdir().unwrap());
        let lab = lab(&rig, false);
        thread::scope(|scope| {
            // From the impact on the camera is covered for longer than the object is waited for.
            scope.spawn(|| {
                wait_for(|| met(&lab) > 0);
                lab.0.table(|table| table.cover(Duration::from_secs(17)));
            });
            waits_for_a_hand(&lab, &rig, folder.path());
        });
    });
}

#[test]
fn a_folder_that_is_deleted_during_a_strike_does_not_forget_where_the_object_stopped() {
    in_time(|| {
        let (rig, outer) = (rig(), tempfile::tempdir().unwrap());
        let folder = outer.path().join("logs");
        let lab = lab(&rig, false);
        let ended = thread::scope(|scope| {
            scope.spawn(|| {
                wait_for(|| met(&lab) > 0);
                std::fs::remove_dir_all(&folder).unwrap();
            });
            gather(&lab, &rig, &folder, 2, &mut |_| met(&lab) > 1)
        });
        let error = ended.unwrap_err();
        let CollectError::Moved { path, .. } = &error else {
            panic!("{error}");
        };
        assert!(path.starts_with(&folder) && path.exists(), "{error}");
        let text = error.to_string();
        assert!(
            text.contains("leave the folder") && !text.contains("give a folder"),
            "{text}"
        );
        // A new call looks there, and waits for a hand.
        waits_for_a_hand(&lab, &rig, &folder);
    });
}

#[test]
fn an_object_that_nobody_put_back_is_not_struck_by_a_call_that_gathers_elsewhere() {
    in_time(|| {
        let (rig, lab) = (rig(), lab(&rig(), false));
        // Each call has a new folder: no log says where the object stopped.
        let [one, other] = [(); 2].map(|()| tempfile::tempdir().unwrap());
        gather(&lab, &rig, one.path(), 1, &mut |_| false).unwrap();
        waits_for_a_hand(&lab, &rig, other.path());
    });
}

#[test]
fn an_object_that_strike_has_struck_is_not_gathered_from_until_it_was_put_elsewhere() {
    in_time(|| {
        let (rig, lab, folder) = (rig(), lab(&rig(), false), tempfile::tempdir().unwrap());
        let plan = bench::plan(&rig, Point::new(0.62, 0.0));
        lab.0.table(|table| table.put(plan.from));
        let mut arm = connect_to::<XArm>(&lab.0, &rig, Arc::default()).unwrap();
        let mut memory = Memory::open(lab.2.path(), arm.serial()).unwrap();
        let never = AtomicBool::new(false);
        // Without a camera.
        let (outcome, seen) = strike_and_keep(&mut arm, &plan, None, &mut memory, &never);
        assert!(outcome.is_ok() && seen.is_none(), "{outcome:?}");
        drop(arm);
        waits_for_a_hand(&lab, &rig, folder.path());
    });
}

#[test]
fn a_strike_whose_program_was_killed_is_told_by_the_next_call_and_the_object_is_not_struck() {
    in_time(|| {
        let (rig, lab) = (rig(), lab(&rig(), false));
        let [one, other] = [(); 2].map(|()| tempfile::tempdir().unwrap());
        // What `kill -9` leaves is what lies on the disk in the strike.
        let (path, left) = thread::scope(|scope| {
            let left = scope.spawn(|| {
                wait_for(|| met(&lab) > 0);
                let kept = std::fs::read_dir(lab.2.path()).unwrap().next();
                let path = kept.unwrap().unwrap().path();
                (path.clone(), std::fs::read(path).unwrap())
            });
            gather(&lab, &rig, one.path(), 1, &mut |news| {
                assert!(!matches!(news, CollectEvent::Lost(_)));
                false
            })
            .unwrap();
            left.join().unwrap()
        });
        std::fs::write(path, left).unwrap();
        let (mut lost, mut waits) = (Vec::new(), false);
        let ended = gather(&lab, &rig, other.path(), 2, &mut |news| {
            match news {
                CollectEvent::Lost(what) => lost.push(what),
                CollectEvent::Waiting(why) => waits |= why.contains("put it elsewhere"),
                _ => {}
            }
            waits || met(&lab) > 1
        });
        assert!(waits && met(&lab) == 1, "{ended:?}");
        assert_eq!(lost.len(), 1, "{lost:?}");
        assert!(lost[0].contains("no record of it was written"), "{lost:?}");
    });
}

#[test]
fn nobody_is_told_to_step_back_from_an_arm_that_somebody_stopped() {
    in_time(|| {
        let (rig, folder) = (rig(), tempfile::tempdir().unwrap());
        let lab = lab(&rig, true);
        let (mut is_stopped, mut told) = (false, 0);
        let ended = gather(&lab, &rig, folder.path(), 3, &mut |news| {
            match news {
                CollectEvent::Kept { .. } => {
                    lab.0.make(Fault::OperatorStop);
                    is_stopped = true;
                }
                CollectEvent::StepBack(_) if is_stopped => told += 1,
                _ => {}
            }
            false
        });
        let error = ended.unwrap_err().to_string();
        assert!(error.contains("is in charge"), "{error}");
        assert_eq!(told, 0);
    });
}

#[test]
fn nobody_is_told_to_step_back_from_an_arm_that_is_not_as_the_rig_file_says() {
    type Change = fn(&mut Rig);
    let cases: [(Change, &str); 3] = [
        (|rig| rig.robot.payload = Some(1.0), "kg"),
        (
            |rig| rig.robot.tool_orientation = Some([0.0; 3]),
            "tool points",
        ),
        (|rig| rig.robot.base_height = Some(0.05), "travel height"),
    ];
    for (change, said) in cases {
        let (lab, folder) = (lab(&rig(), true), tempfile::tempdir().unwrap());
        let mut rig = rig();
        change(&mut rig);
        let error = gather(&lab, &rig, folder.path(), 1, &mut |news| panic!("{news:?}"));
        let error = error.unwrap_err();
        assert!(
            matches!(error, CollectError::Robot(RobotError::NotReady { .. })),
            "{error}"
        );
        assert!(error.to_string().contains(said), "{error}");
    }
}

#[test]
fn an_arm_that_does_not_stand_where_the_rig_file_says_strikes_once() {
    in_time(|| {
        let (mut rig, folder) = (rig(), tempfile::tempdir().unwrap());
        let lab = lab(&rig, true);
        // It passes 10 cm beside the object.
        rig.robot.base = Some(Point::new(0.0, 0.1));
        let error = gather(&lab, &rig, folder.path(), 9, &mut |_| false).unwrap_err();
        assert!(matches!(error, CollectError::Unmoved(_)), "{error}");
        assert_eq!((met(&lab), lab.0.lines()), (0, 5));
        assert!(folder.path().join("strike_000001.mcap").exists());
    });
}

#[test]
fn whoever_is_told_to_step_back_late_has_the_whole_time_from_then_on() {
    in_time(|| {
        let (rig, folder) = (rig(), tempfile::tempdir().unwrap());
        let lab = lab(&rig, true);
        let mut told = None;
        gather(&lab, &rig, folder.path(), 1, &mut |news| {
            if let CollectEvent::StepBack(pause) = news {
                // As a terminal that is held back.
                thread::sleep(2 * pause);
                told = Some((Instant::now(), pause));
            }
            false
        })
        .unwrap();
        let (told, pause) = told.expect("is told");
        let events = lab.0.events();
        let line = events
            .iter()
            .find(|(_, event)| matches!(event, Event::Line));
        let after = line.expect("it moves").0 - told;
        assert!(after >= pause, "{after:?}");
    });
}

/// A clock of the day that was set by so many ms.
fn later(set: &AtomicU64) -> SystemTime {
    SystemTime::now() + Duration::from_millis(set.load(Ordering::Relaxed))
}

#[test]
fn a_strike_in_which_the_clock_was_set_is_no_strike_to_learn_from() {
    static SET: AtomicU64 = AtomicU64::new(0);
    in_time(|| {
        let (rig, folder) = (rig(), tempfile::tempdir().unwrap());
        let lab = lab(&rig, true);
        SET.store(0, Ordering::Relaxed);
        let mut reasons = Vec::new();
        let gathered = thread::scope(|scope| {
            scope.spawn(|| {
                wait_for(|| met(&lab) == 1);
                SET.store(40, Ordering::Relaxed);
            });
            gather_by(|| later(&SET), &lab, &rig, folder.path(), 1, &mut |news| {
                if let CollectEvent::Useless(why) = news {
                    reasons.push(why);
                }
                false
            })
        });
        // The next one is as any other: both clocks are read anew.
        let gathered = gathered.unwrap();
        assert_eq!((gathered.made, gathered.useless), (1, 1), "{reasons:?}");
        assert!(
            reasons[0].contains("clock was set by +0.040 s"),
            "{reasons:?}"
        );
        let outcome = ingest_log(&gathered.session.unwrap(), &rig, &Ingest::default()).unwrap();
        assert_eq!(outcome.strikes.len(), 1);
    });
}

#[test]
fn a_clock_that_was_set_between_two_strikes_is_told_in_the_log_of_the_second() {
    static SET: AtomicU64 = AtomicU64::new(0);
    in_time(|| {
        let (rig, folder) = (rig(), tempfile::tempdir().unwrap());
        let lab = lab(&rig, true);
        SET.store(0, Ordering::Relaxed);
        let mut warnings = Vec::new();
        let gathered = gather_by(|| later(&SET), &lab, &rig, folder.path(), 2, &mut |news| {
            if let CollectEvent::Kept { warning, .. } = news {
                SET.store(4, Ordering::Relaxed);
                warnings.push(warning);
            }
            false
        });
        assert_eq!(warnings[0], None);
        let told = warnings[1].as_ref().unwrap();
        assert!(told.contains("+0.004 s since the strike before"), "{told}");
        let session = gathered.unwrap().session.unwrap();
        let answers: Vec<String> = logs::write::lineages(&session)
            .unwrap()
            .into_iter()
            .map(|lineage| lineage["robot_answered"].clone())
            .collect();
        assert_eq!(
            answers,
            ["struck".into(), format!("struck, with a warning: {told}")]
        );
    });
}

#[test]
fn a_plan_from_before_the_clock_was_set_is_not_struck() {
    static SLEPT: AtomicU64 = AtomicU64::new(0);
    let rig = rig();
    let planner = CommandPlanner::nominal(&rig)
        .unwrap()
        .by_clock(|| later(&SLEPT));
    let command = Command::new(0.5, 0.0);
    let plan = planner.plan(Point::new(0.36, 0.0), command, 1.0).unwrap();
    let emulator = Maker::XArm.emulator(None);
    let mut arm = connect_to::<XArm>(&emulator, &rig, Arc::default()).unwrap();
    // As after a lid that was closed for an hour: what measures the plan's age stood still meanwhile.
    SLEPT.store(3_600_000, Ordering::Relaxed);
    let error = execute(&mut arm, &plan).unwrap_err();
    assert!(matches!(error, RobotError::Refused(_)), "{error}");
    assert!(error.to_string().contains("+3600.000 s"), "{error}");
}
