//! What the overview and the details both print, rejected strikes among it.

use std::collections::BTreeMap;
use std::fmt::Write;

use values::Reject;

use super::table::evaluation_table;
use crate::results::{Results, Worlds};

/// Characters of a line.
pub const WIDTH: usize = 100;
/// Width of a line's label.
const LABEL: usize = 10;

/// A sentence behind its label, on lines no longer than [`WIDTH`].
pub fn wrapped(label: &str, sentence: &str) -> String {
    lines(
        format!("{label:<LABEL$}"),
        LABEL,
        sentence.split_whitespace(),
    )
}

/// A line's beginning and items behind it, a blank before each, on as few lines as are no longer than [`WIDTH`].
pub fn lines<'i>(first: String, indent: usize, items: impl Iterator<Item = &'i str>) -> String {
    let mut text = String::new();
    let mut line = first;
    for item in items {
        if line.chars().count() + item.chars().count() + 1 > WIDTH {
            text += &line;
            text.push('\n');
            line = " ".repeat(indent);
        }
        line.push(' ');
        line += item;
    }
    text + &line + "\n"
}

/// What to look at on the rig before results are used.
pub fn warnings(results: &Results) -> String {
    let warnings = results.warnings();
    let lines = warnings.iter().map(|warning| wrapped("warning", warning));
    lines.collect()
}

/// Strikes kept and rejected, and notes on logs: `most` lines of each, and how many more there are.
pub fn strikes(results: &Results, most: usize) -> String {
    let mut text = format!("strikes    {} kept", results.read.strikes.len());
    if results.read.rejects.is_empty() {
        text += ", none rejected\n";
    } else {
        let (count, reasons) = (results.read.rejects.len(), reasons(&results.read.rejects));
        let _ = writeln!(text, ", {count} rejected: {reasons}");
        text += &first_lines(&examples(&results.read.rejects), most);
    }
    text += &first_lines(&results.read.notes, most);
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
pub fn unused_diagnosis(worlds: &Worlds) -> String {
    let mut text = String::new();
    let is_any = worlds.found().is_some_and(|found| found.used().is_some());
    if is_any && worlds.effect.is_none() {
        text += "           not added to the world, as asked\n";
    }
    if let Some(why) = worlds.no_diagnosis() {
        text += &wrapped("diagnosis", &format!("none: {why}"));
    }
    text
}

/// The table of stop errors; empty before evaluation.
pub fn stop_errors(results: &Results) -> String {
    results.evaluation().map_or(String::new(), |evaluation| {
        let table = evaluation_table(evaluation);
        format!("\nStop error on held-out strikes\n{table}")
    })
}

/// Rejected strikes by reason, such as "3 off_table, 1 truncated".
pub fn reasons(rejects: &[Reject]) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for reject in rejects {
        *counts.entry(reject.reason.name()).or_default() += 1;
    }
    let counts: Vec<String> = counts
        .iter()
        .map(|(reason, count)| format!("{count} {reason}"))
        .collect();
    counts.join(", ")
}

/// The first of each reason, in words.
pub fn examples(rejects: &[Reject]) -> Vec<String> {
    let mut firsts: BTreeMap<&str, &Reject> = BTreeMap::new();
    for reject in rejects {
        firsts.entry(reject.reason.name()).or_insert(reject);
    }
    let example = |(reason, first): (&str, &Reject)| {
        let Reject {
            log, index, detail, ..
        } = first;
        format!("{reason}, such as strike {index} of {log}: {detail}")
    };
    firsts.into_iter().map(example).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_sentence_takes_more_lines_and_loses_no_word() {
        let sentence = "the strikes want another size than the rig file's; ".repeat(5);
        let text = wrapped("warning", &sentence);
        assert!(text.lines().count() > 1, "{text}");
        assert!(
            text.lines().all(|line| line.chars().count() <= WIDTH),
            "{text}"
        );
        let words: Vec<&str> = text.split_whitespace().skip(1).collect();
        assert_eq!(words, sentence.split_whitespace().collect::<Vec<_>>());
    }
}
