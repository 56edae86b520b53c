//! Logs to strikes: the pipeline's first step, and what a score begins with.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use check::{Check, LogRead};
use ingest::{Ingest, IngestError, LogFile, LogOutcome, Seen, StrikeSummary, Strikes};
use stage::{Run, RunError};
use store::InputFile;
use values::{Reject, RejectReason, Rig, Strike};

use crate::left_out::LeftOut;
use crate::naming::{name_logs, names};
use crate::tracking::tracked;
use crate::{Error, Outcome, summary, told};

/// What the logs held.
pub struct Read {
    /// Strikes kept, in order of time.
    pub strikes: Strikes,
    /// Slides that no strike began, in order of time.
    pub slides: Vec<Strike>,
    /// Strikes seen and not kept.
    pub rejects: Vec<Reject>,
    /// The logs that were read, by name and hash.
    pub logs: Vec<LogFile>,
    /// For each of these logs that was made from images, the log with the images.
    pub images: BTreeMap<PathBuf, PathBuf>,
    pub left_out: Vec<LeftOut>,
    /// Names of logs that are cut off or damaged.
    pub damaged: Vec<String>,
    /// Warnings about the logs, each with the log's name.
    pub notes: Vec<String>,
    /// Whether they mean what the rig file says.
    pub check: Check,
    /// The rig file, with the fences that were found.
    pub rig: Rig,
}

impl Read {
    /// How the program ends where all of it is of use.
    pub fn outcome(&self) -> Outcome {
        Outcome::of(self.rejects.is_empty() && self.damaged.is_empty() && self.left_out.is_empty())
    }
}

/// Files that can be read, with their hashes, and those that cannot. Logs of one file name in several folders are named so
/// that they can be distinguished: they are other sessions.
pub fn open(run: &Run, paths: &[PathBuf]) -> (Vec<LogFile>, Vec<LeftOut>) {
    let hash = |path: &Path| Some(LogFile::open(path).ok()?.sha256);
    let hashes = told::of_each(run, "sha256", paths, hash);
    let (mut logs, mut unread) = (Vec::new(), Vec::new());
    for (path, hash) in paths.iter().zip(hashes) {
        let opened = match hash {
            None => LogFile::open(path),
            // Named below.
            Some(sha256) => Ok(LogFile {
                name: String::new(),
                sha256,
                path: path.clone(),
            }),
        };
        match opened {
            Ok(log) => logs.push(log),
            Err(error) => unread.push((path, error)),
        }
    }
    name_logs(&mut logs);
    // What cannot be read renames nothing that can.
    let known = logs
        .iter()
        .map(|log| (log.path.as_path(), log.sha256.as_str()));
    let others = unread
        .iter()
        .map(|(path, _)| (path.as_path(), path.to_str().unwrap_or_default()));
    let names = names(&known.chain(others).collect::<Vec<_>>());
    let left_out = unread.iter().zip(&names[logs.len()..]);
    let left_out = left_out.map(|((_, error), log)| LeftOut {
        log: log.clone(),
        why: error.to_string(),
    });
    let left_out = left_out.collect();
    (logs, left_out)
}

