//! `carom collect`: strikes that gather data.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;
use store::{Artifact, Store};
use strike::arm::{Arm, ports_of};
use strike::collect::{
    ArmStation, CollectError, CollectEvent, Collected, SimStation, Station, StrikeRequest,
};
use strike::ur::Ur;
use strike::xarm::XArm;
use strike::{
    Choice, CommandPlanner, Guarded, Live, LiveError, RobotError, Trust, catch_signals, identity,
    memory_folder, tell, told,
};
use values::Rig;

use crate::args::Global;
use crate::error::Output;
use crate::{Error, Outcome};

/// `carom collect`.
#[derive(Args, Debug)]
pub struct CollectArgs {
    /// This robot's own rig file.
    #[arg(long, value_name = "FILE")]
    pub rig: PathBuf,
    /// Robot: sim (the rig of the truth.json beside the rig file, or in FOLDER for sim:FOLDER; else the demo's) or xarm:HOST (UFACTORY's xArm5, 6, 7 and
    /// Lite6) or ur:HOST (Universal Robots' e-Series).
    #[arg(long, value_name = "ROBOT")]
    pub robot: Choice,
    /// Live topics of the camera, which an arm needs: ROS 2's foxglove_bridge, or any server of Foxglove's SDK.
    #[arg(long, value_name = "ws://HOST:PORT")]
    pub watch: Option<String>,
    /// Usable strikes that the folder is to hold at the end.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub strikes: u32,
    /// Folder of the logs; a collection in it is continued.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Strikes to make first: a run's next_strikes.json or diagnosis.json, or a JSON list of {x0, y0, speed, angle}.
    #[arg(long, value_name = "FILE")]
    pub plan: Option<PathBuf>,
    /// Folder of a run whose latest version foresees where the object stops [default: the world before anything is measured].
    #[arg(long, value_name = "DIR")]
    pub artifacts: Option<PathBuf>,
    /// Public key, which an arm needs: whoever has it is one who may move this arm. A version of --artifacts must be signed by it.
    #[arg(long, value_name = "FILE")]
    pub key: Option<PathBuf>,
    /// The object must lie still for so long, in s, before the arm moves: time to step back.
    #[arg(long, value_name = "SECONDS", default_value_t = 3.0, value_parser = seconds)]
    pub pause: f64,
}

fn seconds(text: &str) -> Result<f64, String> {
    let number: f64 = text
        .parse()
        .map_err(|_| "no number of seconds".to_owned())?;
    (0.5..=600.0)
        .contains(&number)
        .then_some(number)
        .ok_or_else(|| "must be 0.5 to 600 s".into())
}

/// Gathers strikes.
pub fn run(args: &CollectArgs, global: Global) -> Result<Output, Error> {
    let rig = Rig::load(&args.rig).map_err(Error::input)?;
    let requested = requested(args)?;
    let planner = planner(args, &rig)?;
    let interrupted =
        catch_signals().map_err(|error| Error::failed(format!("take signals: {error}")))?;
    let mut station = station(args, &rig, interrupted.clone())?;
    let bar = if global.quiet {
        ProgressBar::hidden()
    } else {
        ProgressBar::new(u64::from(args.strikes)).with_style(style())
    };
    let waits = args.watch.is_some();
    let (mut before, mut left_out) = (Told::default(), 0);
    let collected = strike::collect::collect(
        &mut *station,
        &planner,
        &args.out,
        args.strikes as usize,
        &requested,
        &|| interrupted.load(Ordering::Relaxed),
        &mut |news| {
            left_out += usize::from(matches!(news, CollectEvent::LeftOut(_)));
            show(&bar, waits, &interrupted, &mut before, &news);
        },
    );
    bar.finish_and_clear();
    finished(
        args,
        collected.map_err(failed)?,
        left_out,
        interrupted.load(Ordering::Relaxed),
    )
}

