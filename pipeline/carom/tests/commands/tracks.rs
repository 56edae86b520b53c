//! Logs whose tracks do not end at rest: a fence that nobody stated, a table on which nothing stops.

use std::path::Path;

use carom::Outcome;
use logs::write::{RecordingWriter, Samples, Stamped, StateSample};
use rig::{AirTable, FenceTruth, Hidden, demo};
use serde_json::Value;
use values::{Point, Reject, Rig, Shape, Strike};

use crate::fixture::{answer, carom, folder_and_path};

/// 120 strikes of a demo with this hidden, half of which a fence turns back; with the truth's friction and restitution.
fn fenced(folder: &Path, hide: &[&str]) -> (f64, f64) {
    let hidden = Hidden::parse(hide).unwrap();
    let mut settings = demo::Settings::new(Shape::Cylinder, 120, 21, Some(hidden));
    settings.truth.fences = vec![FenceTruth {
        from: Point::new(0.55, -0.8),
        to: Point::new(0.65, 0.8),
        restitution: 0.5,
    }];
    demo::write(&settings, folder).unwrap();
    (settings.truth.friction, settings.truth.restitution)
}

/// Whether an interval of `world.toml`'s parameters holds a value; 95 % of them do.
fn holds(said: &Value, name: &str, value: f64) -> bool {
    let estimate = &said["parameters"][name];
    let end = |key: &str| estimate[key].as_f64().unwrap();
    (end("low")..=end("high")).contains(&value)
}

#[test]
fn a_fence_that_nobody_stated_is_found_told_and_ends_tracks() {
    let (folder, dir) = folder_and_path();
    let (friction, restitution) = fenced(&folder.path().join("rig"), &["none"]);
    let rig = format!("--rig {dir}/rig/rig.toml");
    let checked = carom(&format!("check {dir}/rig/logs {rig}")).unwrap();
    let findings = checked.json["findings"].as_array().unwrap();
    let fences: Vec<&Value> = findings
        .iter()
        .filter(|finding| finding["finding"] == "fence")
        .collect();
    assert_eq!(fences.len(), 1, "{}", checked.text);
    let mend = fences[0]["words"]["mend"].as_str().unwrap();
    assert!(mend.contains("[[table.fences]] from = ["), "{mend}");
    let said = answer(&format!("ingest {dir}/rig/logs {rig} --out {dir}/run"));
    // One meets the fence within the frames that tell nothing.
    assert!(said.json["strikes"].as_u64() >= Some(118), "{}", said.text);
    let said = answer(&format!("sysid --out {dir}/run"));
    assert!(holds(&said.json, "friction", friction), "{}", said.text);
    let estimate = &said.json["parameters"]["restitution"]["value"];
    // Masses and the launch factor are one with it.
    assert!(
        estimate
            .as_f64()
            .is_some_and(|e| (e - restitution).abs() < 0.1),
        "{}",
        said.text
    );
    let strikes = tables::read_strikes(&folder.path().join("run")).unwrap();
    let cut = strikes.iter().filter(|strike| !strike.has_stop()).count();
    assert!((30..110).contains(&cut), "{cut} of {}", strikes.len());
    // None goes on behind a bounce.
    let turned = |strike: &Strike| strike.track.x.windows(2).any(|x| x[1] < x[0] - 0.004);
    assert!(!strikes.iter().any(turned));
}

#[test]
fn what_hides_behind_a_fence_is_named_as_on_an_open_table() {
    let (folder, dir) = folder_and_path();
    fenced(&folder.path().join("rig"), &["table_tilt=0.012,0.008"]);
    let said = answer(&format!(
        "ingest {dir}/rig/logs --rig {dir}/rig/rig.toml --out {dir}/run"
    ));
    // One meets the fence within the frames that tell nothing.
    assert!(said.json["strikes"].as_u64() >= Some(118), "{}", said.text);
    let said = answer(&format!("diagnose --out {dir}/run"));
    let diagnosis = &said.json["diagnosis"];
    assert_eq!(diagnosis["verdict"], "named", "{diagnosis}");
    assert_eq!(diagnosis["effects"][0]["name"], "table_tilt");
}

