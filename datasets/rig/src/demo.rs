//! Writes a folder of demo logs: `rig.toml`, `logs/*.mcap`, `truth.json`.

use std::path::{Path, PathBuf};

use values::Shape;

use crate::film::Film;
use crate::random::{Purpose, random};
use crate::{Hidden, PlannedStrike, RecordingWriter, RigSimError, Sim, StrikeIndex, Truth, plan};

const STRIKES_A_SESSION: usize = 50;
/// Sessions that a demo is split into, where each keeps enough strikes: effects that differ by session need several.
const SESSIONS: usize = 4;
/// Strikes that a session keeps at the least.
const FEWEST_A_SESSION: usize = 10;

/// What to write.
#[derive(Clone, Debug)]
pub struct Settings {
    /// How many strikes to draw; a plan has its own number.
    pub strikes: usize,
    /// The rig, its seed and what is hidden; every field may be changed.
    pub truth: Truth,
    /// Strikes to make in place of random ones.
    pub plan: Option<Vec<PlannedStrike>>,
    /// Also logs `/striker/state`.
    pub log_state: bool,
    /// Logs `/object/pose` in place of `/object/centroid`: the tracker knows how the object is turned.
    pub log_pose: bool,
    /// How many sessions (logs); none: as many as effects that differ by session need.
    pub sessions: Option<usize>,
}

impl Settings {
    /// The demo of a shape: random strikes, with `hidden` in place of the demo's mixture where it is given.
    pub fn new(shape: Shape, strikes: usize, seed: u64, hidden: Option<Hidden>) -> Self {
        let mut truth = Truth::demo(&Truth::demo_rig(shape), seed);
        truth.hidden = hidden.unwrap_or(truth.hidden);
        Self {
            strikes,
            truth,
            plan: None,
            log_state: false,
            log_pose: false,
            sessions: None,
        }
    }
}

/// What was written.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    /// The rig file.
    pub rig: PathBuf,
    /// The logs, in order of time.
    pub logs: Vec<PathBuf>,
    /// The truth.
    pub truth: PathBuf,
    /// Number of strikes in all logs.
    pub strikes: usize,
}

/// Writes a demo into a folder, which it creates. Of a demo that an earlier call wrote there nothing is left. The same settings
/// give the same bytes. A rig with a topic of images is filmed: its logs have images in place of centroids.
pub fn write(settings: &Settings, out: &Path) -> Result<Written, RigSimError> {
    let mut sim = Sim::from(settings.truth.clone())?;
    if settings.log_state {
        sim = sim.logging_state();
    }
    if settings.log_pose {
        sim = sim.logging_pose();
    }
    let count = settings.plan.as_ref().map_or(settings.strikes, Vec::len);
    let a_session = count
        .div_ceil(settings.sessions.unwrap_or_else(|| sessions(count)).max(1))
        .max(1);
    let index = |order: usize| StrikeIndex {
        session: order / a_session,
        order,
    };
    let plan = match &settings.plan {
        Some(plan) => plan.clone(),
        None => plan::draw(
            sim.prepared(),
            index,
            count,
            &mut random(settings.truth.seed, Purpose::Plan, 0),
        )?,
    };
    for (index, strike) in plan.iter().enumerate() {
        plan::check(sim.prepared(), index, strike)?;
    }
    let film = Film::of(&settings.truth)?;

    let folder = out.join("logs");
    std::fs::create_dir_all(&folder).map_err(|source| file_error(&folder, source))?;
    if out.join("truth.json").exists() {
        remove_sessions(&folder)?;
    }
    let mut written = Written {
        rig: out.join("rig.toml"),
        logs: Vec::new(),
        truth: out.join("truth.json"),
        strikes: count,
    };
    let mut truth = settings.truth.without_strikes();
    for (session, strikes) in plan.chunks(a_session).enumerate() {
        if session > 0 {
            sim.next_session();
        }
        let path = folder.join(session_name(session));
        // Under another name until it has images: no log lacks them where the demo is stopped.
        let plain = match &film {
            Some(_) => path.with_extension("centroids"),
            None => path.clone(),
        };
        let topics = &truth.rig.topics;
        let mut writer = match settings.log_pose {
            true => RecordingWriter::create_without_centroids(&plain, topics)?,
            false => RecordingWriter::create(&plain, topics)?,
        };
        for strike in strikes {
            let recording = sim.strike(strike.initial(), strike.command());
            writer.write_turned(&recording.samples, &recording.yaws)?;
            truth.strikes.push(recording.truth);
        }
        let lineage = [
            ("program", "carom demo".to_owned()),
            ("session", session_name(session)),
            ("seed", truth.seed.to_string()),
        ];
        writer.lineage(&lineage.map(|(name, value)| (name.to_owned(), value)).into())?;
        writer.finish()?;
        if let Some(film) = &film {
            film.film(&truth, &plain, &path)?;
        }
        written.logs.push(path);
    }
    write_text(
        &written.rig,
        &format!("{RIG_HEADER}{}", truth.rig_file().to_toml()),
    )?;
    write_text(&written.truth, &truth.to_json())?;
    Ok(written)
}

const RIG_HEADER: &str = "# The embedded rig of `carom demo`: what is known of it before anything is measured.\n\
    # SI units. Frame `table`: x away from the robot, y to its left, angles from +x, counter-clockwise.\n\n";

const SESSION: &str = "session_";
const MCAP: &str = ".mcap";

/// The name of a session's log, from its number.
pub fn session_name(session: usize) -> String {
    format!("{SESSION}{session:03}{MCAP}")
}

/// The number of a session, from its log's name; none of a log that no demo writes.
pub fn session_number(name: &str) -> Option<usize> {
    let digits = name.strip_prefix(SESSION)?.strip_suffix(MCAP)?;
    let number = digits.parse().ok()?;
    (session_name(number) == name).then_some(number)
}

/// Removes the logs of an earlier demo: its sessions would be read as some of this one's.
fn remove_sessions(folder: &Path) -> Result<(), RigSimError> {
    let is_session = |name: &str| {
        let number = name.strip_prefix(SESSION)?.strip_suffix(MCAP)?;
        number.parse::<u32>().ok()
    };
    let entries = std::fs::read_dir(folder).map_err(|source| file_error(folder, source))?;
    for entry in entries {
        let entry = entry.map_err(|source| file_error(folder, source))?;
        if entry.file_name().to_str().and_then(is_session).is_some() {
            let path = entry.path();
            std::fs::remove_file(&path).map_err(|source| file_error(&path, source))?;
        }
    }
    Ok(())
}

fn sessions(strikes: usize) -> usize {
    strikes
        .div_ceil(STRIKES_A_SESSION)
        .max(SESSIONS.min(strikes / FEWEST_A_SESSION))
        .max(1)
}

fn write_text(path: &Path, text: &str) -> Result<(), RigSimError> {
    std::fs::write(path, text).map_err(|source| file_error(path, source))
}

fn file_error(path: &Path, source: std::io::Error) -> RigSimError {
    RigSimError::File {
        doing: "write",
        path: path.display().to_string(),
        source,
    }
}