fn style() -> ProgressStyle {
    ProgressStyle::with_template("{bar:30} {pos}/{len} strikes, {eta} left  {prefix}  {msg}")
        .unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// What was told where there is no bar, without its numbers, which change from look to look; and when.
#[derive(Default)]
struct Told(HashMap<String, Instant>);

impl Told {
    /// Where there is no bar, the same thing is told this often; another one at once.
    const AGAIN: Duration = Duration::from_secs(10);

    fn is_due(&mut self, what: &str, now: Instant) -> bool {
        let what = what.replace(|c: char| c.is_ascii_digit(), "");
        let last = self.0.get(&what);
        let is_due = last.is_none_or(|at| now.saturating_duration_since(*at) >= Self::AGAIN);
        if is_due {
            self.0.insert(what, now);
        }
        is_due
    }
}

/// What a person must do or know is told with `--quiet` too.
fn show(
    bar: &ProgressBar,
    waits: bool,
    interrupted: &AtomicBool,
    before: &mut Told,
    news: &CollectEvent,
) {
    // Printed where there is no bar too.
    let say = |what: String| bar.suspend(|| tell(&format!("carom: {what}")));
    // A terminal that is held back is waited for: whoever has not read it yet has not stepped back.
    let wait = |what: String| {
        let gives_up = |_| interrupted.load(Ordering::Relaxed);
        // Where nobody can be told, the arm is not moved.
        let _ = bar.suspend(|| told(&format!("carom: {what}"), gives_up));
    };
    let is_shown = !bar.is_hidden();
    match news {
        CollectEvent::Put(request) if waits => {
            let put = format!(
                "put the object near ({:.2}, {:.2}) m and step back",
                request.from.x, request.from.y
            );
            if is_shown {
                bar.set_prefix(put);
            } else {
                say(put);
            }
        }
        CollectEvent::Put(_) => {}
        CollectEvent::Waiting(what) => {
            if is_shown {
                bar.set_message(what.clone());
            } else if before.is_due(what, Instant::now()) {
                say(what.clone());
            }
        }
        CollectEvent::Lost(what) => say(what.clone()),
        CollectEvent::StepBack(pause) => wait(format!(
            "step back: the arm moves in {:.1} s",
            pause.as_secs_f64()
        )),
        CollectEvent::LeftOut(refusal) => {
            say(format!("a planned strike is left out: {refusal}"));
        }
        CollectEvent::Kept { strikes, warning } => {
            bar.set_position(*strikes as u64);
            if let Some(warning) = warning {
                say(format!("strike {strikes}: {warning}"));
            }
        }
        CollectEvent::Useless(why) => say(format!("a strike cannot be used: {why}")),
    }
}

/// `left_out` planned strikes could not be made.
fn finished(
    args: &CollectArgs,
    collected: Collected,
    left_out: usize,
    is_over: bool,
) -> Result<Output, Error> {
    let Collected {
        strikes,
        made,
        useless,
        session,
    } = &collected;
    let folder = args.out.display();
    if is_over && *strikes < args.strikes as usize {
        return Err(Error::failed(format!(
            "gather all strikes: it was interrupted; {strikes} of {} lie in {folder}; the same command goes on",
            args.strikes
        )));
    }
    let text = format!(
        "{strikes} usable strikes in {folder}, {made} made now, {useless} could not be used, {left_out} planned ones left out\n"
    );
    Ok(Output::ended(
        Outcome::of(*useless == 0 && left_out == 0),
        json!({ "strikes": strikes, "made": made, "useless": useless, "left_out": left_out, "session": session }),
        text,
    ))
}

fn requested(args: &CollectArgs) -> Result<Vec<StrikeRequest>, Error> {
    let Some(path) = &args.plan else {
        return Ok(Vec::new());
    };
    let text = fs::read_to_string(path).map_err(|error| Error::unreadable(path, &error))?;
    let strikes = rig::parse_plan(&text).map_err(Error::input)?;
    Ok(strikes
        .iter()
        .map(|strike| StrikeRequest {
            from: strike.initial(),
            command: strike.command(),
        })
        .collect())
}

/// What foresees where the object stops.
fn planner(args: &CollectArgs, rig: &Rig) -> Result<CommandPlanner, Error> {
    let Some(folder) = &args.artifacts else {
        return CommandPlanner::nominal(rig).map_err(Error::input);
    };
    strike::allows(args.key.is_some(), true, args.robot.moves()).map_err(refused)?;
    let is_own = |artifact: &Artifact| {
        identity::check(&artifact.rig, rig).map_err(|other| Error::Refused(other.to_string()))
    };
    let store = Store::open(folder);
    let artifact = match &args.key {
        Some(key) => {
            let trust = Trust::open(key, None)?;
            trust.load(&store, None, is_own)?
        }
        None => {
            let artifact = store.load(None).map_err(Error::input)?;
            is_own(&artifact)?;
            artifact
        }
    };
    CommandPlanner::published(&artifact, rig).map_err(Error::input)
}

impl From<strike::TrustError> for Error {
    fn from(error: strike::TrustError) -> Self {
        refused(error)
    }
}

fn station(
    args: &CollectArgs,
    rig: &Rig,
    interrupted: Arc<AtomicBool>,
) -> Result<Box<dyn Station>, Error> {
    match (&args.robot, &args.watch) {
        (Choice::Sim(_), Some(_)) => Err(Error::input(
            "watch live topics with the embedded rig, which has a camera of its own; take --watch away",
        )),
        (Choice::Sim(sim), None) => {
            let folder = args.rig.parent().unwrap_or(Path::new(""));
            Ok(Box::new(SimStation::new(rig, sim.truth(folder))))
        }
        (Choice::XArm(_) | Choice::Ur(_), None) => Err(Error::input(
            "collect strikes of an arm without a camera; give its live topics with --watch ws://HOST:PORT",
        )),
        (Choice::XArm(host), Some(url)) => {
            arm_station::<XArm>(args, rig, (&format!("xarm:{host}"), host), url, interrupted)
        }
        (Choice::Ur(host), Some(url)) => {
            arm_station::<Ur>(args, rig, (&format!("ur:{host}"), host), url, interrupted)
        }
        (Choice::DryRun, _) => Err(Error::input(
            "collect strikes with a robot that makes none; use --robot sim, xarm:HOST or ur:HOST",
        )),
    }
}

/// An arm, claimed, and the camera that looks at its object. An arm moves only for whoever has a key.
fn arm_station<D: Arm + 'static>(
    args: &CollectArgs,
    rig: &Rig,
    (name, host): (&str, &str),
    url: &str,
    interrupted: Arc<AtomicBool>,
) -> Result<Box<dyn Station>, Error> {
    let ports = ports_of::<D>(host)
        .map_err(|error| Error::input(format!("find the arm at `{host}`: {error}")))?;
    let live = Live::connect(url, rig).map_err(|error| failed(error.into()))?;
    strike::allows(args.key.is_some(), true, true).map_err(refused)?;
    if let (Some(key), None) = (&args.key, &args.artifacts) {
        Trust::open(key, None)?;
    }
    let robot = Guarded::<D>::connect(name, &ports, rig, interrupted.clone());
    let robot = robot.map_err(|error| failed(error.into()))?;
    let pause = Duration::from_secs_f64(args.pause);
    let memory = memory_folder().map_err(|error| failed(error.into()))?;
    let station = ArmStation::new(robot, live, pause, interrupted, &memory);
    Ok(Box::new(station.map_err(failed)?))
}

