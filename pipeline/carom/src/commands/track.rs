//! `carom track`: images to centroids.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;
use track::{TrackError, TrackOutcome, track_log};

use crate::Error;
use crate::error::{Outcome, Output};
use crate::fetching::Fetch;
use crate::inputs::{find_logs, load_rig};
use crate::naming::names;

/// `carom track`.
#[derive(Args, Debug)]
pub struct TrackArgs {
    /// MCAP files, or folders that are searched for them with all below.
    #[arg(required = true, value_name = "LOGS")]
    pub logs: Vec<PathBuf>,
    /// The rig file: its camera's lens and pose, the object's shape and colour, the topic of images.
    #[arg(long, value_name = "FILE")]
    pub rig: PathBuf,
    /// Folder to write: for each log one with its other messages, the centroids, and the outcome of every frame.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Also write a log for viewers: the images with the outline and centre found, and the object's pose; of one log.
    #[arg(long, value_name = "FILE")]
    pub view: Option<PathBuf>,
}

/// Tracks each log by itself; one that cannot be is left out.
pub fn run(args: &TrackArgs) -> Result<Output, Error> {
    let rig = load_rig(&args.rig)?;
    let logs = find_logs(
        &args.logs,
        &Fetch {
            rig: None,
            run: None,
        },
    )?;
    if let (Some(_), [_, _, ..]) = (&args.view, &logs[..]) {
        let why = "view several logs in one: name one log with --view";
        return Err(Error::input(why));
    }
    fs::create_dir_all(&args.out).map_err(|error| {
        let folder = args.out.display();
        Error::input(format!(
            "create the folder {folder}: {error}; name another with --out"
        ))
    })?;
    let files: Vec<_> = logs
        .iter()
        .map(|log| (log.as_path(), log.to_str().unwrap_or_default()))
        .collect();
    let (mut text, mut tracked, mut left_out) = (String::new(), Vec::new(), Vec::new());
    let mut is_all_used = true;
    for (log, name) in logs.iter().zip(names(&files)) {
        let out = args
            .out
            .join(name.trim_start_matches('/').replace('/', "_"));
        if is_same(&out, log) {
            let why = "write over the log that is read; name another folder with --out";
            return Err(Error::input(why));
        }
        let view = args.view.as_deref();
        if view.is_some_and(|view| view == out || is_same(view, log) || is_same(view, &out)) {
            let why =
                "write the view over a log that is read or written; name another file with --view";
            return Err(Error::input(why));
        }
        match track_log(log, &rig, &out, view) {
            Ok(outcome) => {
                text += &sentence(&name, &outcome);
                is_all_used &= outcome.centroids > 0;
                tracked.push(json!({ "log": log, "out": out, "frames": outcome }));
            }
            Err(error @ (TrackError::Setup(_) | TrackError::NoTopic)) => {
                return Err(Error::input(error));
            }
            Err(error @ (TrackError::Write(_) | TrackError::File(_))) => {
                return Err(Error::failed(error));
            }
            Err(error) => {
                text += &format!("{name} is left out: failed to {error}\n");
                left_out.push(json!({ "log": log, "why": error.to_string() }));
            }
        }
    }
    if tracked.is_empty() {
        return Err(Error::input(format!("track any log: {}", text.trim_end())));
    }
    let mut output = Output::done(json!({ "tracked": tracked, "left_out": left_out }), text);
    if !left_out.is_empty() || !is_all_used {
        output.outcome = Outcome::Rejected;
    }
    Ok(output)
}

/// Whether two paths are one file.
pub fn is_same(a: &Path, b: &Path) -> bool {
    let real = |path| fs::canonicalize(path).ok();
    real(a).is_some_and(|a| real(b) == Some(a))
}

/// A log's frames in a line, and its notes below.
fn sentence(name: &str, outcome: &TrackOutcome) -> String {
    let mut notes = outcome.notes.clone();
    if outcome.centroids == 0 {
        notes.push(NO_CENTROID.into());
    }
    let notes: String = notes
        .iter()
        .map(|note| format!("           {note}\n"))
        .collect();
    format!("{name}  {}\n{notes}", outcome.sentence())
}

/// What helps where no frame has a centroid.
const NO_CENTROID: &str = "no frame is of use: look at one with `carom camera tune`, and at what the reasons mean in docs/camera.md";
