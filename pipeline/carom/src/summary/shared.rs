//! What the overview and the details both print.

use std::fmt::Write;

use super::rejects::{examples, reasons};
use super::table::evaluation_table;
use crate::results::Results;

/// Strikes kept and rejected, and notes on logs: `most` lines of each, and how many more there are.
pub fn strikes(results: &Results, most: usize) -> String {
    let mut text = format!("strikes    {} kept", results.kept.len());
    if results.rejects.is_empty() {
        text += ", none rejected\n";
    } else {
        let (count, reasons) = (results.rejects.len(), reasons(&results.rejects));
        let _ = writeln!(text, ", {count} rejected: {reasons}");
        text += &first_lines(&examples(&results.rejects), most);
    }
    text += &first_lines(&results.log_notes, most);
    text
}

fn first_lines(lines: &[String], most: usize) -> String {
    let mut text = String::new();
    for line in lines.iter().take(most) {
        let _ = writeln!(text, "           {line}");
    }
    if lines.len() > most {
        let more = lines.len() - most;
        let _ = writeln!(text, "           {more} more: --verbose");
    }
    text
}

/// Why there is no diagnosis, or its world is not used; empty where neither holds.
pub fn unused_diagnosis(results: &Results) -> String {
    let mut text = String::new();
    let is_named = results.found.iter().any(|found| found.world.is_some());
    if is_named && results.effect.is_none() {
        text += "           not added to the world, as asked\n";
    }
    if let Some(why) = &results.no_diagnosis {
        let _ = writeln!(text, "diagnosis  none: {why}");
    }
    text
}

/// The table of stop errors; empty before evaluation.
pub fn stop_errors(results: &Results) -> String {
    results
        .evaluation
        .as_ref()
        .map_or(String::new(), |evaluation| {
            let table = evaluation_table(evaluation);
            format!("\nStop error on held-out strikes\n{table}")
        })
}
