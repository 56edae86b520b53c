//! What a check of the logs found and measured.

use std::fmt::Write;

use check::{Check, Measured, Severity};
use serde_json::{Value, json};
use values::Rig;

use super::shared::wrapped;
use crate::first_version::FirstVersion;
use crate::words;

/// Findings of at least this severity, the gravest first.
pub fn findings(check: &Check, rig: &Rig, least: Severity) -> String {
    let mut text = String::new();
    for severity in [Severity::Meaningless, Severity::Doubtful, Severity::Told] {
        if severity < least {
            continue;
        }
        for finding in check.findings.iter().filter(|f| f.severity() == severity) {
            text += &wrapped(
                words::severity(severity),
                &words::say(finding, rig).sentence(),
            );
        }
    }
    text
}

/// Findings for machines, each with its words.
pub fn findings_json(check: &Check, rig: &Rig) -> Value {
    check
        .findings
        .iter()
        .map(|finding| {
            let mut value = json!(finding);
            value["severity"] = json!(finding.severity());
            value["words"] = json!(words::say(finding, rig));
            value
        })
        .collect()
}

/// Why a version is a candidate and not in use.
pub fn candidate(version: &str, gate: Option<&FirstVersion>) -> String {
    let mut text = format!("refused    {version} is a candidate, and not in use:\n");
    for doubt in gate.iter().flat_map(|gate| gate.doubts()) {
        text += &wrapped("", &doubt);
    }
    text
}

/// What was measured, a line each.
pub fn measured(measured: &Measured) -> String {
    let mut text = String::new();
    let mut line = |label: &str, value: Option<String>| {
        if let Some(value) = value {
            let _ = writeln!(text, "{label:<10} {value}");
        }
    };
    let coverage = &measured.coverage;
    let range = |[low, high]: [f64; 2]| format!("{low:.2} to {high:.2}");
    line(
        "coverage",
        (coverage.strikes > 0).then(|| {
            format!(
                "{} strikes, {} m/s, {} rad, from x {} and y {} m, {} repeats",
                coverage.strikes,
                range(coverage.speed),
                range(coverage.angle),
                range(coverage.x),
                range(coverage.y),
                coverage.repeats
            )
        }),
    );
    line(
        "frames",
        measured.turn.map(|turn| {
            format!(
                "objects leave {:.1}° beside the command, in the middle",
                turn.to_degrees()
            )
        }),
    );
    line(
        "speeds",
        measured.speed_ratio.map(|ratio| {
            format!("in their first 0.1 s objects move at {ratio:.2} times the commanded speed; a scale that is wrong by less than a half is not told from restitution")
        }),
    );
    line(
        "clocks",
        measured
            .rise_to_motion
            .map(|lag| format!("from a command's rise to the object's motion {lag:.3} s")),
    );
    line(
        "",
        measured.encoder_to_camera.map(|delay| {
            let [seconds, error] = delay.seconds;
            format!(
                "from the tip's touch, by its measured place, to the object's motion {:.1} ms (± {:.1})",
                seconds * 1e3,
                2.0 * error * 1e3
            )
        }),
    );
    line(
        "camera",
        measured.noise_at_rest.map(|noise| {
            format!(
                "a resting centroid scatters by {:.2} mm; {:.1} % of the frames are lost",
                noise * 1e3,
                measured.frames_lost * 100.0
            )
        }),
    );
    text
}
