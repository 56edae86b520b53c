//! The outcome of a night: `nightly.json`, and its text.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use ingest::LogFile;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use store::{Artifact, InputFile};
use values::Strike;

use super::change::Change;
use super::executor_gate::ExecutorGate;
use super::held_out_gate::HeldOutGate;
use crate::Error;
use crate::error::Outcome;
use crate::left_out::LeftOut;
use crate::outputs::write_json;
use crate::results::Results;
use crate::score::Drift;

/// Where a night is kept.
const FILE: &str = "nightly.json";

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Night {
    pub status: Status,
    /// Why, a sentence each.
    pub why: Vec<String>,
    /// The version in use when it began.
    pub before: Option<String>,
    /// The version in use from now on.
    pub latest: Option<String>,
    /// Days since it was put to use.
    #[serde(default)]
    pub in_use_for: Option<f64>,
    /// Root mean square of what the version before expected to miss by on the new strikes' paths, in m.
    #[serde(default)]
    pub promised: Option<f64>,
    /// Root mean square of what it missed them by, in m: predicted before it learnt from them.
    #[serde(default)]
    pub achieved: Option<f64>,
    /// The last change for good that was found.
    #[serde(default)]
    pub change: Option<Change>,
    /// Where what came out and was not put to use waits to be compared on strikes that it did not learn from: a version's name in the
    /// run's folder `candidate`.
    #[serde(default)]
    pub waiting: Option<String>,
    /// Logs that are not learnt from: their strikes scatter beyond chance.
    #[serde(default)]
    pub set_aside: Vec<String>,
    /// Whether tonight's new logs were set aside; never two nights running.
    #[serde(default)]
    pub quarantined: bool,
    pub logs: usize,
    /// Names of those that the version in use had not seen.
    pub new_logs: Vec<String>,
    /// Strikes kept, over all logs.
    pub strikes: usize,
    /// Strikes that are new to the version in use.
    pub new_strikes: usize,
    /// Strikes of new logs that are stamped before the last change: where none is stamped after it, a clock was set.
    #[serde(default)]
    pub behind: usize,
    pub rejected: usize,
    /// Names of logs that are cut off or damaged.
    pub damaged: Vec<String>,
    /// Logs that could not be read.
    pub left_out: Vec<LeftOut>,
    pub beats: Option<HeldOutGate>,
    pub executor: Option<ExecutorGate>,
    /// Whether the version in use does worse on the new strikes than on those that it was published with.
    pub drift: Option<Drift>,
    /// Effects that the data name now and that the version in use lacks.
    pub missing: Vec<Missing>,
    /// Old versions that were removed.
    pub removed: Vec<String>,
    /// Hash of all that the decision hangs on.
    pub basis: String,
}

/// How a night ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// A new version is in use.
    Promoted,
    /// Nothing better came out; the version before stays in use.
    Kept,
    /// There are not yet enough strikes for a first version.
    Gathering,
    /// Somebody must look: the executor cannot use what came out, or the table or the strikes are not what they were.
    Refused,
    #[default]
    NothingNew,
    /// The work failed; the version before stays in use.
    Failed,
}

/// An effect that the data name.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Missing {
    pub name: String,
    pub statement: String,
}

impl Night {
    /// A night in which nothing was decided yet.
    pub fn new(logs: &[LogFile], before: Option<&Artifact>, basis: String) -> Self {
        let version = before.map(|before| before.version.clone());
        Self {
            before: version.clone(),
            latest: version,
            logs: logs.len(),
            new_logs: new_logs(before, logs).map(|log| log.name.clone()).collect(),
            basis,
            ..Self::default()
        }
    }

    /// A night that failed. It has no basis: the next one tries again.
    pub fn failed(error: &Error, latest: Option<String>, last: Option<&Self>) -> Self {
        let night = Self::new(&[], None, String::new());
        Self {
            status: Status::Failed,
            before: latest.clone(),
            latest,
            why: vec![format!("failed to {error}")],
            ..last.map_or(night.clone(), |last| night.after(last))
        }
    }

    /// This night with what goes on from night to night.
    pub fn after(self, last: &Self) -> Self {
        Self {
            change: last.change.clone(),
            waiting: last.waiting.clone(),
            set_aside: last.set_aside.clone(),
            ..self
        }
    }