fn refused(error: impl std::fmt::Display) -> Error {
    Error::Refused(error.to_string())
}

fn failed(error: CollectError) -> Error {
    match error {
        CollectError::Lock(durable::LockError::Busy { .. }) => Error::Busy(error.into()),
        CollectError::Robot(RobotError::Busy { .. }) => Error::Busy(error.into()),
        CollectError::Robot(RobotError::NotReady { .. } | RobotError::Refused(_))
        | CollectError::Live(LiveError::Frames(..)) => refused(error),
        CollectError::Collected(_)
        | CollectError::NoStrike(_)
        | CollectError::Live(LiveError::Address(_) | LiveError::NoTopic { .. }) => {
            Error::input(error)
        }
        _ => Error::failed(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_waited_for_next_is_told_at_once_and_the_same_only_now_and_then() {
        let (mut told, start) = (Told::default(), Instant::now());
        let mut is_due = |what: &str, ms: u64| told.is_due(what, start + Duration::from_millis(ms));
        assert!(is_due("seen 3 times in the last 0.5 s: too short", 0));
        assert!(!is_due("seen 4 times in the last 0.5 s: too short", 50));
        assert!(is_due("it lies where it stopped: put it elsewhere", 100));
        assert!(!is_due("seen 9 times in the last 0.5 s: too short", 150));
        assert!(!is_due(
            "it lies where it stopped: put it elsewhere",
            10_050
        ));
        assert!(is_due("it lies where it stopped: put it elsewhere", 10_100));
    }
}
