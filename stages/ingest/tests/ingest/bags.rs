//! rosbag2's folders as PyPI's `rosbags` writes them (`tests/peers/bags.py`), which is installed beside the build: whatever the form,
//! the same strikes.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{Folder, ingest, rig, session, truths};
use ingest::{Ingest, LogFile, LogOutcome, ingest_log};
use values::Strike;

const PEERS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/peers");

/// Runs a command to its end.
fn run(command: &mut Command) {
    let output = command.output().expect("starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {said}");
}

/// Python with `rosbags`.
fn python() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("rosbags");
    let python = folder.join("bin/python");
    let requirements = format!("{PEERS}/requirements_bags.txt");
    let wanted = std::fs::read_to_string(&requirements).expect("requirements");
    let done = folder.join("done");
    if std::fs::read_to_string(&done).ok().as_ref() != Some(&wanted) {
        run(Command::new("python3").args(["-m", "venv"]).arg(&folder));
        run(Command::new(&python).args(["-m", "pip", "install", "--quiet", "-r", &requirements]));
        std::fs::write(done, wanted).expect("writes");
    }
    python
}

/// What a strike is, wherever it was logged.
fn measured(outcome: &LogOutcome) -> Vec<Strike> {
    let unnamed = |strike: &Strike| {
        let mut strike = strike.clone();
        strike.log.clear();
        strike.conditions.session.clear();
        strike
    };
    outcome.strikes.iter().map(unnamed).collect()
}

#[test]
fn a_bag_in_any_form_holds_the_same_strikes() {
    let folder = Folder::new();
    let plain = folder.write("session.mcap", &session(&truths(6)));
    let bags = folder.path("bags");
    std::fs::create_dir(&bags).expect("folder");
    run(Command::new(python())
        .arg(format!("{PEERS}/bags.py"))
        .args([&plain, &bags]));
    let expected = measured(&ingest(&plain));
    assert_eq!(expected.len(), 6);
    let file = |name: &str| bags.join(name);
    for log in [
        file("mcap/mcap.mcap"),
        file("mcap"),
        file("db3/db3.db3"),
        file("mcap_messages"),
        file("db3_messages"),
        file("mcap_file/mcap_file.mcap.zstd"),
        file("db3_file"),
        file("split"),
    ] {
        let outcome = ingest(&log);
        assert!(outcome.notes.is_empty(), "{}", log.display());
        assert!(outcome.whole, "{}", log.display());
        assert!(measured(&outcome) == expected, "{}", log.display());
        // What is hashed before is what is read.
        let hashed = LogFile::open(&log).expect("hashed").sha256;
        assert_eq!(outcome.sha256, hashed, "{}", log.display());
    }

    let mut foreign = rig();
    let topics = &mut foreign.topics;
    for (topic, stamp, x, y) in [
        (&mut topics.centroid, "at", "places[0].x", "places[0].y"),
        (&mut topics.command, "at", "velocity[0]", "velocity[1]"),
    ] {
        (topic.stamp, topic.x, topic.y) = (stamp.into(), x.into(), y.into());
    }
    let outcome = ingest_log(&file("foreign"), &foreign, &Ingest { seed: 1 });
    assert!(measured(&outcome.expect("read")) == expected);

    // A file that is missing takes the strikes in it, and is told.
    std::fs::remove_file(file("split/split_1.mcap")).expect("removed");
    let outcome = ingest(&file("split"));
    assert!(!outcome.whole && outcome.strikes.len() < 6);
    assert!(
        outcome.notes[0].contains("split_1.mcap"),
        "{:?}",
        outcome.notes
    );
    for strike in measured(&outcome) {
        assert!(expected.iter().any(|whole| whole.id == strike.id));
    }
}
