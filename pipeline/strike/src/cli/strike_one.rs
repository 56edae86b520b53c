//! One target: plan, strike, log, answer.

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use strike::arm::{Arm, ports_of};
use strike::ur::Ur;
use strike::xarm::XArm;
use strike::{
    Args, Choice, Destination, DryRun, Guarded, Lineage, Live, Memory, OpenLog, Plan, Planner,
    Reason, Received, Refusal, Resting, RobotError, Samples, Seen, StrikeRecord, Watched,
    catch_signals, execute, memory_folder, strike_and_keep, tell,
};
use values::{Point, Rig, Topics};

use super::show::{self, Answer};
use super::{Failure, REJECTED, point};

#[cfg(feature = "sim")]
use rig::SimChoice;

#[cfg(feature = "sim")]
use strike::{SimRobot, TruthSource, take_number};

/// Greatest size in bytes of a strike's log, a camera's messages apart.
const ROOM: u64 = 8 << 20;

/// Plans a strike at `to`, makes it, and reports the result. `manifest` is the hash of the version's.
pub fn strike_one(
    args: &Args,
    planner: &Planner,
    manifest: &str,
    to: Point,
) -> Result<ExitCode, Failure> {
    let watching = Watching::open(args, planner.rig())?;
    let (from, yaw) = match (&args.from, &watching) {
        (_, Some(watching)) => {
            let rest = watching.rest;
            (Ok(rest.point), rest.yaw.unwrap_or(args.yaw))
        }
        (Some(from), None) => (Ok(point(from)), args.yaw),
        (None, None) => (planner.usual_start(to), args.yaw),
    };
    let plan = from
        .and_then(|from| planner.plan_turned(from, to, yaw))
        .map_err(Failure::Refused)?;
    if !args.json {
        show::plan(&plan, args.from.is_none() && watching.is_none())?;
    }
    let topics = &planner.rig().topics;
    let about = |robot: &str| {
        let mut lineage = plan.lineage(robot);
        lineage.insert("manifest".into(), manifest.into());
        let session = args.session.clone().unwrap_or_default();
        lineage.insert("session".into(), session);
        lineage
    };
    let answer = match &args.robot {
        #[cfg(feature = "sim")]
        Choice::Sim(sim) => {
            let (mut robot, log) = open_sim(args, planner, sim)?;
            let outcome = execute(&mut robot, &plan);
            answered(&plan, outcome, None, Some((log, about("sim"))), topics)?
        }
        Choice::XArm(host) => {
            let name = format!("xarm:{host}");
            let about = about(&name);
            strike_with_arm::<XArm>(args, &plan, (&name, host), watching.as_ref(), about)?
        }
        Choice::Ur(host) => {
            let name = format!("ur:{host}");
            let about = about(&name);
            strike_with_arm::<Ur>(args, &plan, (&name, host), watching.as_ref(), about)?
        }
        Choice::DryRun => answered(&plan, execute(&mut DryRun, &plan), None, None, topics)?,
    };
    if args.json {
        show::json(&answer)?;
    } else {
        show::struck(&answer)?;
    }
    if let Some(why) = &answer.failed {
        tell(&format!("strike: failed to {why}"));
        return Ok(ExitCode::FAILURE);
    }
    let moved = answer.log_moved.map(|why| format!("failed to {why}"));
    let but: Vec<String> = moved.into_iter().chain(answer.unseen).collect();
    if but.is_empty() {
        return Ok(ExitCode::SUCCESS);
    }
    tell(&format!(
        "strike: the strike was made and is kept, but {}",
        but.join("; ")
    ));
    Ok(ExitCode::from(REJECTED))
}

/// Opens the log of a strike, then takes the strike's number and opens the embedded rig. The log comes first: a number is never given again, so none
/// is taken for a strike that could not be logged.
#[cfg(feature = "sim")]
fn open_sim(
    args: &Args,
    planner: &Planner,
    sim: &SimChoice,
) -> Result<(SimRobot, OpenLog), Failure> {
    let truth = sim.truth(&args.artifacts);
    if truth.is_none() && !args.quiet {
        tell(&format!(
            "strike: there is no truth.json in {0} or {0}/rig: the demo's default rig is struck, with hidden effects of its own; \
             name another with --robot sim:FOLDER",
            args.artifacts.display()
        ));
    }
    let source = truth
        .as_deref()
        .map_or(TruthSource::Demo, TruthSource::File);
    let log = OpenLog::open(destination(args))?;
    let number = take_number(&args.artifacts).map_err(|error| match error {
        durable::LockError::Busy { .. } => Failure::Busy(error.to_string()),
        durable::LockError::Io(_) => Failure::failed(error),
    })?;
    let robot = SimRobot::open(planner.rig(), source, number, args.session.as_deref())
        .map_err(Failure::input)?;
    Ok((robot, log))
}

