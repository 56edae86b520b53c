//! One log: its messages into the segmenter, and what is told of the file.

use std::path::Path;

use logs::read::Extent;
use logs::{Event, Limits, Summary, Wanted};
use values::{Reject, RejectReason, Rig, Strike};

use crate::segment::{Closing, Segmenter};
use crate::{Found, Ingest, IngestError, LogOutcome};

const CENTROID: usize = 0;
const COMMAND: usize = 1;

/// Reads one log from end to end.
///
/// # Errors
/// A file that cannot be read or is no MCAP; topics or fields of the rig file that it does not have. What is merely
/// cut off or damaged is no error: strikes that are whole are kept, those that are not are rejected as truncated.
pub fn ingest_log(path: &Path, rig: &Rig, settings: &Ingest) -> Result<LogOutcome, IngestError> {
    let mut strikes = Vec::new();
    let keep = &mut |strike| strikes.push(strike);
    let outcome = read_log(path, &file_name(path), rig, settings, keep)?;
    // Of a log that is not to be trusted none is kept.
    strikes.truncate(outcome.strikes.len());
    Ok(outcome.with_strikes(|_| strikes))
}

/// A file's name, without folder.
pub(crate) fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// The same, of a log by its name; each strike is handed over when it is found, and what stays of it is what tells it from
/// others.
pub(crate) fn read_log(
    path: &Path,
    log: &str,
    rig: &Rig,
    settings: &Ingest,
    keep: &mut dyn FnMut(Strike),
) -> Result<LogOutcome<Found>, IngestError> {
    let wanted = [
        Wanted {
            topic: &rig.topics.centroid,
            required: true,
        },
        Wanted {
            topic: &rig.topics.command,
            required: true,
        },
    ];
    let mut segmenter = Segmenter::new(log, rig, settings.seed, keep);
    let summary = logs::read(path, &wanted, Limits::default(), &mut |event| match event {
        Event::Sample(CENTROID, sample) => segmenter.centroid(sample),
        Event::Sample(_, sample) => segmenter.command(sample),
        Event::Lost(damage) => segmenter.close(Closing::Lost(damage.why.clone())),
    })?;
    segmenter.close(Closing::End);
    let segmented = segmenter.finish();
    let mut outcome = LogOutcome {
        left_out: None,
        whole: summary
            .damage
            .iter()
            .all(|damage| damage.extent == Extent::Index),
        strikes: segmented.strikes,
        rejects: segmented.rejects,
        notes: notes(&summary, rig),
        log: log.into(),
        sha256: summary.sha256.clone(),
        messages: summary.messages,
    };
    outcome.notes.extend(segmented.notes);
    if let Some(damage) = summary
        .damage
        .iter()
        .find(|damage| damage.extent == Extent::Unlocated)
    {
        distrust(&mut outcome, &damage.why);
    }
    Ok(outcome)
}

/// Somewhere in the log a message is wrong, and nothing tells where: no strike of it is kept.
fn distrust(outcome: &mut LogOutcome<Found>, why: &str) {
    let log = &outcome.log;
    outcome
        .rejects
        .extend(outcome.strikes.drain(..).map(|strike| Reject {
            log: log.clone(),
            index: strike.index,
            t_start: strike.t_start,
            reason: RejectReason::Truncated,
            detail: format!("the log is damaged, and it cannot be told where: {why}"),
        }));
    outcome.rejects.sort_by_key(|reject| reject.index);
}

/// So many damaged places of a log are told one by one.
const PLACES: usize = 10;

fn notes(summary: &Summary, rig: &Rig) -> Vec<String> {
    let mut notes: Vec<String> = summary
        .damage
        .iter()
        .take(PLACES)
        .map(|damage| match damage.extent {
            Extent::Rest => format!("truncated at byte {}: {}", damage.offset, damage.why),
            Extent::Part => format!("damaged at byte {}: {}", damage.offset, damage.why),
            Extent::Unlocated => format!("damaged before byte {}: {}", damage.offset, damage.why),
            Extent::Index => format!(
                "all messages were read, but the index is not whole: {}",
                damage.why
            ),
        })
        .collect();
    if summary.damage.len() > PLACES {
        let more = summary.damage.len() - PLACES;
        notes.push(format!("damaged in {more} more places"));
    }
    for topic in [&rig.topics.centroid, &rig.topics.command] {
        if summary.topics.iter().all(|there| there.name != topic.name) {
            notes.push(format!(
                "nothing tells of topic {}: it may be in what is damaged",
                topic.name
            ));
        }
    }
    for (index, topic) in [
        (CENTROID, &rig.topics.centroid),
        (COMMAND, &rig.topics.command),
    ] {
        let (count, why) = &summary.undecodable[index];
        if *count > 0 {
            notes.push(format!(
                "{count} messages of {} could not be decoded, the first because {why}",
                topic.name
            ));
        }
        if summary.unstamped[index] {
            notes.push(format!(
                "{} has no `{}`: log times were taken",
                topic.name, topic.stamp
            ));
        }
    }
    notes
}