/// Reads the logs; each is read once, until its content changes. One that cannot be is left out, if another can.
pub fn read(run: &Run, rig: &Rig, logs: &[PathBuf], seed: u64) -> Result<Read, Error> {
    let tracked = tracked(run, run.dir(), rig, logs)?;
    let (mut logs, mut left_out) = open(run, &tracked.logs);
    left_out.extend(tracked.left_out);
    let mut ingest = |rig: &Rig, logs: &mut Vec<LogFile>| loop {
        match run.lists(&Ingest { seed }, rig, logs) {
            // It is written to while it is read: left out of this run, and nothing is kept of it.
            Err(RunError::Stage(error @ IngestError::Changed { .. })) => {
                let is_changed = |log: &LogFile| error.is_of(&log.path);
                let Some(place) = logs.iter().position(is_changed) else {
                    break Err(Error::input(error));
                };
                left_out.push(LeftOut {
                    log: logs.remove(place).name,
                    why: error.to_string(),
                });
            }
            Err(RunError::Stage(error @ IngestError::Log(_))) => break Err(Error::input(error)),
            lists => break lists.map_err(Error::from),
        }
    };
    let mut read = ingest(rig, &mut logs)?;
    let fences = ingest::fences(rig, read.iter().map(|(outcome, _)| &outcome.seen));
    let mut fenced = rig.clone();
    if !fences.is_empty() {
        // What they show of fences is a matter of all logs together: each is read once more, with them.
        fenced
            .table
            .fences
            .extend(fences.iter().map(|found| found.fence));
        read = ingest(&fenced, &mut logs)?;
    }
    for (outcome, _) in &read {
        let log = &outcome.log;
        left_out.extend(outcome.left_out.clone().map(|why| LeftOut {
            log: log.clone(),
            why,
        }));
    }
    let mut is_read = read.iter().map(|(outcome, _)| outcome.left_out.is_none());
    logs.retain(|_| is_read.next().unwrap_or(false));
    read.retain(|(outcome, _)| outcome.left_out.is_none());
    if let (true, Some(first)) = (logs.is_empty(), left_out.first()) {
        return Err(Error::input(first.why.clone()));
    }
    let notes = read.iter().flat_map(|(outcome, _)| {
        let note = |note| format!("{}: {note}", outcome.log);
        outcome.notes.iter().map(note)
    });
    let mut notes: Vec<String> = left_out
        .iter()
        .map(LeftOut::sentence)
        .chain(tracked.notes.iter().cloned())
        .chain(notes)
        .collect();
    let damaged = read.iter().filter(|(outcome, _)| !outcome.whole);
    let damaged: Vec<_> = damaged.map(|(outcome, _)| outcome.log.clone()).collect();
    let mend = read.iter().find_map(|(outcome, _)| missing(outcome));
    let mend = mend.or_else(|| {
        let untracked = tracked.notes.first()?;
        Some(format!(
            "{untracked}; check the object's colour and shape and the camera's pose in the rig file"
        ))
    });
    let has_no_clock = |(outcome, _): &(LogOutcome<StrikeSummary>, _)| {
        let mut rejects = outcome.rejects.iter();
        outcome.strikes.is_empty()
            && rejects.next().is_some()
            && rejects.all(|reject| reject.reason == RejectReason::ClockBackwards)
    };
    let has_no_clock = read.iter().all(has_no_clock);
    let mend = mend.unwrap_or_else(|| match has_no_clock {
        true => format!(
            "have the drivers of {} and {} fill in `{}` from one running clock, and record anew",
            rig.topics.centroid.name, rig.topics.command.name, rig.topics.centroid.stamp
        ),
        false => "check the topics and the table's bounds in the rig file".into(),
    });
    let seen: Vec<LogSeen> = read
        .iter()
        .map(|(outcome, _)| LogSeen::of(outcome))
        .collect();
    let slides = slides(&seen);
    let (strikes, rejects) = Strikes::join(read);
    notes.extend_from_slice(strikes.notes());
    let mut check = check::check(rig, &log_reads(&seen, &rejects), &fences);
    if let Some(rough) = check.rough_delay() {
        // Touches tell it to a ms, once they are seen at about their time.
        let mut late = fenced.clone();
        late.frames.camera_delay += rough;
        if let Ok(again) = run.lists(&Ingest { seed }, &late, &logs) {
            let seen: Vec<LogSeen> = again
                .iter()
                .map(|(outcome, _)| LogSeen::of(outcome))
                .collect();
            let (_, rejects) = Strikes::join(again);
            let again = check::check(&late, &log_reads(&seen, &rejects), &fences);
            check = Check::refined(rough, again).unwrap_or(check);
        }
    }
    // Where it is known why nothing was kept, that is said.
    if strikes.is_empty() && slides.is_empty() && !check.is_meaningless() {
        return Err(Error::input(format!(
            "find strikes: none was kept in {} logs ({}); {mend}",
            logs.len(),
            if rejects.is_empty() {
                "no command rises and falls".into()
            } else {
                let examples = summary::examples(&rejects).join("; ");
                format!("{}; {examples}", summary::reasons(&rejects))
            }
        )));
    }
    Ok(Read {
        strikes,
        slides,
        rejects,
        logs,
        images: tracked.images,
        left_out,
        damaged,
        notes,
        check,
        rig: fenced,
    })
}

/// What a log showed, apart from its strikes.
struct LogSeen {
    name: String,
    seen: Seen,
    kept: usize,
}

impl LogSeen {
    fn of(outcome: &LogOutcome<StrikeSummary>) -> Self {
        Self {
            name: outcome.log.clone(),
            seen: outcome.seen.clone(),
            kept: outcome.strikes.len(),
        }
    }
}

/// Slides of all logs that no strike began, each once.
fn slides(seen: &[LogSeen]) -> Vec<Strike> {
    let mut slides: Vec<Strike> = seen
        .iter()
        .flat_map(|log| log.seen.slides.clone())
        .collect();
    slides.sort_by(|a, b| {
        a.t_start
            .total_cmp(&b.t_start)
            .then_with(|| a.id.cmp(&b.id))
    });
    slides.dedup_by(|again, first| again.id == first.id);
    slides
}

fn log_reads<'a>(seen: &'a [LogSeen], rejects: &'a [Reject]) -> Vec<LogRead<'a>> {
    let read = |log: &'a LogSeen| LogRead {
        name: &log.name,
        seen: &log.seen,
        kept: log.kept,
        rejects: rejects
            .iter()
            .filter(|reject| reject.log == log.name)
            .collect(),
    };
    seen.iter().map(read).collect()
}

/// Ids of the strikes that were found in a log as it was; none where the cache no longer holds them.
pub fn known(
    run: &Run,
    rig: &Rig,
    seed: u64,
    log: &InputFile,
) -> Result<Option<Vec<String>>, Error> {
    let settings = Ingest { seed };
    let log = LogFile {
        name: log.name.clone(),
        sha256: log.sha256.clone(),
        path: PathBuf::new(),
    };
    let kept = run.kept_list(&settings, rig, &log)?;
    Ok(kept.map(|(outcome, _)| outcome.strikes.into_iter().map(|found| found.id).collect()))
}

/// Where strikes of a log may be that is not whole, and how to mend it.
fn missing(outcome: &LogOutcome<StrikeSummary>) -> Option<String> {
    let why = outcome.notes.first().filter(|_| !outcome.whole)?;
    let log = &outcome.log;
    Some(format!(
        "{log} is not whole, and strikes may lie in what is missing ({why}): copy it again, or record anew"
    ))
}
