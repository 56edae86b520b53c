//! One log: its messages into the segmenter, and what is reported of the file.

use std::path::Path;

use logs::read::Extent;
use logs::{Event, Limits, LogError, Summary, TopicRequest};
use values::{
    CommandFrame, FieldTopic, Point, PoseTopic, Reject, RejectReason, Rig, Sentence, StateTopic,
    Strike,
};

use crate::arm::State;
use crate::episode::EndOfData;
use crate::error::IngestError;
use crate::frames::LogFrames;
use crate::notes::Note;
use crate::outcome::{LogOutcome, StrikeSummary, file_name};
use crate::rejection::Detail;
use crate::segment::{CommandSource, Segmenter};
use crate::settings::Ingest;
use crate::unmeasured::Unmeasured;
use crate::yaw::YawSample;

const OBJECT: usize = 0;
const COMMAND: usize = 1;
const STATE: usize = 2;
const POSE: usize = 3;

/// Reads one log from end to end.
///
/// # Errors
/// A file that cannot be read or is no MCAP; topics or fields of the rig file that it does not have. What is merely
/// cut off or damaged is no error: strikes that are whole are kept, those that are not are rejected as truncated.
pub fn ingest_log(path: &Path, rig: &Rig, settings: &Ingest) -> Result<LogOutcome, IngestError> {
    let mut strikes = Vec::new();
    let keep = &mut |strike| strikes.push(strike);
    let outcome = read_log(path, &file_name(path), rig, settings.seed, keep)?;
    // Of a log that is not to be trusted none is kept.
    strikes.truncate(outcome.strikes.len());
    Ok(outcome.with_strikes(|_| strikes))
}

/// Ingests a log that has this name; each strike is handed over when it is found, and what stays of it is what distinguishes it from
/// others. The object's place comes from its centroids; from its poses in a log that has those and no centroids.
pub(crate) fn read_log(
    path: &Path,
    log: &str,
    rig: &Rig,
    seed: u64,
    keep: &mut dyn FnMut(Strike),
) -> Result<LogOutcome<StrikeSummary>, IngestError> {
    let (centroid, pose) = (&rig.topics.centroid, &rig.topics.pose.topic);
    let is_there = |summary: &Summary, topic: &FieldTopic| {
        let mut topics = summary.topics.iter();
        topics.any(|there| there.name == topic.name && there.messages > 0)
    };
    let mut any_kept = false;
    let by_centroids = {
        let keep = &mut |strike| {
            any_kept = true;
            keep(strike);
        };
        read_by_either(centroid, path, log, rig, seed, keep)
    };
    let has_poses_alone = match &by_centroids {
        Ok((_, summary)) => !any_kept && !is_there(summary, centroid) && is_there(summary, pose),
        Err(LogError::MissingTopic { topic, found, .. }) => {
            *topic == centroid.name && names(found, &pose.name)
        }
        Err(_) => false,
    };
    let (outcome, _) = if has_poses_alone {
        read_by_either(pose, path, log, rig, seed, keep)?
    } else {
        by_centroids?
    };
    Ok(outcome)
}

/// Whether a topic of this name is among those that an error lists.
fn names(found: &[String], name: &str) -> bool {
    found
        .iter()
        .any(|there| there.split(' ').next() == Some(name))
}

/// Reads a log with the object's place from one topic; by the arm's state where no command is logged, or none that tells a direction.
fn read_by_either(
    object: &FieldTopic,
    path: &Path,
    log: &str,
    rig: &Rig,
    seed: u64,
    keep: &mut dyn FnMut(Strike),
) -> Result<(LogOutcome<StrikeSummary>, Summary), LogError> {
    let by_state = CommandSource::State;
    if rig.frames.command == CommandFrame::Tool {
        return read_by(object, by_state, path, log, rig, seed, keep);
    }
    let (command, state) = (&rig.topics.command.name, &rig.topics.state.topic.name);
    let by_commands = read_by(object, CommandSource::Topic, path, log, rig, seed, keep);
    let has_none = match &by_commands {
        Ok((_, summary)) => {
            let has = |name: &String| {
                let topic = summary.topics.iter().find(|topic| topic.name == *name);
                topic.is_some_and(|topic| topic.messages > 0)
            };
            !has(command) && has(state)
        }
        Err(LogError::MissingTopic { topic, found, .. }) => topic == command && names(found, state),
        Err(_) => false,
    };
    match has_none {
        true => read_by(object, by_state, path, log, rig, seed, keep),
        false => by_commands,
    }
}

