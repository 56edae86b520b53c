//! What the commands make of logs: several, grown, cut off, rejected, none.

use carom::Outcome;

use crate::fixture::{answer, bad_input, demo, done, write};

#[test]
fn a_log_that_has_grown_and_another_of_its_name_are_distinguished_at_night() {
    let (folder, dir) = demo("--strikes 240 --hide none");
    let session = |number: u32| {
        let path = format!("rig/logs/session_00{number}.mcap");
        std::fs::read(folder.path().join(path)).unwrap()
    };
    let put = |day: &str, bytes: &[u8]| {
        let day = folder.path().join("days").join(day);
        std::fs::create_dir_all(&day).unwrap();
        std::fs::write(day.join("session.mcap"), bytes).unwrap();
    };
    let night = |more: &str| {
        let said = answer(&format!("nightly {more} --out {dir}/run"));
        let count = |key: &str| said.json[key].as_u64().unwrap();
        (count("strikes"), count("new_strikes"))
    };
    let last = session(3);
    put("d0", &session(0));
    put("d1", &last[..last.len() / 2]);
    let (cut, _) = night(&format!("{dir}/days --rig {dir}/rig/rig.toml"));
    assert!((49..96).contains(&cut), "{cut}");
    put("d1", &last);
    assert_eq!(night(""), (96, 96 - cut), "it has grown");
    // Made before the last strike that the version knows.
    put("d1", &session(1));
    assert_eq!(night(""), (96, 48), "another of its name");
}

#[test]
fn a_rig_file_is_proposed_out_of_a_log_and_reads_it() {
    let (folder, dir) = demo("--strikes 40 --hide none --state");
    let log = format!("{dir}/rig/logs/session_000.mcap");
    done(&format!("rig init --from {log} --out {dir}/own.toml"));
    let own = values::Rig::load(&folder.path().join("own.toml")).unwrap();
    let stated = values::Rig::load(&folder.path().join("rig/rig.toml")).unwrap();
    assert_eq!(own.topics, stated.topics);
    assert_eq!(own.camera.rate, stated.camera.rate);
    let noise = own.camera.noise / stated.camera.noise;
    assert!((0.7..1.4).contains(&noise), "{noise}");
    let text = std::fs::read_to_string(folder.path().join("own.toml")).unwrap();
    assert!(
        text.contains("/striker/state (nav_msgs/msg/Odometry"),
        "{text}"
    );
    let kept = |rig: &str| {
        let said = done(&format!("check {log} --rig {dir}/{rig}"));
        said["strikes"].as_u64().unwrap()
    };
    assert_eq!(kept("own.toml"), kept("rig/rig.toml"));
    // What was written says where it comes from.
    let lineages = logs::write::lineages(std::path::Path::new(&log)).unwrap();
    assert_eq!(lineages[0]["program"], "carom demo");
}

#[test]
fn what_cannot_be_worked_with_is_bad_input_that_names_what_and_where() {
    let (folder, dir) = demo("--strikes 1 --hide none");
    let rig = format!("--rig {dir}/rig/rig.toml --out {dir}/run");
    write(&folder.path().join("no.mcap"), "no log");
    write(&folder.path().join("bad.toml"), "[object]\nshpae = 1\n");
    std::fs::create_dir(folder.path().join("own")).unwrap();
    write(&folder.path().join("own/rig.toml"), "a person's");
    for (line, named) in [
        (format!("run {dir}/none {rig}"), "none"),
        (format!("run {dir}/no.mcap {rig}"), "no.mcap"),
        (
            format!("run {dir}/rig/logs --rig {dir}/bad.toml --out {dir}/run"),
            "shpae",
        ),
        (format!("run {dir}/rig/logs {rig}"), "log more strikes"),
        (format!("run {dir}/rig/logs {rig}"), "1 were kept"),
        (format!("demo --out {dir}/own"), "own/rig.toml is there"),
        (
            format!("demo --hide none --hide table_tilt --out {dir}/x"),
            "leave out one of them",
        ),
        (format!("sysid --out {dir}/nothing"), "carom ingest"),
        (format!("artifacts verify --artifacts {dir}"), "carom run"),
        (format!("demo --hide frction --out {dir}/x"), "friction"),
        (format!("rig init --out {dir}/bad.toml"), "bad.toml"),
    ] {
        let text = bad_input(&line);
        assert!(text.contains(named), "{line}: {text}");
    }
    let own = std::fs::read_to_string(folder.path().join("own/rig.toml"));
    assert_eq!(own.unwrap(), "a person's");
}

