//! What a run did, for people and for the manifest.

use std::fmt;

use serde::Serialize;

/// What one stage did in this run. Times are for people: no output holds them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageSummary {
    /// The stage's name.
    pub name: &'static str,
    /// Answers computed (items, for a stage that answers item by item).
    pub computed: usize,
    /// Answers taken from the cache.
    pub reused: usize,
    /// Kept answers that were damaged, and were not used.
    pub damaged: usize,
    /// Time spent, in s.
    pub seconds: f64,
}

/// What every stage did, in the order of their first use.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// One row a stage.
    pub stages: Vec<StageSummary>,
}

impl Summary {
    pub(crate) fn add(&mut self, row: StageSummary) {
        match self.stages.iter_mut().find(|old| old.name == row.name) {
            None => self.stages.push(row),
            Some(old) => {
                old.computed += row.computed;
                old.reused += row.reused;
                old.damaged += row.damaged;
                old.seconds += row.seconds;
            }
        }
    }

    /// Whether every answer came from the cache.
    pub fn is_all_reused(&self) -> bool {
        self.stages.iter().all(|stage| stage.computed == 0)
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:<12} {:>9} {:>9} {:>9}",
            "stage", "computed", "reused", "seconds"
        )?;
        for StageSummary {
            name,
            computed,
            reused,
            damaged,
            seconds,
        } in &self.stages
        {
            write!(f, "{name:<12} {computed:>9} {reused:>9} {seconds:>9.2}")?;
            match damaged {
                0 => writeln!(f)?,
                _ => writeln!(f, "  ({damaged} damaged in the cache, computed again)")?,
            }
        }
        Ok(())
    }
}

/// How a stage was run: what a manifest needs to run it again.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Record {
    /// The stage's name.
    pub name: &'static str,
    /// The stage's version.
    pub version: u32,
    /// Its settings.
    pub settings: serde_json::Value,
}
