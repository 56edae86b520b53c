//! Logs with images and no centroids, before they are ingested: each is tracked once, until it, the rig's camera or the object changes.

use std::fs;
use std::path::{Path, PathBuf};

use logs::Limits;
use logs::read::{RawSummary, read_raw};
use serde::{Deserialize, Serialize};
use serde_json::json;
use track::{TrackError, TrackOutcome, track_log};
use values::Rig;

use crate::Error;
use crate::left_out::LeftOut;

/// Where a run keeps the logs with centroids that it made.
const FOLDER: &str = "tracked";
/// Raised when the same images give other centroids.
const VERSION: u32 = 6;

/// Logs to ingest.
#[derive(Debug, Default)]
pub struct Tracked {
    /// Those that were given; of those that have images and no centroids the log with centroids.
    pub logs: Vec<PathBuf>,
    /// Logs whose images are of no use.
    pub left_out: Vec<LeftOut>,
    /// Of each log with frames that have no centroid, how many and why.
    pub notes: Vec<String>,
}

/// What is kept beside a log with centroids.
#[derive(Debug, Serialize, Deserialize)]
struct Frames {
    /// SHA-256 of the log with the images.
    sha256: String,
    frames: TrackOutcome,
}

/// Tracks what needs it.
pub fn tracked(dir: &Path, rig: &Rig, logs: &[PathBuf]) -> Result<Tracked, Error> {
    let mut tracked = Tracked::default();
    for log in logs {
        let Some(sha256) = needs_tracking(rig, log) else {
            tracked.logs.push(log.clone());
            continue;
        };
        match made(dir, rig, log, sha256) {
            Ok((path, outcome)) => {
                if outcome.centroids < outcome.frames {
                    let note = format!("{}: {}", name(log), outcome.sentence());
                    tracked.notes.push(note);
                }
                tracked.logs.push(path);
            }
            Err(Failure::Log(why)) => tracked.left_out.push(LeftOut {
                log: name(log),
                why,
            }),
            Err(Failure::Run(error)) => return Err(error),
        }
    }
    Ok(tracked)
}

/// The hash of a log that has images and no centroids. What is wrong with a log is reported when it is ingested.
fn needs_tracking(rig: &Rig, log: &Path) -> Option<String> {
    let images = rig.topics.image.as_ref()?;
    let read: Result<RawSummary, TrackError> = read_raw(log, Limits::default(), &mut |_| Ok(()));
    let summary = read.ok()?;
    let needs = summary.has(&images.name) && !summary.has(&rig.topics.centroid.name);
    needs.then_some(summary.sha256)
}

enum Failure {
    /// The log is of no use.
    Log(String),
    /// The run cannot go on.
    Run(Error),
}

/// The log with centroids and the outcome of its frames; it is made if it is not there.
fn made(
    dir: &Path,
    rig: &Rig,
    log: &Path,
    sha256: String,
) -> Result<(PathBuf, TrackOutcome), Failure> {
    let what = json!({
        "version": VERSION, "log": sha256, "object": rig.object, "camera": rig.camera, "topics": rig.topics,
        "table": rig.table, "speed": rig.robot.speed,
    });
    let key = durable::sha256(what.to_string().as_bytes());
    let folder = dir.join(FOLDER).join(&key[..16]);
    let path = folder.join(name(log));
    let frames_file = folder.join("frames.json");
    if path.is_file()
        && let Ok(text) = fs::read_to_string(&frames_file)
        && let Ok(kept) = serde_json::from_str::<Frames>(&text)
    {
        return Ok((path, kept.frames));
    }
    durable::create_dir(&folder).map_err(|error| Failure::Run(error.into()))?;
    match track_log(log, rig, &path, None) {
        Ok(frames) => {
            let kept = Frames { sha256, frames };
            let text = serde_json::to_string_pretty(&kept);
            let text = text.map_err(|error| Failure::Run(Error::failed(error)))? + "\n";
            durable::write_bytes(&frames_file, text.as_bytes())
                .map_err(|error| Failure::Run(error.into()))?;
            Ok((path, kept.frames))
        }
        Err(error @ (TrackError::Setup(_) | TrackError::NoTopic)) => {
            Err(Failure::Run(Error::input(error)))
        }
        Err(error @ (TrackError::Write(_) | TrackError::File(_))) => {
            Err(Failure::Run(Error::failed(error)))
        }
        Err(error) => Err(Failure::Log(error.to_string())),
    }
}

fn name(log: &Path) -> String {
    let name = log.file_name().unwrap_or(log.as_os_str());
    name.to_string_lossy().into_owned()
}