    /// A night after this one that has nothing to decide; what is wrong with its logs is what was.
    pub fn again(self, mut logs: Vec<LogFile>, before: Option<&Artifact>) -> Self {
        logs.retain(|log| self.left_out.iter().all(|left| left.log != log.name));
        let mut why = vec!["nothing has changed since last night".into()];
        if self.status == Status::Refused {
            let refusal = self.why.join("; ");
            why.push(format!("the last decision was a refusal: {refusal}"));
        }
        let version = before.map(|before| &before.version);
        Self {
            why,
            strikes: self.strikes,
            // What was put to use then was computed from them all.
            new_strikes: if version == self.before.as_ref() {
                self.new_strikes
            } else {
                0
            },
            rejected: self.rejected,
            quarantined: self.quarantined,
            change: self.change,
            waiting: self.waiting,
            set_aside: self.set_aside,
            damaged: self.damaged,
            left_out: self.left_out,
            ..Self::new(&logs, before, self.basis)
        }
    }

    pub fn record(&mut self, results: &Results) {
        self.strikes = results.strikes.len();
        self.new_strikes = results.strikes.len();
        self.rejected = results.read.rejects.len();
        self.damaged = results.read.damaged.clone();
        self.left_out = results.read.left_out.clone();
    }

    /// Stamp of the first strike since the last change for good, in s; of no change it is before all.
    pub fn since(&self) -> f64 {
        let change = self.change.as_ref();
        change.map_or(f64::NEG_INFINITY, |change| change.since)
    }

    /// Says why, a sentence more.
    pub fn because(&mut self, why: String) {
        self.why.push(why);
    }

    /// Effects that the data name and the version in use lacks.
    pub fn report_missing(&mut self, before: &Artifact, results: &Results) {
        let known = before.effect.as_ref().map(|effect| &effect.world.effects);
        let is_known = |name: &str| known.is_some_and(|all| all.iter().any(|one| one.name == name));
        let named = results
            .found()
            .into_iter()
            .flat_map(|found| &found.diagnosis.effects);
        self.missing = named
            .filter(|effect| !is_known(&effect.name))
            .map(|effect| Missing {
                name: effect.name.clone(),
                statement: effect.statement.to_string(),
            })
            .collect();
    }

    /// How the program ends.
    pub fn outcome(&self) -> Outcome {
        match self.status {
            Status::Failed => Outcome::Failed,
            Status::Refused => Outcome::Refused,
            Status::Promoted | Status::Kept | Status::Gathering | Status::NothingNew => {
                Outcome::of(
                    self.rejected == 0 && self.damaged.is_empty() && self.left_out.is_empty(),
                )
            }
        }
    }

    /// What was decided, in a line.
    pub fn headline(&self) -> String {
        let latest = self.latest.as_deref().unwrap_or("no version");
        match self.status {
            Status::Promoted => format!("{latest} is in use from now on"),
            Status::Kept => format!("nothing better tonight: {latest} stays in use"),
            Status::Gathering => {
                "nothing to promote yet: a first version needs more strikes".into()
            }
            Status::Refused => format!("somebody must look: {latest} stays in use"),
            Status::NothingNew => format!("nothing to decide: {latest} stays in use"),
            Status::Failed => "the work failed: what was in use stays in use".into(),
        }
    }

    /// In use, since when, what it promised and what came of it.
    fn in_use(&self) -> String {
        let mm = |metres: f64| format!("{:.2} mm", metres * 1e3);
        let mut line = format!("in use: {}", self.latest.as_deref().unwrap_or("no version"));
        if let Some(days) = self.in_use_for {
            line += &format!(", for {days:.1} days");
        }
        if let (Some(before), Some(promised), Some(achieved)) =
            (&self.before, self.promised, self.achieved)
        {
            line += &format!(
                "; {before} promised {} rms, and missed the newest strikes by {} rms",
                mm(promised),
                mm(achieved)
            );
        }
        line
    }

