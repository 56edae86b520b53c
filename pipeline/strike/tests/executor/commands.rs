//! The program: answers, exit codes, and what it refuses before any robot is touched.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use strike::Reason;
use values::Rig;

use crate::fixture;

pub fn strike(artifacts: &Path, arguments: &[&str]) -> Output {
    command(artifacts, arguments).output().unwrap()
}

/// The program, ready to start, with its answers caught.
pub fn command(artifacts: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_strike"));
    command
        .arg("--artifacts")
        .arg(artifacts)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

pub fn stdout(output: &Output) -> &str {
    std::str::from_utf8(&output.stdout).unwrap()
}

pub fn stderr(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).unwrap()
}

/// Runs it on a good artifact.
fn code(arguments: &[&str]) -> (i32, String, String) {
    let dir = fixture::published();
    let output = strike(dir.path(), arguments);
    assert!(!dir.path().join("strikes").exists(), "nothing was struck");
    (
        output.status.code().unwrap(),
        stdout(&output).into(),
        stderr(&output).into(),
    )
}

const GOOD: [&str; 6] = ["--from", "0.3", "0.05", "--to", "0.6", "0.1"];

fn good_and(more: &[&'static str]) -> Vec<&'static str> {
    [GOOD.as_slice(), more].concat()
}

#[test]
fn an_address_of_a_store_that_is_none_is_named() {
    for (name, value) in [
        ("AWS_ENDPOINT", "localhost:5920"),
        ("AWS_ENDPOINT_URL", ""),
        ("AWS_ACCESS_KEY_ID", "a\nb"),
    ] {
        let home = tempfile::tempdir().unwrap();
        let output = command("s3://bucket/table".as_ref(), &GOOD)
            .env(name, value)
            .env("HOME", home.path())
            .output()
            .unwrap();
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(name), "{said}");
        assert!(std::fs::read_dir(home.path()).unwrap().next().is_none());
    }
}

#[test]
fn the_version_alone_asks_for_the_programs_own() {
    for flag in ["--version", "-V"] {
        let output = Command::new(env!("CARGO_BIN_EXE_strike"))
            .arg(flag)
            .output()
            .unwrap();
        let text = stdout(&output);
        assert!(output.status.success(), "{}", stderr(&output));
        for said in [
            "strike 0.",
            "commit ",
            "engine: MuJoCo 3.",
            "formats: versions ",
        ] {
            assert!(text.contains(said), "{said}: {text}");
        }
    }
}

#[test]
fn a_second_target_is_not_passed_over() {
    for more in [["--to", "0.7", "0.0"], ["--from", "0.3", "0.0"]] {
        let (code, _, err) = code(&good_and(&more));
        assert_eq!(code, 2, "{err}");
    }
}

#[test]
fn a_plan_is_printed_for_a_person_with_positions_and_times() {
    let (code, out, err) = code(&GOOD);
    assert_eq!(code, 0);
    assert!(err.contains("no key is configured"), "{err}");
    let words = "v0001|simulated|residual|command|m/s|rad|t s|start|pre-strike|strike|stop";
    for said in words.split('|') {
        assert!(out.contains(said), "{said}: {out}");
    }
}

#[test]
fn a_plan_is_printed_for_a_machine_as_one_object() {
    let (code, out, _) = code(&good_and(&["--json", "--model", "sysid"]));
    assert_eq!(code, 0);
    let plan: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(plan["artifact"], "v0001");
    assert_eq!(plan["model"], "sysid");
    assert_eq!(plan.as_object().unwrap().len(), 19);
}

#[test]
fn the_default_model_is_the_artifacts_best() {
    let (_, out, _) = code(&good_and(&["--json"]));
    let plan: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(plan["model"], fixture::DEFAULT.name());
}

#[test]
fn without_a_start_the_object_is_laid_in_the_middle_of_the_trained_paths() {
    let (code, out, _) = code(&["--to", "0.7", "0.0", "--json"]);
    assert_eq!(code, 0);
    let plan: Value = serde_json::from_str(&out).unwrap();
    assert!(
        (plan["from"][0].as_f64().unwrap() - 0.35).abs() < 1e-9,
        "{plan}"
    );
}

#[test]
fn a_refusal_exits_4_and_is_an_object_too() {
    let arguments = ["--from", "0.3", "0.0", "--to", "0.5", "-0.9"];
    let (exit, out, err) = code(&arguments);
    assert_eq!((exit, out.as_str()), (4, ""));
    assert!(err.contains("refused: off_table:"), "{err}");

    let (exit, out, _) = code(&[arguments.as_slice(), &["--json"]].concat());
    assert_eq!(exit, 4);
    let refusal: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(refusal["refused"], "off_table");

    let (exit, _, err) = code(&[
        "--from", "nan", "0.0", "--to", "0.5", "0.1", "--robot", "sim",
    ]);
    assert_eq!(exit, 4);
    assert!(err.contains("not_finite"), "{err}");
}

#[test]
fn wrong_usage_exits_2_and_says_how_to_mend_it() {
    for (arguments, said) in [
        (vec![], "--to"),
        (vec!["--to", "0.5"], "2 values"),
        (vec!["--to", "a", "b"], "invalid"),
        (vec!["--from", "0.3", "0.0"], "--to"),
        (good_and(&["--model", "magic"]), "sysid_residual"),
        (good_and(&["--robot", "xarm"]), "host"),
        (good_and(&["--robot", "toaster"]), "`dry-run`"),
        (
            vec!["--to", "0.6", "0.0", "--robot", "ur:127.0.0.1"],
            "where the object lies",
        ),
        (good_and(&["--batch", "-"]), "cannot be used with"),
        (good_and(&["--log", "a.mcap"]), "add --robot sim"),
        (good_and(&["--version", "v0009"]), "v0009"),
        (vec!["--batch", "/none/such"], "/none/such"),
    ] {
        let (exit, out, err) = code(&arguments);
        assert_eq!((exit, out.as_str()), (2, ""), "{arguments:?}: {err}");
        assert!(err.contains(said), "{arguments:?}: {err}");
    }
}

#[test]
fn a_robot_that_moves_needs_a_key_and_its_own_rig_file() {
    let dir = fixture::published();
    let rig = dir.path().join("robot.toml");
    fs::write(&rig, fixture::rig().to_toml()).unwrap();
    // Nothing answers at this address: what is refused before has connected to nothing.
    let usual = good_and(&["--robot", "xarm:127.0.0.1", "--json"]);
    let with_rig = [usual.as_slice(), &["--rig", rig.to_str().unwrap()]].concat();
    let with_key = [usual.as_slice(), &["--key", "/none/such"]].concat();
    for (arguments, said) in [
        (&usual, "no key is configured"),
        (&with_rig, "no key is configured"),
        (&with_key, "rig file is not configured"),
    ] {
        let output = strike(dir.path(), arguments);
        assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
        let refusal: Value = serde_json::from_str(stdout(&output)).unwrap();
        assert_eq!(refusal["refused"], "not_trusted");
        assert!(refusal["detail"].as_str().unwrap().contains(said));
    }
}

#[test]
fn every_end_is_one_object_where_a_machine_asks() {
    let dir = fixture::published();
    let rig = dir.path().join("robot.toml");
    let mut other = fixture::rig();
    other.object.mass = 0.3;
    fs::write(&rig, other.to_toml()).unwrap();
    let json = good_and(&["--json"]);
    let object = |artifacts: &Path, more: &[&str], code: i32| -> Value {
        let output = strike(artifacts, &[json.as_slice(), more].concat());
        assert_eq!(output.status.code(), Some(code), "{}", stderr(&output));
        serde_json::from_str(stdout(&output)).unwrap()
    };
    let refusal = object(dir.path(), &["--rig", rig.to_str().unwrap()], 4);
    assert_eq!(refusal["refused"], "other_rig");
    assert!(refusal["detail"].as_str().unwrap().contains("mass"));
    for (artifacts, more, said) in [
        (Path::new("/none/such"), [].as_slice(), "/none/such"),
        (dir.path(), &["--version", "v0009"], "v0009"),
        (dir.path(), &["--key", "/none/key"], "/none/key"),
    ] {
        let end = object(artifacts, more, 2);
        assert!(end["failed"].as_str().unwrap().contains(said), "{end}");
    }
}

#[test]
fn a_bad_target_without_a_start_is_blamed_on_the_target() {
    for (to, said) in [
        (["nan", "0.1"], "not_finite: `to` is (NaN, 0.1)"),
        (["3", "0.1"], "off_table: `to` (3.0000, 0.1000)"),
        (
            ["0.97", "0.0"],
            "outside_trained_region: the target's x in m is 0.9700",
        ),
    ] {
        let (exit, out, err) = code(&["--to", to[0], to[1]]);
        assert_eq!((exit, out.as_str()), (4, ""), "{to:?}: {err}");
        assert!(err.contains(said), "{to:?}: {err}");
    }
    // The middle of the trained paths begins beyond the trained starts, or off the table: another start is taken.
    for x in ["0.85", "0.25"] {
        let (_, _, err) = code(&["--to", x, "0.0"]);
        let of_start = err.contains("the object's x") || err.contains("off_table");
        assert!(!of_start, "{x}: {err}");
    }
}

/// Strikes the embedded rig, with this rig file of the robot's own.
fn strike_as(artifacts: &Path, rig: &Rig) -> Output {
    let path = artifacts.join("robot.toml");
    fs::write(&path, rig.to_toml()).unwrap();
    let own = ["--rig", path.to_str().unwrap(), "--robot", "sim"];
    strike(artifacts, &[GOOD.as_slice(), &own].concat())
}

#[test]
fn a_robots_own_rig_file_may_be_stricter_and_then_counts() {
    let dir = fixture::published();
    let plan = |rig: &Rig| strike_as(dir.path(), rig);
    let mut strict = fixture::rig();
    strict.robot.acceleration = 4.0;
    let output = plan(&strict);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stdout(&output).contains("acceleration 4.000"));

    strict.robot.speed.high = 0.45;
    let output = plan(&strict);
    assert_eq!(output.status.code(), Some(4));
    let err = stderr(&output);
    assert!(
        err.contains("speed_limit") && err.contains("[0.4000, 0.4500]"),
        "{err}"
    );

    let mut wide = fixture::rig();
    wide.robot.speed.high = 1.2;
    let output = plan(&wide);
    assert_eq!(output.status.code(), Some(4));
    assert!(stderr(&output).contains("other_rig"), "{}", stderr(&output));
}

