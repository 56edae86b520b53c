//! Logs with images and no centroids, before they are ingested: each is tracked once, until it, the rig's camera or the object changes.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use logs::Limits;
use logs::read::{RawSummary, read_raw};
use serde::{Deserialize, Serialize};
use serde_json::json;
use stage::Run;
use track::{TrackError, TrackOutcome, track_log};
use values::Rig;

use crate::Error;
use crate::left_out::LeftOut;
use crate::told;

/// Where a run keeps the logs with centroids that it made.
const FOLDER: &str = "tracked";
/// What is kept there beside a log.
const FRAMES: &str = "frames.json";
/// Raised when the same images give other centroids.
const VERSION: u32 = 13;

/// Logs to ingest.
#[derive(Debug, Default)]
pub struct Tracked {
    /// The logs that were given; in the place of one that has images and no centroids the log with centroids.
    pub logs: Vec<PathBuf>,
    /// For each log that was made, the log with the images that it was made from: these are not copied.
    pub images: BTreeMap<PathBuf, PathBuf>,
    /// Logs whose images are of no use.
    pub left_out: Vec<LeftOut>,
    /// For each log with frames that have no centroid, how many and why.
    pub notes: Vec<String>,
}

/// What is kept beside a log with centroids.
#[derive(Debug, Serialize, Deserialize)]
struct Frames {
    /// SHA-256 of the log with the images.
    sha256: String,
    frames: TrackOutcome,
}

/// Tracks what needs it, into the folder of a run: each log by one of those who work there.
pub fn tracked(run: &Run, dir: &Path, rig: &Rig, logs: &[PathBuf]) -> Result<Tracked, Error> {
    let mut tracked = Tracked::default();
    let Some(images) = &rig.topics.image else {
        tracked.logs = logs.to_vec();
        return Ok(tracked);
    };
    let topics = [&*images.name, &*rig.topics.centroid.name];
    let needs = told::of_each(run, &format!("{topics:?}"), logs, |log| {
        needs_tracking(topics, log)
    });
    let needs = needs.into_iter().map(|sha256| {
        let sha256 = sha256.filter(|sha256| !sha256.is_empty())?;
        Some(ToTrack {
            key: key(rig, &sha256),
            sha256,
        })
    });
    let needs: Vec<Option<ToTrack>> = needs.collect();
    let to_track = logs.iter().zip(&needs);
    let to_track: Vec<(&PathBuf, &ToTrack)> = to_track
        .filter_map(|(log, needs)| Some((log, needs.as_ref()?)))
        .collect();
    let size = |log: &Path| fs::metadata(log).map_or(0, |metadata| metadata.len());
    let jobs = to_track.iter();
    let jobs: Vec<(String, u64)> = jobs.map(|(log, to)| (to.key.clone(), size(log))).collect();
    let folder = dir.join(FOLDER);
    let kept = |job: usize| {
        let (log, to) = to_track[job];
        Ok::<_, Error>(kept(&folder, log, to).map(Ok))
    };
    let make = |job: usize| {
        let (log, to) = to_track[job];
        make(&folder, rig, log, to, run.writer())
    };
    let made = run.each("track", &jobs, &folder, kept, make)?;
    let mut made = made.into_iter();
    for (log, needs) in logs.iter().zip(&needs) {
        match needs.as_ref().and_then(|_| made.next()) {
            None => tracked.logs.push(log.clone()),
            Some(Ok((path, outcome))) => {
                if outcome.centroids < outcome.frames {
                    let note = format!("{}: {}", name(log), outcome.sentence());
                    tracked.notes.push(note);
                }
                tracked.images.insert(path.clone(), log.clone());
                tracked.logs.push(path);
            }
            Some(Err(why)) => tracked.left_out.push(LeftOut {
                log: name(log),
                why,
            }),
        }
    }
    Ok(tracked)
}

/// Removes what killed workers left, from the folder of a run that works alone.
pub fn sweep(dir: &Path) -> Result<(), Error> {
    let folder = dir.join(FOLDER);
    if folder.is_dir() {
        durable::sweep(&folder)?;
    }
    Ok(())
}

/// A log with images and no centroids.
struct ToTrack {
    sha256: String,
    /// The name of its folder.
    key: String,
}

/// A log with centroids and the outcome of its frames.
type Made = (PathBuf, TrackOutcome);

/// The hash of a log that has images and no centroids; empty of one that is ingested as it is. What is wrong with a log is reported then.
fn needs_tracking([images, centroids]: [&str; 2], log: &Path) -> Option<String> {
    let read: Result<RawSummary, TrackError> = read_raw(log, Limits::default(), &mut |_| Ok(()));
    let summary = read.ok()?;
    let needs = summary.has(images) && !summary.has(centroids);
    Some(if needs { summary.sha256 } else { String::new() })
}

/// What the centroids depend on.
fn key(rig: &Rig, sha256: &str) -> String {
    let what = json!({
        "version": VERSION, "log": sha256, "object": rig.object, "camera": rig.camera, "topics": rig.topics,
        "table": rig.table, "speed": rig.robot.speed,
    });
    durable::sha256(what.to_string().as_bytes())[..16].to_owned()
}

fn kept(folder: &Path, log: &Path, to: &ToTrack) -> Option<Made> {
    let folder = folder.join(&to.key);
    let path = folder.join(name(log));
    let text = fs::read_to_string(folder.join(FRAMES)).ok()?;
    let kept: Frames = serde_json::from_str(&text).ok()?;
    path.is_file().then_some((path, kept.frames))
}

/// Makes it; why not, where the log is of no use.
fn make(
    folder: &Path,
    rig: &Rig,
    log: &Path,
    to: &ToTrack,
    writer: &str,
) -> Result<Result<Made, String>, Error> {
    let folder = folder.join(&to.key);
    durable::create_dir(&folder)?;
    let path = folder.join(name(log));
    // Aside, for another worker may make it at the same time.
    let aside = folder.join(format!(".{}.{writer}.partial", name(log)));
    match track_log(log, rig, &aside, None) {
        Ok(frames) => {
            durable::rename(&aside, &path)?;
            let kept = Frames {
                sha256: to.sha256.clone(),
                frames,
            };
            let text = serde_json::to_string_pretty(&kept).map_err(Error::failed)? + "\n";
            let file = folder.join(FRAMES);
            durable::write_as(writer, &file, |out| {
                out.write_all(text.as_bytes())
                    .map_err(|source| durable::Error::new("write", &file, source))
            })?;
            Ok(Ok((path, kept.frames)))
        }
        Err(error @ (TrackError::Setup(_) | TrackError::NoTopic)) => Err(Error::input(error)),
        Err(error @ (TrackError::Write(_) | TrackError::File(_))) => Err(Error::failed(error)),
        Err(error) => Ok(Err(error.to_string())),
    }
}

fn name(log: &Path) -> String {
    let name = log.file_name().unwrap_or(log.as_os_str());
    name.to_string_lossy().into_owned()
}
