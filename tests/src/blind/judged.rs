//! The figures of every run whose page was committed: the last run beside all of them together.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use anyhow::Context;
use serde::{Deserialize, Serialize};

use super::proportion::Proportion;

/// A figure beside what was to be reached.
#[derive(Clone, Debug)]
pub struct Figure {
    /// What was measured; the same words in each run.
    pub what: &'static str,
    /// What was to be reached.
    pub goal: &'static str,
    /// What came out.
    pub got: Proportion,
}

impl Figure {
    /// What was measured, what was to be reached, and what came out.
    pub fn new(what: &'static str, goal: &'static str, got: Proportion) -> Self {
        Self { what, goal, got }
    }
}

/// One run: its benchmark, its seeds, and its figures by what was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// `plain` or `hard`.
    pub benchmark: String,
    /// The command that made it; a run of the same command takes its place.
    pub command: String,
    /// Hits and all, by what was measured.
    pub figures: BTreeMap<String, Proportion>,
}

/// All runs that were judged: `tests/judged.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// In the order in which they were run.
    pub runs: Vec<Run>,
}

impl Judged {
    /// Reads the file; without one, no run was judged.
    pub fn load(path: &Path) -> anyhow::Result<Self> {
        match fs::read_to_string(path) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Self::default()),
            Err(error) => Err(error).with_context(|| format!("read {}", path.display())),
            Ok(text) => {
                serde_json::from_str(&text).with_context(|| format!("read {}", path.display()))
            }
        }
    }

    /// Writes the file.
    pub fn save(&self, path: &Path) -> anyhow::Result<()> {
        let text = serde_json::to_string_pretty(self)? + "\n";
        fs::write(path, text).with_context(|| format!("write {}", path.display()))
    }

    /// Notes a run, in place of an earlier one of the same command.
    pub fn note(&mut self, benchmark: &str, command: &str, figures: &[Figure]) {
        let run = Run {
            benchmark: benchmark.into(),
            command: command.into(),
            figures: figures
                .iter()
                .map(|figure| (figure.what.to_string(), figure.got))
                .collect(),
        };
        let same = |known: &&mut Run| known.benchmark == benchmark && known.command == command;
        match self.runs.iter_mut().find(same) {
            Some(known) => *known = run,
            None => self.runs.push(run),
        }
    }

    /// All runs of a benchmark together.
    fn pooled(&self, benchmark: &str, what: &str) -> Proportion {
        self.runs
            .iter()
            .filter(|run| run.benchmark == benchmark)
            .filter_map(|run| run.figures.get(what))
            .fold(Proportion::default(), |sum, one| sum.plus(*one))
    }

    /// Rows of a table: measured, to reach, the last run, all runs.
    pub(super) fn rows(&self, benchmark: &str, figures: &[Figure]) -> String {
        let mut text = String::new();
        for Figure { what, goal, got } in figures {
            let pooled = self.pooled(benchmark, what);
            let _ = writeln!(text, "| {what} | {goal} | {got} | {pooled} |");
        }
        text
    }

    /// The commands of all runs of a benchmark.
    pub(super) fn commands(&self, benchmark: &str) -> String {
        let runs = self.runs.iter().filter(|run| run.benchmark == benchmark);
        let commands: Vec<String> = runs.map(|run| format!("`{}`", run.command)).collect();
        commands.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_pooled_and_one_that_is_made_again_counts_once() {
        let mut judged = Judged::default();
        let figure = |hits, all| Figure::new("false alarms", "≤ 5 %", Proportion { hits, all });
        judged.note("hard", "one", &[figure(1, 10)]);
        judged.note("hard", "two", &[figure(3, 10)]);
        judged.note("hard", "two", &[figure(2, 10)]);
        judged.note("plain", "one", &[figure(9, 10)]);
        let pooled = judged.pooled("hard", "false alarms");
        assert_eq!((pooled.hits, pooled.all), (3, 20));
    }
}
