//! What a run tells on one screen: strikes, the verdict as a list, the table of stop errors, and what to do next.

use std::fmt::Write;

use diagnose::{Diagnosis, Parameter, Verdict};

use super::diagnosis::{gap_in_brief, numbers, verdict};
use super::rejects::{examples, reasons};
use super::table::evaluation_table;
use crate::outputs::NEXT_STRIKES;
use crate::results::Results;

/// Lines on rejected strikes, and on logs, that are shown; `--verbose` prints all.
const MOST_LINES: usize = 6;

/// The overview of a run's results.
pub fn overview(results: &Results) -> String {
    let mut text = strikes(results);
    if let Some(fit) = &results.fit {
        let _ = writeln!(
            text,
            "sysid      tracks of {} strikes: {:.1} mm rms before, {:.1} mm after",
            fit.strikes,
            fit.rms_before * 1e3,
            fit.rms_after * 1e3
        );
    }
    if let Some(found) = &results.found {
        text += &diagnosis(&found.diagnosis);
        if found.world.is_some() && results.effect.is_none() {
            text += "           not added to the world, as asked\n";
        }
    }
    if let Some(why) = &results.no_diagnosis {
        let _ = writeln!(text, "diagnosis  none: {why}");
    }
    if let Some(evaluation) = &results.evaluation {
        text += "\nStop error on held-out strikes\n";
        text += &evaluation_table(evaluation);
    }
    text
}

fn strikes(results: &Results) -> String {
    let mut text = format!("strikes    {} kept", results.kept.len());
    if results.rejects.is_empty() {
        text += ", none rejected\n";
    } else {
        let (count, reasons) = (results.rejects.len(), reasons(&results.rejects));
        let _ = writeln!(text, ", {count} rejected: {reasons}");
        text += &first_lines(&examples(&results.rejects));
    }
    text += &first_lines(&results.log_notes);
    text
}

/// The first lines, indented, and how many more there are.
fn first_lines(lines: &[String]) -> String {
    let mut text = String::new();
    for line in lines.iter().take(MOST_LINES) {
        let _ = writeln!(text, "           {line}");
    }
    if lines.len() > MOST_LINES {
        let more = lines.len() - MOST_LINES;
        let _ = writeln!(text, "           {more} more: --verbose");
    }
    text
}

/// The verdict, one effect a line, the gap, and what to do next.
fn diagnosis(diagnosis: &Diagnosis) -> String {
    let mut text = format!("diagnosis  {}\n", verdict(diagnosis.verdict));
    for effect in &diagnosis.effects {
        let values: Vec<String> = effect
            .parameters
            .iter()
            .map(|(name, parameter)| value(name, parameter))
            .collect();
        let _ = writeln!(text, "           {}: {}", effect.name, values.join(", "));
        if !effect.equivalent.is_empty() {
            let others = effect.equivalent.join(", ");
            let _ = writeln!(text, "             not told apart from: {others}");
        }
    }
    if diagnosis.verdict == Verdict::Unexplained {
        let depends: Vec<&str> = diagnosis
            .r#where
            .iter()
            .map(|place| place.covariate.as_str())
            .collect();
        if !depends.is_empty() {
            let _ = writeln!(
                text,
                "           the gap depends on: {}",
                depends.join(", ")
            );
        }
    }
    let _ = writeln!(text, "           {}", gap_in_brief(&diagnosis.gap));
    text += &next(diagnosis);
    text
}

/// Such as `tilt_x 0.0041 [0.0037, 0.0046] rad`.
fn value(name: &str, parameter: &Parameter) -> String {
    let [value, low, high] = numbers(parameter);
    let text = format!("{name} {value} [{low}, {high}] {}", parameter.unit);
    text.trim_end().to_owned()
}

fn next(diagnosis: &Diagnosis) -> String {
    let count = diagnosis.next_strikes.len();
    match (diagnosis.verdict, count) {
        (Verdict::Consistent, _) => "next       nothing is missing: `strike` it\n".into(),
        (_, 1..) => {
            format!("next       the {count} strikes in {NEXT_STRIKES} would tell more\n")
        }
        (Verdict::Named, 0) => "next       check the effects on the rig: see the report\n".into(),
        (Verdict::Unexplained, 0) => "next       the report shows what the gap depends on\n".into(),
    }
}