#[test]
fn an_air_table_on_which_nothing_stops_is_identified_and_diagnosed_and_not_published() {
    let (folder, dir) = folder_and_path();
    let table = AirTable {
        friction: 0.004,
        tilt: Point::default(),
        restitution: 0.8,
        wall_restitution: 0.9,
        seed: 5,
    };
    std::fs::create_dir(folder.path().join("logs")).unwrap();
    for session in 0..2 {
        let log = folder.path().join(format!("logs/session_{session}.mcap"));
        table.write(140.0, session, &log).unwrap();
    }
    let rig = folder.path().join("rig.toml");
    std::fs::write(&rig, AirTable::rig().to_toml()).unwrap();
    let said = answer(&format!(
        "run {dir}/logs --rig {dir}/rig.toml --out {dir}/run"
    ));
    assert_eq!(said.outcome, Outcome::Refused, "{}", said.text);
    // Of 51 hits, all but those that graze, or after which the puck meets a wall within the frames that tell nothing.
    assert!(said.json["strikes"].as_u64() > Some(35), "{}", said.text);
    let rejects = tables::read_rejects(&folder.path().join("run")).unwrap();
    let tells_nothing = |reject: &Reject| {
        let said = &reject.detail;
        said.contains("only grazes it") || said.contains("frames after the impact")
    };
    assert!(rejects.iter().all(tells_nothing), "{rejects:?}");
    assert!(said.text.contains("nothing is published"), "{}", said.text);
    assert!(!folder.path().join("run/latest").exists());
    assert!(
        holds(&said.json, "friction", table.friction),
        "{}",
        said.text
    );
    assert!(
        holds(&said.json, "restitution", table.restitution),
        "{}",
        said.text
    );
    assert!(
        said.json["diagnosis"]["verdict"].is_string(),
        "{}",
        said.text
    );
    // By the places at the tracks' ends.
    let mean = |model: &str| said.json["stop_error"]["models"][model]["mean"].as_f64();
    assert!(mean("sysid") < mean("nominal"), "{}", said.text);
    assert!(mean("sysid") < Some(0.05), "{}", said.text);
}

/// A log in which a hand pushes the object about, some seconds apart, on a table of this friction; the arm rests far away, and nothing is
/// commanded.
fn pushed(log: &Path, friction: f64, count: u32) {
    const EVERY: f64 = 5.0;
    const PUSH: f64 = 0.12;
    let brakes = 9.81 * friction;
    let mut samples = Samples::default();
    let stamp = |t: f64| 1_700_900_000_000_000_000 + (t * 1e9) as u64;
    let mut frame = 0_u32;
    let mut wobble = |seed: f64| {
        frame += 1;
        // Of many equal parts, as good as normal.
        (0..12).fold(-6.0, |sum, k| {
            let number = (f64::from(frame * 12 + k) * 12.9898 + seed).sin() * 43758.5453;
            sum + number - number.floor()
        })
    };
    for i in 0..(60.0 * EVERY * f64::from(count)) as u32 {
        let t = f64::from(i) / 60.0 + 0.003;
        let (of, t0) = ((t / EVERY).floor(), t % EVERY - 2.0);
        let (speed, angle) = (1.0 + 0.03 * (of % 7.0), -0.6 + 0.3 * (of % 5.0));
        let (pushed, slid) = (t0.clamp(0.0, PUSH), (t0 - PUSH).clamp(0.0, speed / brakes));
        let gone = 0.5 * speed / PUSH * pushed * pushed + (speed - 0.5 * brakes * slid) * slid;
        let place = Point::new(0.35, 0.02 * (of % 4.0)) + Point::polar(gone, angle);
        samples.centroids.push(Stamped::at(
            stamp(t),
            Point::new(
                place.x + 0.0007 * wobble(0.1),
                place.y + 0.0007 * wobble(0.7),
            ),
        ));
        samples.states.push(StateSample {
            stamp: stamp(t),
            position: [0.0, -0.5],
            velocity: [0.0, 0.0],
        });
    }
    let topics = Rig::demo(Shape::Cylinder).topics;
    let mut writer = RecordingWriter::create(log, &topics).unwrap();
    writer.write(&samples).unwrap();
    writer.finish().unwrap();
}