    /// The decision, drift, missing effects and damaged logs, a line each.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![self.in_use()];
        lines.extend(self.change.as_ref().map(Change::sentence));
        lines.extend(self.why.clone());
        lines.extend(self.drift.as_ref().map(Drift::sentence));
        if !self.set_aside.is_empty() {
            lines.push(format!(
                "not learnt from, for their strikes scatter beyond chance: {}; look at them and take away what is bad",
                self.set_aside.join(", ")
            ));
        }
        lines.extend(
            self.missing.iter().map(|missing| {
                format!("the data now name {}: {}", missing.name, missing.statement)
            }),
        );
        if self.rejected > 0 {
            lines.push(format!("{} strikes were rejected", self.rejected));
        }
        if !self.damaged.is_empty() {
            lines.push(format!("cut off or damaged: {}", self.damaged.join(", ")));
        }
        lines.extend(self.left_out.iter().map(LeftOut::sentence));
        if !self.removed.is_empty() {
            lines.push(format!("removed: {}", self.removed.join(", ")));
        }
        lines
    }

    pub fn text(&self) -> String {
        let mut text = format!("nightly    {}\n", self.headline());
        let new_to = self.before.as_deref().unwrap_or("carom");
        let _ = writeln!(
            text,
            "           {} logs, {} of them new to {new_to}; {} strikes, {} of them new to {new_to}",
            self.logs,
            self.new_logs.len(),
            self.strikes,
            self.new_strikes
        );
        for line in self.lines() {
            let _ = writeln!(text, "           {line}");
        }
        text
    }
}

/// The last night in a folder; none where there was none. Errors where it cannot be read: it alone knows of changes and of logs set aside.
pub fn kept(dir: &Path) -> Result<Option<Night>, Error> {
    let place = dir.join(FILE);
    let said = |error: &dyn std::fmt::Display| {
        Error::input(format!(
            "read {}: {error}; restore it from a copy, or take it away: the next night then knows of no change for good and of no log set aside",
            place.display()
        ))
    };
    match fs::read(&place) {
        Ok(bytes) => serde_json::from_slice(&bytes).map_err(|error| said(&error)),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(said(&error)),
    }
}

pub fn keep(dir: &Path, night: &Night) -> Result<(), Error> {
    write_json(&dir.join(FILE), night)
}

/// Lines on standard error, if they are wanted.
pub struct Log<'a> {
    is_wanted: bool,
    rig: Option<&'a str>,
}

impl<'a> Log<'a> {
    /// The log of a night, of a rig where it is one of a fleet.
    pub fn new(is_wanted: bool, rig: Option<&'a str>) -> Self {
        Self { is_wanted, rig }
    }

    /// One object on a line: `time` in seconds since the epoch, `level`, `event`, the `rig` of a fleet and what belongs to it.
    pub fn line(&self, level: &str, event: &str, more: &Value) {
        if !self.is_wanted {
            return;
        }
        let time = SystemTime::now().duration_since(UNIX_EPOCH);
        let mut line = json!({
            "time": time.map_or(0.0, |time| time.as_secs_f64()), "level": level, "event": event,
        });
        if let Some(rig) = self.rig {
            line["rig"] = rig.into();
        }
        if let (Some(line), Some(more)) = (line.as_object_mut(), more.as_object()) {
            line.extend(more.clone());
        }
        // The reader of standard error may have closed it; the night's work continues.
        let _ = std::io::Write::write_all(&mut std::io::stderr(), format!("{line}\n").as_bytes());
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_night_with_nothing_to_decide_repeats_the_last_refusal_and_counts_what_is_new_now() {
        let refused = Night {
            status: Status::Refused,
            why: vec!["8 at the least".into()],
            strikes: 60,
            new_strikes: 20,
            ..Night::failed(&Error::Refused(String::new()), None, None)
        };
        let again = refused.clone().again(Vec::new(), None);
        assert_eq!(again.status, Status::NothingNew);
        assert_eq!((again.strikes, again.new_strikes), (60, 20));
        assert_eq!(
            again.why[1],
            "the last decision was a refusal: 8 at the least"
        );
        // Another version is in use than that night began with: the one that it put to use.
        let promoted = Night {
            status: Status::Promoted,
            before: Some("v0001".into()),
            ..refused
        };
        let again = promoted.again(Vec::new(), None);
        assert_eq!((again.new_strikes, again.why.len()), (0, 1));
    }
}
