//! `--batch`: a line in, a line out, in order, whatever the lines hold.

use serde_json::{Value, json};
use store::Model;
use strike::{Planner, batch};

use crate::fixture;

fn run(input: &[u8]) -> (Vec<Value>, batch::BatchCounts) {
    let planner = Planner::new(&fixture::artifact(), Model::SysidResidual).unwrap();
    let mut output = Vec::new();
    let counts = batch::run(&planner, input, &mut output).unwrap();
    let text = String::from_utf8(output).unwrap();
    let lines = text.lines().map(|line| serde_json::from_str(line).unwrap());
    (lines.collect(), counts)
}

#[test]
fn order_is_kept_and_junk_is_refused_by_its_line() {
    let long = format!("[{}]", "0,".repeat(50_000));
    let lines = [
        r#"{"from": [0.3, 0.05], "to": [0.6, 0.1]}"#.as_bytes(),
        b"",
        b"not json",
        br#"{"from": [0.3, 0.05], "to": [0.6, 0.1], "spin": 1}"#,
        br#"{"from": [0.3, 0.05]}"#,
        br#"{"from": [0.3], "to": [0.6, 0.1]}"#,
        br#"{"from": [NaN, 0.05], "to": [0.6, 0.1]}"#,
        br#"{"from": [1e999, 0.05], "to": [0.6, 0.1]}"#,
        &[0xff, 0xfe, 0x00],
        long.as_bytes(),
        br#"{"from": [0.3, 0.05], "to": [6.0, 0.1]}"#,
        br#"  {"to": [0.65, 0.0], "from": [0.3, 0.0]}"#,
    ];
    let (answers, counts) = run(&lines.join(&b'\n'));
    assert_eq!(answers.len(), 11);
    assert_eq!((counts.planned, counts.refused), (2, 9));
    assert_eq!(answers[0]["to"], json!([0.6, 0.1]));
    assert!(answers[0]["speed"].is_f64());
    for (answer, line) in answers[1..9].iter().zip(3..) {
        assert_eq!(answer["refused"], "malformed", "{answer}");
        assert!(answer["from"].is_null() && answer["to"].is_null());
        let detail = answer["detail"].as_str().unwrap();
        assert!(detail.starts_with(&format!("line {line}:")), "{detail}");
    }
    assert_eq!(answers[9]["refused"], "off_table");
    assert_eq!(answers[9]["to"], json!([6.0, 0.1]));
    assert_eq!(answers[10]["to"], json!([0.65, 0.0]));
}

#[test]
fn a_plan_and_a_refusal_have_the_contracts_keys() {
    let (answers, _) = run(
        b"{\"from\": [0.3, 0.05], \"to\": [0.6, 0.1]}\n{\"from\": [0.3, 0.05], \"to\": [9, 9]}\n",
    );
    let keys = |value: &Value| -> Vec<String> {
        let mut keys: Vec<_> = value.as_object().unwrap().keys().cloned().collect();
        keys.sort();
        keys
    };
    let plan = "acceleration angle angle_sim artifact d_angle d_speed expected_miss \
        expected_miss_strikes from if_as_before model path pre_strike speed speed_sim start stop strike to";
    assert_eq!(keys(&answers[0]).join(" "), plan);
    assert_eq!(keys(&answers[1]), ["detail", "from", "refused", "to"]);
    assert_eq!(answers[0]["model"], "sysid_residual");
}