#[test]
fn a_hands_pushes_teach_friction_beside_strikes_and_alone_publish_nothing() {
    let (folder, dir) = folder_and_path();
    let hidden = Hidden::parse(&["none"]).unwrap();
    let mut settings = demo::Settings::new(Shape::Cylinder, 30, 23, Some(hidden));
    settings.log_state = true;
    demo::write(&settings, &folder.path().join("rig")).unwrap();
    let friction = settings.truth.friction;
    std::fs::create_dir(folder.path().join("pushes")).unwrap();
    pushed(&folder.path().join("pushes/hand.mcap"), friction, 40);
    let run = |logs: &str, to: &str| {
        let line = format!("ingest {logs} --rig {dir}/rig/rig.toml --out {dir}/{to}");
        let read = answer(&line);
        (read, answer(&format!("sysid --out {dir}/{to}")))
    };
    let width = |said: &Value, name: &str| {
        let end = |key: &str| said["parameters"][name][key].as_f64().unwrap();
        end("high") - end("low")
    };
    let (_, alone) = run(&format!("{dir}/rig/logs"), "alone");
    let (read, both) = run(&format!("{dir}/rig/logs {dir}/pushes"), "both");
    // Nearly all; noise makes one or another too short.
    let found = read.text.lines().find_map(|line| {
        let before = line.split(" slides that no strike began").next()?;
        before.split_whitespace().last()?.parse::<u32>().ok()
    });
    assert!(
        found.is_some_and(|found| (36..=40).contains(&found)),
        "{}",
        read.text
    );
    assert_eq!(read.json["strikes"], alone.json["strikes"]);
    assert!(holds(&both.json, "friction", friction), "{}", both.text);
    let (before, after) = (
        width(&alone.json, "friction"),
        width(&both.json, "friction"),
    );
    assert!(after < 0.8 * before, "{before} {after}");
    // What they do not teach stays as it was.
    let restitution = |said: &Value| said["parameters"]["restitution"]["value"].as_f64();
    let (before, after) = (restitution(&alone.json), restitution(&both.json));
    let changed = before
        .zip(after)
        .map_or(f64::NAN, |(before, after)| after - before);
    assert!(
        changed.abs() < 0.25 * width(&alone.json, "restitution"),
        "{changed}"
    );
    let strikes = |run: &str| tables::read_strikes(&folder.path().join(run)).unwrap();
    assert_eq!(strikes("alone").len(), strikes("both").len());

    let said = answer(&format!(
        "run {dir}/pushes --rig {dir}/rig/rig.toml --out {dir}/hand"
    ));
    assert_eq!(said.outcome, Outcome::Refused, "{}", said.text);
    assert!(said.text.contains("no strike was seen"), "{}", said.text);
    assert!(holds(&said.json, "friction", friction), "{}", said.text);
    assert!(
        said.json["parameters"]["restitution"]["low"].is_null(),
        "{}",
        said.text
    );
    assert!(!folder.path().join("hand/latest").exists());
    for (command, what) in [
        (
            format!("view {dir}/hand -o {dir}/view.mcap"),
            "no strike was kept",
        ),
        (
            format!("dataset export {dir}/hand --lerobot {dir}/lerobot --fps 50"),
            "it holds no strike",
        ),
    ] {
        let error = carom(&command).expect_err("there is none");
        assert_eq!(error.outcome(), Outcome::BadInput);
        assert!(error.to_string().contains(what), "{error}");
    }
}