#[test]
fn logs_of_one_name_in_several_folders_are_other_sessions() {
    let (folder, dir) = demo("--strikes 40 --hide none");
    for day in 0..4 {
        let to = folder.path().join(format!("days/d{day}"));
        std::fs::create_dir_all(&to).unwrap();
        let log = folder.path().join(format!("rig/logs/session_00{day}.mcap"));
        std::fs::copy(&log, to.join("session.mcap")).unwrap();
    }
    let ingest = |logs: &str| {
        let options = format!("--rig {dir}/rig/rig.toml --out {dir}/run");
        answer(&format!("ingest {logs} {options}"));
        let strikes = tables::read_strikes(&folder.path().join("run")).unwrap();
        strikes
            .into_iter()
            .map(|strike| {
                assert_eq!(strike.conditions.session, strike.log);
                strike.log
            })
            .collect::<std::collections::BTreeSet<_>>()
    };
    let days = ["d0", "d1", "d2", "d3"].map(|day| format!("{day}/session.mcap"));
    assert_eq!(ingest(&format!("{dir}/days")), days.into());
    // Alone, a log is called as its file is.
    let one = ingest(&format!("{dir}/days/d1"));
    assert_eq!(one, ["session.mcap".to_string()].into());
}

#[test]
fn a_cut_off_log_gives_what_is_whole_and_says_so() {
    let (folder, dir) = demo("--strikes 10 --hide none");
    let log = folder.path().join("rig/logs/session_000.mcap");
    let bytes = std::fs::read(&log).unwrap();
    std::fs::write(&log, &bytes[..bytes.len() / 2]).unwrap();
    let line = format!("ingest {dir}/rig/logs --rig {dir}/rig/rig.toml --out {dir}");
    let said = answer(&line);
    assert_eq!(said.outcome, Outcome::Rejected);
    assert!(said.json["strikes"].as_u64() < Some(10));
    assert!(said.text.contains("session_000.mcap"), "{}", said.text);

    // Cut before the first strike, it is the cut that is reported.
    std::fs::write(&log, &bytes[..bytes.len() / 12]).unwrap();
    let text = bad_input(&line);
    assert!(
        text.contains("session_000.mcap is not whole") && text.contains("truncated at byte"),
        "{text}"
    );
}

#[test]
fn strikes_that_are_rejected_are_reported_with_an_example_of_each_reason() {
    let (folder, dir) = demo("--strikes 12 --hide none");
    let rig = std::fs::read_to_string(folder.path().join("rig/rig.toml")).unwrap();
    let ingest = |x: &str| {
        let other = rig.replace("x = [0.1, 1.0]", x);
        assert_ne!(other, rig);
        std::fs::write(folder.path().join("other.toml"), other).unwrap();
        answer(&format!(
            "ingest {dir}/rig/logs --rig {dir}/other.toml --out {dir}"
        ))
    };
    let some = ingest("x = [0.25, 1.0]");
    let example = "off_table, such as strike ";
    assert!(some.text.contains(example), "{}", some.text);
    // Where all are, the table is another: nothing is made of that.
    let none = ingest("x = [2.0, 3.0]");
    assert!(none.text.contains(example), "{}", none.text);
    assert_eq!(none.outcome, Outcome::Refused);
}

#[test]
fn logs_that_are_none_are_left_out_and_reported_and_the_others_are_read() {
    let (folder, dir) = demo("--strikes 12 --hide none");
    let line = format!("ingest {dir}/rig/logs --rig {dir}/rig/rig.toml --out {dir}");
    let before = done(&line);
    let logs = folder.path().join("rig/logs");
    let whole = std::fs::read(logs.join("session_000.mcap")).unwrap();
    std::fs::write(logs.join("empty.mcap"), "").unwrap();
    std::fs::write(logs.join("text.mcap"), "no log").unwrap();
    std::fs::write(logs.join("magic.mcap"), &whole[..8]).unwrap();
    // The first chunk holds the schemas: without it no message makes sense.
    let mut damaged = whole.clone();
    damaged[4000] ^= 1;
    std::fs::write(logs.join("damaged.mcap"), damaged).unwrap();
    std::os::unix::fs::symlink("nowhere", logs.join("dead.mcap")).unwrap();
    let pipe = std::process::Command::new("mkfifo")
        .arg(logs.join("pipe.mcap"))
        .status();
    assert!(pipe.unwrap().success());

    let said = answer(&line);
    assert_eq!(said.outcome, Outcome::Rejected);
    assert_eq!(said.json["strikes"], before["strikes"]);
    let left_out: Vec<_> = said.json["left_out"].as_array().unwrap().iter().collect();
    let mut names: Vec<_> = left_out
        .iter()
        .filter_map(|log| log["log"].as_str())
        .collect();
    names.sort_unstable();
    assert_eq!(names, ["dead.mcap", "empty.mcap", "pipe.mcap", "text.mcap"]);
    for name in names.iter().chain(&["damaged.mcap", "magic.mcap"]) {
        let line = said.text.lines().find(|line| line.contains(name));
        assert!(
            line.is_some_and(|line| line.len() > 40),
            "{name}: {}",
            said.text
        );
    }

    // Where none can be read, that is bad input.
    let text = bad_input(&format!(
        "ingest {dir}/rig/logs/empty.mcap --rig {dir}/rig/rig.toml --out {dir}/none"
    ));
    assert!(
        text.contains("empty.mcap") && text.contains("0 bytes"),
        "{text}"
    );
}
