//! Logs and strikes that a version was not computed from.

use std::collections::BTreeSet;

use ingest::LogFile;
use store::{Artifact, InputFile};
use values::Strike;

/// Logs that a version was not computed from, by their content.
pub fn new_logs<'a>(
    before: Option<&Artifact>,
    logs: &'a [LogFile],
) -> impl Iterator<Item = &'a LogFile> {
    let known: BTreeSet<String> = before
        .iter()
        .flat_map(|before| &before.manifest.provenance.inputs)
        .map(|input| input.sha256.clone())
        .collect();
    logs.iter().filter(move |log| !known.contains(&log.sha256))
}

/// Logs that a version was computed from and that are no longer there as they were: they have grown, or are gone.
pub fn changed<'a>(before: &'a Artifact, logs: &[LogFile]) -> impl Iterator<Item = &'a InputFile> {
    let there: BTreeSet<String> = logs.iter().map(|log| log.sha256.clone()).collect();
    let known = before.manifest.provenance.inputs.iter();
    known.filter(move |input| !there.contains(&input.sha256))
}

/// Names of logs that a version was computed from, of which nothing is there now: neither their content nor, grown, their name.
pub fn gone(before: &Artifact, logs: &[LogFile]) -> Vec<String> {
    let is_absent = |input: &&InputFile| logs.iter().all(|log| log.name != input.name);
    let gone = changed(before, logs).filter(is_absent);
    gone.map(|input| input.name.clone()).collect()
}

/// Strikes that a version was not computed from: those of new logs; of a log that has grown, those after all that it knew. A
/// log has grown that holds a strike of one that has [`changed`]; those are `known`, by their ids.
pub fn new_strikes(
    before: &Artifact,
    logs: &[LogFile],
    strikes: &[Strike],
    known: &BTreeSet<String>,
) -> Vec<Strike> {
    let new: BTreeSet<&str> = new_logs(Some(before), logs)
        .map(|log| log.name.as_str())
        .collect();
    let grown: BTreeSet<&str> = strikes
        .iter()
        .filter(|strike| known.contains(&strike.id))
        .map(|strike| strike.log.as_str())
        .collect();
    let last = before.manifest.provenance.strikes;
    let last = last.map_or(f64::NEG_INFINITY, |known| known.last);
    let is_new = |strike: &&Strike| {
        let log = strike.log.as_str();
        new.contains(log) && (!grown.contains(log) || strike.t_start > last)
    };
    strikes.iter().filter(is_new).cloned().collect()
}
