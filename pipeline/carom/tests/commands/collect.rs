//! Collections from the embedded rig.

use carom::Outcome;

use crate::fixture::{bad_input, carom, demo, done, refusal, write};

#[test]
fn a_collection_makes_what_is_planned_first_goes_on_and_is_joined_into_sessions() {
    let (folder, dir) = demo("--strikes 1 --hide none");
    let planned = r#"{"next_strikes": [{"x0": 0.3, "y0": 0.05, "speed": 0.613, "angle": 0.123}]}"#;
    write(&folder.path().join("next.json"), planned);
    let collect = |strikes: u32| {
        done(&format!(
            "collect --rig {dir}/rig/rig.toml --robot sim --strikes {strikes} --plan {dir}/next.json --out {dir}/logs"
        ))
    };
    let first = collect(3);
    assert_eq!((&first["strikes"], &first["made"]), (&3.into(), &3.into()));
    let more = collect(5);
    assert_eq!((&more["strikes"], &more["made"]), (&5.into(), &2.into()));
    let none = collect(5);
    assert_eq!(
        (&none["made"], none["session"].is_null()),
        (&0.into(), true)
    );
    let mut names: Vec<String> = std::fs::read_dir(folder.path().join("logs"))
        .unwrap()
        .filter_map(|entry| entry.unwrap().file_name().into_string().ok())
        .filter(|name| !name.starts_with('.'))
        .collect();
    names.sort();
    assert_eq!(names, ["session_000001.mcap", "session_000002.mcap"]);
    let read = done(&format!(
        "ingest {dir}/logs --rig {dir}/rig/rig.toml --out {dir}/run"
    ));
    assert_eq!(read["strikes"], 5, "{read}");
    let strikes = tables::read_strikes(&folder.path().join("run")).unwrap();
    let commands: Vec<_> = strikes.iter().map(|strike| strike.command).collect();
    let is_planned = |at: usize| {
        (commands[at].speed - 0.613).abs() < 1e-6 && (commands[at].angle - 0.123).abs() < 1e-6
    };
    // First, and once, although the plan was given three times.
    assert!(is_planned(0) && !(1..5).any(is_planned), "{commands:?}");
    // No strike is another one's repeat.
    for (at, one) in commands.iter().enumerate() {
        let is_other = |other: &values::Command| (one.speed - other.speed).abs() > 1e-3;
        assert!(commands[at + 1..].iter().all(is_other), "{commands:?}");
    }
}

#[test]
fn a_planned_strike_that_is_left_out_is_no_success() {
    let (folder, dir) = demo("--strikes 1 --hide none");
    let planned = r#"{"next_strikes": [{"x0": 0.3, "y0": 0.05, "speed": 9.0, "angle": 0.0}]}"#;
    write(&folder.path().join("next.json"), planned);
    let said = carom(&format!(
        "collect --rig {dir}/rig/rig.toml --robot sim --strikes 1 --plan {dir}/next.json --out {dir}/logs"
    ));
    let said = said.unwrap();
    assert_eq!(said.outcome, Outcome::Rejected, "{}", said.text);
    assert_eq!(
        (&said.json["made"], &said.json["left_out"]),
        (&1.into(), &1.into())
    );
}

#[test]
fn a_strike_that_was_joined_before_the_program_was_killed_is_not_joined_twice() {
    let (folder, dir) = demo("--strikes 1 --hide none");
    let collect = |strikes: u32| {
        done(&format!(
            "collect --rig {dir}/rig/rig.toml --robot sim --strikes {strikes} --out {dir}/logs"
        ))
    };
    collect(2);
    // As if the program had ended after it named the session and before it removed the logs of single strikes; and before it
    // named anything.
    let logs = folder.path().join("logs");
    std::fs::copy(
        logs.join("session_000001.mcap"),
        logs.join("strike_000001.mcap"),
    )
    .unwrap();
    write(&logs.join(".session.1_0.partial"), "half a log");
    let more = collect(3);
    assert_eq!((&more["strikes"], &more["made"]), (&3.into(), &1.into()));
    let read = done(&format!(
        "ingest {dir}/logs --rig {dir}/rig/rig.toml --out {dir}/run"
    ));
    assert_eq!(read["strikes"], 3, "{read}");
    assert!(!logs.join("strike_000001.mcap").exists());
    assert!(!logs.join(".session.1_0.partial").exists());
}

#[test]
fn what_cannot_collect_is_reported_before_anything_is_made() {
    let (_folder, dir) = demo("--strikes 1 --hide none");
    let collect = format!("collect --rig {dir}/rig/rig.toml --strikes 2 --out {dir}/logs --robot");
    for (rest, said) in [
        ("dry-run", "makes none"),
        ("sim --watch ws://localhost:1", "camera of its own"),
        ("xarm:127.0.0.1", "--watch"),
        ("xarm:127.0.0.1 --watch localhost", "ws://HOST:PORT"),
    ] {
        let why = bad_input(&format!("{collect} {rest}"));
        assert!(why.contains(said), "{rest}: {why}");
    }
    // An arm that a version of nobody is to foresee for.
    let (outcome, why) = refusal(&format!(
        "{collect} xarm:127.0.0.1 --watch ws://127.0.0.1:1 --artifacts {dir}/run"
    ));
    assert_eq!(outcome, Outcome::Refused, "{why}");
}
