//! Figures with their intervals, and those of every run whose page was committed: the last run beside all of them together.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use anyhow::Context;
use serde::{Deserialize, Serialize};
use statrs::distribution::{Beta, ContinuousCDF};

#[derive(Clone, Debug)]
pub struct Figure {
    /// What was measured; the same words in each run.
    pub what: &'static str,
    pub goal: &'static str,
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
    pub benchmark: String,
    /// The command that made it; a run of the same command takes its place.
    pub command: String,
    pub figures: BTreeMap<String, Proportion>,
}

/// All runs that were judged: `tests/judged.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Judged {
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

    pub(super) fn commands(&self, benchmark: &str) -> String {
        let runs = self.runs.iter().filter(|run| run.benchmark == benchmark);
        let commands: Vec<String> = runs.map(|run| format!("`{}`", run.command)).collect();
        commands.join(", ")
    }
}

/// A count out of a total.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Proportion {
    pub hits: usize,
    pub all: usize,
}

impl Proportion {
    pub fn of<T>(items: impl Iterator<Item = T>, hit: impl Fn(&T) -> bool) -> Self {
        items.fold(Self::default(), |so_far, item| Self {
            hits: so_far.hits + usize::from(hit(&item)),
            all: so_far.all + 1,
        })
    }

    /// The sum of both counts.
    pub fn plus(self, other: Self) -> Self {
        Self {
            hits: self.hits + other.hits,
            all: self.all + other.all,
        }
    }

    /// The share; 0 of 0 is 0.
    pub fn share(self) -> f64 {
        self.hits as f64 / self.all.max(1) as f64
    }

    /// 95 % interval of the share (Clopper and Pearson 1934); of 0 of 0, all shares.
    pub fn interval(self) -> (f64, f64) {
        let (hits, all) = (self.hits as f64, self.all as f64);
        let quantile = |a: f64, b: f64, p: f64| match Beta::new(a, b) {
            Ok(beta) => beta.inverse_cdf(p),
            Err(_) => f64::NAN,
        };
        let low = if self.hits == 0 {
            0.0
        } else {
            quantile(hits, all - hits + 1.0, 0.025)
        };
        let high = if self.hits == self.all {
            1.0
        } else {
            quantile(hits + 1.0, all - hits, 0.975)
        };
        (low, high)
    }
}

/// A proportion as percent with its interval and both counts; a dash for 0 of 0.
impl std::fmt::Display for Proportion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.all == 0 {
            return f.write_str("–");
        }
        let (low, high) = self.interval();
        write!(
            f,
            "{:.1} % [{:.1}, {:.1}] ({} of {})",
            100.0 * self.share(),
            100.0 * low,
            100.0 * high,
            self.hits,
            self.all
        )
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

    #[test]
    fn the_interval_is_that_of_clopper_and_pearson() {
        let (low, high) = Proportion { hits: 3, all: 200 }.interval();
        assert!((low - 0.003_1).abs() < 1e-4 && (high - 0.043_2).abs() < 1e-4);
        let none = Proportion { hits: 0, all: 20 };
        assert_eq!(none.to_string(), "0.0 % [0.0, 16.8] (0 of 20)");
        assert_eq!(Proportion::default().to_string(), "–");
    }
}