#[test]
fn a_named_version_is_used_in_place_of_the_latest() {
    let dir = fixture::published();
    fixture::publish(dir.path(), 2);
    let plan = |arguments: &[&str]| -> Value {
        let output = strike(
            dir.path(),
            &[GOOD.as_slice(), &["--json"], arguments].concat(),
        );
        serde_json::from_slice(&output.stdout).unwrap()
    };
    assert_eq!(plan(&[])["artifact"], "v0002");
    assert_eq!(plan(&["--version", "v0001"])["artifact"], "v0001");
}

#[test]
fn a_tampered_artifact_is_refused_before_any_robot_is_touched() {
    for (file, after) in [
        ("world.toml", ""),
        ("residual.safetensors", ""),
        ("rig.toml", ""),
        ("manifest.json", "\"sha256\":"),
        ("manifest.json", "\"trained_region\":"),
        ("manifest.json", "\"metrics\":"),
        ("manifest.json", "\"strikes\":"),
    ] {
        let dir = fixture::published();
        let path = dir.path().join("versions/v0001").join(file);
        let mut bytes = fs::read(&path).unwrap();
        // A digit for another: still a file of its format.
        let after = String::from_utf8_lossy(&bytes).find(after).unwrap() + after.len();
        let digit = bytes[after..].iter().position(u8::is_ascii_digit).unwrap();
        let at = after + digit;
        bytes[at] = if bytes[at] == b'1' { b'2' } else { b'1' };
        fs::write(&path, bytes).unwrap();
        let output = strike(dir.path(), &good_and(&["--robot", "sim"]));
        assert_eq!(output.status.code(), Some(2), "{file}: {}", stderr(&output));
        assert_eq!(stdout(&output), "", "{file}");
        let text = stderr(&output);
        assert!(
            text.contains("v0001") && !text.contains("is whole"),
            "{text}"
        );
        assert!(!dir.path().join("strikes").exists(), "{file}");
    }
}

