//! Real strikes of a KUKA arm, where the folder with them is there.

use std::path::{Path, PathBuf};

use ingest::{Ingest, LogOutcome, assemble, ingest_log};
use values::{Rig, Strike};

/// The folder of the real strikes, beside the checkout.
fn folder() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/kuka-strikes");
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: the real strikes are not at {}", folder.display());
    None
}

fn ingest_all(folder: &Path) -> (Rig, Vec<LogOutcome>) {
    let rig = Rig::load(&folder.join("rig.toml")).expect("the rig file is accepted");
    let outcome = |log: &str| {
        ingest_log(&folder.join("logs").join(log), &rig, &Ingest::default())
            .expect("the log is read")
    };
    let outcomes = vec![outcome("session_b.mcap"), outcome("session_a.mcap")];
    (rig, outcomes)
}

/// Release speed (m/s) and deceleration (m/s²), from a line through √(D − d(t)) over the free slide.
fn release(strike: &Strike) -> (f64, f64) {
    let path = strike.path();
    let length = path.norm();
    let points: Vec<(f64, f64)> = (0..strike.track.len())
        .map(|frame| {
            let d = (strike.track.point(frame) - strike.initial).dot(path) / length;
            (strike.track.t[frame], length - d)
        })
        .filter(|(t, left)| *t > 0.05 && *left > 0.05 * length)
        .map(|(t, left)| (t, left.sqrt()))
        .collect();
    let count = points.len() as f64;
    let (t, s) = points.iter().fold((0.0, 0.0), |sum, p| {
        (sum.0 + p.0 / count, sum.1 + p.1 / count)
    });
    let slope = points.iter().map(|p| (p.0 - t) * (p.1 - s)).sum::<f64>()
        / points.iter().map(|p| (p.0 - t).powi(2)).sum::<f64>();
    let at_zero = s - slope * t;
    (-2.0 * at_zero * slope, 2.0 * slope * slope)
}

#[test]
fn all_fifty_real_strikes_are_kept() {
    let Some(folder) = folder() else { return };
    let (rig, outcomes) = ingest_all(&folder);
    assert!(outcomes.iter().all(|outcome| outcome.whole), "{outcomes:?}");
    let (strikes, rejects) = assemble(outcomes);
    assert_eq!(rejects, []);
    let of = |session: &str| {
        strikes
            .iter()
            .filter(|strike| strike.log == session)
            .count()
    };
    assert_eq!((of("session_a.mcap"), of("session_b.mcap")), (20, 30));
    println!(
        "log             #  order  speed  angle    path   time frames release ratio  decel   step"
    );
    for strike in &strikes {
        let (speed, deceleration) = release(strike);
        println!(
            "{:14} {:2} {:6} {:6.3} {:6.3} {:7.4} {:6.3} {:6} {:7.3} {:5.3} {:6.3} {:6.4}",
            strike.log,
            strike.index,
            strike.conditions.order,
            strike.command.speed,
            strike.command.angle,
            strike.path().norm(),
            strike.track.t.last().copied().unwrap_or_default(),
            strike.track.len(),
            speed,
            speed / strike.command.speed,
            deceleration,
            strike.track.point(0).distance(strike.initial)
        );
        assert!((0.49..2.76).contains(&strike.command.speed));
        assert!(
            strike.command.speed / 0.25 % 1.0 < 1e-6,
            "speeds were set in steps of 0.25 m/s"
        );
        assert!(
            (0.15..0.9).contains(&strike.path().norm()),
            "{}",
            strike.path().norm()
        );
        assert!((strike.path().bearing() - strike.command.angle).abs() < 0.6);
        assert!(rig.table.contains(strike.initial) && rig.table.contains(strike.stop));
        // The track begins where the object rested and ends where it stopped.
        let track = &strike.track;
        let step = track.point(0).distance(strike.initial);
        assert!(
            step < 1.6 * strike.command.speed / rig.camera.rate,
            "{step}"
        );
        assert!(track.point(track.len() - 1).distance(strike.stop) < 0.002);
        assert!((0.3..3.0).contains(&deceleration), "{deceleration}");
    }
}

#[test]
fn what_happens_after_the_first_rest_is_no_part_of_a_strike() {
    let Some(folder) = folder() else { return };
    let (_, outcomes) = ingest_all(&folder);
    // This recording runs on for a minute after a hand puts the object back, half a metre from where it stopped.
    let strike = &outcomes[0].strikes[27];
    assert!(
        (strike.path().norm() - 0.5228).abs() < 0.001,
        "{}",
        strike.path().norm()
    );
    assert!(strike.track.t.last().copied().unwrap_or_default() < 1.5);
}