/// Reads a log by one source of commands.
fn read_by(
    object: &FieldTopic,
    source: CommandSource,
    path: &Path,
    log: &str,
    rig: &Rig,
    seed: u64,
    keep: &mut dyn FnMut(Strike),
) -> Result<(LogOutcome<StrikeSummary>, Summary), LogError> {
    let PoseTopic {
        topic: pose,
        orientation,
    } = &rig.topics.pose;
    let StateTopic {
        topic: state,
        position_x,
        position_y,
    } = &rig.topics.state;
    let orientation = ["x", "y", "z", "w"].map(|part| format!("{orientation}.{part}"));
    let position = [position_x.clone(), position_y.clone()];
    let is_pose = object.name == pose.name;
    let wanted = |topic, more, required| TopicRequest {
        topic,
        more,
        required,
    };
    let topics = [
        wanted(object, if is_pose { &orientation[..] } else { &[] }, true),
        wanted(&rig.topics.command, &[], source == CommandSource::Topic),
        wanted(state, &position, source == CommandSource::State),
        wanted(pose, &orientation, false),
    ];
    // Of a topic that is wanted twice, the first one is read.
    let topics = &topics[..if is_pose { POSE } else { POSE + 1 }];
    let frames = LogFrames::of(rig);
    let mut segmenter = Segmenter::new(log, rig, source, seed, keep);
    let mut unmeasured = Unmeasured::default();
    let summary = logs::read(path, topics, Limits::default(), &mut |event| match event {
        Event::Sample(OBJECT, sample) => segmenter.centroid(frames.centroid(sample)),
        Event::Sample(_, sample) if source == CommandSource::Topic => {
            segmenter.command(frames.command(sample));
        }
        Event::Sample(..) => {}
        Event::Extended(STATE, sample, more) => {
            let state = unmeasured.filled(State {
                stamp: sample.stamp,
                velocity: Point::new(sample.x, sample.y),
                position: Point::new(more[0], more[1]),
            });
            let state = frames.state(state);
            if source == CommandSource::State {
                segmenter.command(state.as_command());
            }
            segmenter.state(state);
        }
        Event::Extended(index, sample, [quaternion @ .., _]) => {
            let sample = frames.centroid(sample);
            if let Some(turn) = YawSample::of(sample.stamp, quaternion) {
                let yaw = frames.yaw(turn.yaw);
                segmenter.turn(YawSample { yaw, ..turn });
            }
            if index == OBJECT {
                segmenter.centroid(sample);
            }
        }
        Event::Lost(damage) => segmenter.close(EndOfData::Lost(damage.why.clone())),
    })?;
    segmenter.close(EndOfData::End);
    let mut segmented = segmenter.finish();
    segmented.seen.slow = slow(&summary);
    let notes = notes(&summary, topics).into_iter().chain(segmented.notes);
    let mut outcome = LogOutcome {
        left_out: None,
        whole: summary
            .damage
            .iter()
            .all(|damage| damage.extent == Extent::Index),
        strikes: segmented.strikes,
        rejects: segmented.rejects,
        notes: notes.map(Sentence::from).collect(),
        log: log.into(),
        sha256: summary.sha256.clone(),
        messages: summary.messages,
        seen: segmented.seen,
    };
    if let Some(damage) = summary
        .damage
        .iter()
        .find(|damage| damage.extent == Extent::Unlocated)
    {
        distrust(&mut outcome, &damage.why);
    }
    if unmeasured.any {
        let topic = state.name.clone();
        outcome.notes.push(Note::NoVelocity { topic }.into());
    }
    let slides = outcome.seen.slides.len();
    if slides > 0 {
        outcome.notes.push(Note::Slides(slides).into());
    }
    Ok((outcome, summary))
}

/// How many times as slow the camera's stamps go as those of commands, or of states: where all are of a simulated time they are slow alike. None where
/// the arm's do not tell, or log times are of something else than the recording, as of a conversion.
fn slow(summary: &Summary) -> Option<[f64; 2]> {
    /// A clock that runs wrong does so by less.
    const POSSIBLE: std::ops::Range<f64> = 0.8..1.25;
    let of = |topic: usize| summary.paces.get(topic).copied().flatten();
    // Commands without stamps are of the recorder's clock.
    let arm = match summary.unstamped.get(COMMAND) {
        Some(true) => Some([1.0, 0.0]),
        _ => of(COMMAND).or(of(STATE)),
    };
    let ([camera, error], [arm, arm_error]) = (of(OBJECT)?, arm?);
    let ratio = camera / arm;
    let relative = (error / camera).hypot(arm_error / arm);
    POSSIBLE
        .contains(&ratio)
        .then_some([ratio, ratio * relative])
}

/// Somewhere in the log a message is wrong, and nothing shows where: no strike of it is kept.
fn distrust(outcome: &mut LogOutcome<StrikeSummary>, why: &str) {
    let log = &outcome.log;
    outcome
        .rejects
        .extend(outcome.strikes.drain(..).map(|strike| Reject {
            log: log.clone(),
            index: strike.index,
            t_start: strike.t_start,
            reason: RejectReason::Truncated,
            detail: Detail::DamagedSomewhere { why: why.into() }.into(),
        }));
    outcome.rejects.sort_by_key(|reject| reject.index);
    outcome.seen.slides.clear();
}

/// Greatest number of damaged places of a log that are listed one by one.
const PLACES: usize = 10;

fn notes(summary: &Summary, wanted: &[TopicRequest<'_>]) -> Vec<Note> {
    let listed = summary.damage.iter().take(PLACES);
    let listed = listed.map(|damage| {
        let (offset, why) = (damage.offset, damage.why.clone());
        match damage.extent {
            Extent::Rest => Note::Truncated { offset, why },
            Extent::Part => Note::Damaged { offset, why },
            Extent::Unlocated => Note::DamagedBefore { offset, why },
            Extent::Index => Note::IndexDamaged { why },
        }
    });
    let mut notes: Vec<Note> = listed.collect();
    if summary.damage.len() > PLACES {
        notes.push(Note::DamagedInMore(summary.damage.len() - PLACES));
    }
    for (
        index,
        TopicRequest {
            topic, required, ..
        },
    ) in wanted.iter().enumerate()
    {
        if *required && summary.topics.iter().all(|there| there.name != topic.name) {
            let topic = topic.name.clone();
            notes.push(Note::NoTopic { topic });
        }
        let (count, why) = &summary.undecodable[index];
        if *count > 0 {
            notes.push(Note::Undecodable {
                count: *count,
                topic: topic.name.clone(),
                why: why.clone(),
            });
        }
        if summary.unstamped[index] {
            notes.push(Note::Unstamped {
                topic: topic.name.clone(),
                stamp: topic.stamp.to_string(),
            });
        }
    }
    notes
}