#[test]
fn an_artifact_of_another_rig_is_refused() {
    let dir = fixture::published();
    let mut other = fixture::rig();
    other.striker.radius = 0.02;
    let output = strike_as(dir.path(), &other);
    assert_eq!(output.status.code(), Some(4));
    assert!(stderr(&output).contains("[striker] radius is 0.012 in the artifact, 0.02 here"));
    assert!(!dir.path().join("strikes").exists());
    let same = strike_as(dir.path(), &fixture::rig());
    assert_eq!(same.status.code(), Some(0));
}

#[test]
fn a_batch_answers_line_by_line_and_shows_by_its_code_that_lines_were_refused() {
    let dir = fixture::published();
    let batch = |input: &[u8]| {
        let mut child = command(dir.path(), &["--batch", "-"])
            .stdin(Stdio::piped())
            .spawn()
            .unwrap();
        child.stdin.take().unwrap().write_all(input).unwrap();
        child.wait_with_output().unwrap()
    };
    let good = b"{\"from\": [0.3, 0.05], \"to\": [0.6, 0.1]}\n";
    let output = batch(good);
    assert_eq!(output.status.code(), Some(0));
    assert!(stderr(&output).contains("1 planned, 0 refused"));
    let output = batch(&[good, b"junk\n".as_slice(), good].concat());
    assert_eq!(output.status.code(), Some(3));
    assert_eq!(stdout(&output).lines().count(), 3);
    assert!(stdout(&output).lines().nth(1).unwrap().contains("line 2"));
}

#[test]
fn a_batch_may_be_asked_line_by_line() {
    let dir = fixture::published();
    let mut child = command(dir.path(), &["--quiet", "--batch", "-"])
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    let mut ask = child.stdin.take().unwrap();
    let mut answers = BufReader::new(child.stdout.take().unwrap());
    for x in ["0.6", "0.65", "0.55"] {
        writeln!(ask, "{{\"from\": [0.3, 0.05], \"to\": [{x}, 0.1]}}").unwrap();
        let mut answer = String::new();
        answers.read_line(&mut answer).unwrap();
        assert!(answer.contains(&format!("\"to\":[{x},0.1]")), "{answer}");
    }
    drop(ask);
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

#[test]
fn help_shows_examples_and_exit_codes() {
    let output = Command::new(env!("CARGO_BIN_EXE_strike"))
        .arg("--help")
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0));
    for said in "Examples:|--batch|Exit codes:|other_rig|not_trusted|not_ready".split('|') {
        assert!(stdout(&output).contains(said), "{said}");
    }
    for reason in Reason::ALL {
        assert!(stdout(&output).contains(reason.name()), "{reason:?}");
    }
}
