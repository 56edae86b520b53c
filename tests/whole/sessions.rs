//! What a version promises in sessions that it has never seen, and what it then misses by.

use serde_json::Value;

use crate::{carom, mean};

/// Mean of what the plans expected, in m.
fn expected(table: &Value, model: &str) -> f64 {
    table[model]["expected_miss"].as_f64().expect("a number")
}

#[test]
fn what_is_promised_in_new_sessions_is_kept() {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path().display();
    carom(&format!(
        "demo --strikes 120 --seed 5 --hide friction_by_session=0.12 --out {dir}/rig"
    ));
    let run = carom(&format!(
        "run {dir}/rig/logs --rig {dir}/rig/rig.toml --out {dir}"
    ));
    // Held-out strikes of known sessions, and the same as if their sessions had never been seen.
    let evaluation = &run.json["stop_error"];
    let known = mean(&evaluation["models"], "effect");
    let unseen = mean(&evaluation["new_sessions"]["models"], "effect");
    assert_eq!(evaluation["new_sessions"]["sessions"], 4);
    assert!(unseen > 3.0 * known, "{known} {unseen}");

    let trial = carom(&format!(
        "trial --artifacts {dir} --robot sim --targets 48 --repeats 1 --sessions 8"
    ));
    let trial = trial.json;
    assert_eq!(trial["session"], "session_003.mcap");
    let (promised, missed) = (expected(&trial, "effect"), mean(&trial, "effect"));
    println!("known session: promised {promised:.4} m, missed by {missed:.4} m");
    assert!((0.5..2.0).contains(&(missed / promised)));
    let new = &trial["new_sessions"];
    assert_eq!(new["sessions"], 8);
    let (promised, missed) = (expected(new, "effect"), mean(new, "effect"));
    println!("new sessions: promised {promised:.4} m, missed by {missed:.4} m");
    assert!(
        (0.5..2.0).contains(&(missed / promised)),
        "{promised} {missed}"
    );
    // With one session's friction in place of the mean it missed by more than what plain sysid misses by.
    assert!(missed < 1.5 * mean(new, "sysid"));
}
