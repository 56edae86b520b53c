//! What a person does while a night goes on.

use std::fs;
use std::path::Path;
use std::thread;
use std::time::Duration;

use crate::fixture::{carom, done, json};

/// Bytes that a folder holds.
fn size(dir: &Path) -> u64 {
    let files = fs::read_dir(dir).expect("a folder").flatten();
    files
        .map(|file| match file.metadata() {
            Ok(it) if it.is_dir() => size(&file.path()),
            it => it.map_or(0, |it| it.len()),
        })
        .sum()
}

#[test]
fn a_version_that_is_put_to_use_during_a_night_stays_and_the_next_night_decides_anew() {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path();
    let name = dir.display();
    done(&format!("demo --strikes 100 --seed 4 --out {name}/rig"));
    fs::create_dir(dir.join("logs")).expect("a folder");
    let log = |session: u32| {
        let session = format!("session_{session:03}.mcap");
        let from = dir.join("rig/logs").join(&session);
        fs::copy(from, dir.join("logs").join(&session)).expect("copied");
    };
    // So split, the first session's 25 strikes hold out eight, which judge a first version.
    let usual = format!("{name}/logs --rig {name}/rig/rig.toml --out {name}/run --seed 6");
    log(0);
    done(&format!("nightly {usual}"));
    log(1);
    done(&format!("run {usual}"));
    done(&format!("artifacts rollback v0001 --artifacts {name}/run"));
    let latest = || fs::read_to_string(dir.join("run/latest")).expect("a version");
    assert_eq!(latest().trim(), "v0001");

    // Once the night has answered for the new log it has read what is in use, and minutes of work on this machine lie ahead.
    log(2);
    let run = dir.join("run");
    let answers = || size(&run.join("cache/ingest"));
    let before = answers();
    let night = {
        let line = format!("nightly {usual}");
        thread::spawn(move || carom(&line).map(|said| said.json))
    };
    while answers() == before && !night.is_finished() {
        thread::sleep(Duration::from_millis(5));
    }
    done(&format!("artifacts rollback v0002 --artifacts {name}/run"));
    assert!(!night.is_finished(), "the night was over before");
    let night = night.join().expect("no panic").expect("a decision");
    assert_eq!(
        (&night["before"], &night["latest"]),
        (&"v0001".into(), &"v0002".into())
    );
    assert_ne!(night["status"], "promoted", "{night}");
    assert_eq!(latest().trim(), "v0002");

    // The decision was about another version.
    let next = carom(&format!("nightly {usual}")).expect("a decision").json;
    assert_ne!(next["status"], "nothing_new", "{next}");
    assert_eq!(json(&run, "nightly.json")["before"], "v0002");
}