/// Strikes with an arm; any signal that would end this program stops the arm first.
fn strike_with_arm<D: Arm>(
    args: &Args,
    plan: &Plan,
    (name, host): (&str, &str),
    watching: Option<&Watching>,
    lineage: Lineage,
) -> Result<Answer, Failure> {
    let interrupted =
        catch_signals().map_err(|error| Failure::failed(format!("take signals: {error}")))?;
    let room = watching.map_or(ROOM, |watching| ROOM + watching.room());
    let log = OpenLog::open(destination(args))?.reserve(room)?;
    let ports = ports_of::<D>(host)
        .map_err(|error| Failure::input(format!("find the arm at `{host}`: {error}")))?;
    let robot = Guarded::<D>::connect(name, &ports, plan.rig(), interrupted);
    let mut robot = robot.map_err(|error| match error {
        RobotError::NotReady { .. } => {
            Failure::refused(Reason::NotReady, format!("failed to {error}"))
        }
        RobotError::Busy { .. } => Failure::Busy(error.to_string()),
        error => Failure::failed(error),
    })?;
    robot.pause(args.pause());
    let folder = memory_folder().map_err(Failure::failed)?;
    let mut memory = Memory::open(&folder, robot.serial()).map_err(Failure::failed)?;
    if let Some(lost) = memory.lost() {
        tell(&format!("strike: {lost}"));
    }
    if let Some(watching) = watching {
        memory
            .permits(watching.rest.point)
            .map_err(|why| not_ready(plan, why))?;
    }
    // A signal that comes once nothing moves any more ends no recording.
    let never = AtomicBool::new(false);
    let watched = watching.map(|watching| &watching.strike);
    let (outcome, seen) = strike_and_keep(&mut robot, plan, watched, &mut memory, &never);
    let answer = answered(
        plan,
        outcome,
        seen,
        Some((log, lineage)),
        &plan.rig().topics,
    );
    memory.recorded();
    answer
}

fn not_ready(plan: &Plan, detail: impl ToString) -> Failure {
    Failure::Refused(Refusal {
        from: Some(plan.from),
        to: Some(plan.to),
        refused: Reason::NotReady,
        detail: detail.to_string(),
    })
}

fn destination(args: &Args) -> Destination {
    args.log.clone().map_or_else(
        || Destination::Next(args.artifacts.join("strikes")),
        Destination::File,
    )
}

/// The answer to a strike, and its log. Errors only where nothing was struck: a strike that was made is reported, whatever fails after it.
fn answered(
    plan: &Plan,
    outcome: Result<Option<StrikeRecord>, RobotError>,
    seen: Option<Seen>,
    log: Option<(OpenLog, Lineage)>,
    topics: &Topics,
) -> Result<Answer, Failure> {
    let mut answer = Answer::planned(plan);
    match &outcome {
        Ok(None) => return Ok(answer),
        Ok(Some(struck)) => answer.struck(struck),
        Err(RobotError::Refused(refusal)) => return Err(Failure::Refused(refusal.clone())),
        Err(error @ RobotError::NotReady { .. }) => {
            return Err(not_ready(plan, format!("failed to {error}")));
        }
        Err(error) => answer.failed = Some(error.to_string()),
    }
    let received = seen.map_or_else(Vec::new, |seen| {
        answer.seen(&seen);
        seen.received
    });
    let samples = match &outcome {
        Ok(struck) => struck.as_ref().map(|struck| &struck.samples),
        Err(error) => error.samples(),
    };
    if let Some(samples) = samples {
        keep(&mut answer, log, (samples, &received), topics);
    }
    Ok(answer)
}

/// Writes what was recorded, and puts its path into the answer, or why it could not be written.
fn keep(
    answer: &mut Answer,
    log: Option<(OpenLog, Lineage)>,
    (samples, received): (&Samples, &[Received]),
    topics: &Topics,
) {
    let Some((log, mut lineage)) = log else {
        return;
    };
    lineage.insert("robot_answered".into(), answer.robot_answered());
    match log.about(lineage).write_with(samples, received, topics) {
        Ok(kept) => {
            answer.log = Some(kept.path);
            answer.log_moved = kept.moved.map(|why| why.to_string());
        }
        Err(error) => {
            let before = answer.failed.take();
            let lost = format!("keep the log of a strike that was made: {error}");
            answer.failed = Some(before.map_or(lost.clone(), |first| format!("{first}; {lost}")));
        }
    }
}

/// How long the object is waited for to be seen at rest before a strike.
const BEFORE: Duration = Duration::from_secs(3);

/// The live topics, and the object at rest.
pub struct Watching {
    live: Arc<Live>,
    pub rest: Resting,
    pub strike: Watched,
}

impl Watching {
    /// Connects where `--watch` is given, and looks where the object rests.
    pub fn open(args: &Args, rig: &Rig) -> Result<Option<Self>, Failure> {
        let Some(url) = &args.watch else {
            return Ok(None);
        };
        let live = Arc::new(Live::connect(url, rig)?);
        let rest = live.wait_for_rest(BEFORE, &AtomicBool::new(false))?;
        Ok(Some(Self {
            strike: Watched::new(live.clone(), rest),
            live,
            rest,
        }))
    }

    /// Greatest size in bytes that the messages of a strike may come to.
    pub fn room(&self) -> u64 {
        self.live.room()
    }
}
