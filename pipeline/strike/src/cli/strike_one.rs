//! One target: plan, strike, log, answer.

use std::process::ExitCode;

#[cfg(feature = "sim")]
use rig::SimChoice;
use strike::arm::{Arm, ports_of};
use strike::ur::Ur;
use strike::xarm::XArm;
use strike::{
    Args, Choice, Destination, DryRun, Guarded, Lineage, OpenLog, Plan, Planner, Reason, Received,
    Refusal, Robot, RobotError, Samples, catch_signals, execute, tell,
};
#[cfg(feature = "sim")]
use strike::{SimRobot, TruthSource, take_number};
use values::{Point, Topics};

use super::show::{self, Answer};
use super::watching::Watching;
use super::{Failure, REJECTED, point};

/// Bytes of a strike's log without a camera's messages, at the most.
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
            strike_with(&mut robot, &plan, Some((log, about("sim"))), None, topics)?
        }
        Choice::XArm(host) => {
            let name = format!("xarm:{host}");
            let (mut robot, log) = open_arm::<XArm>(args, planner, (&name, host), &watching)?;
            let log = Some((log, about(&name)));
            strike_with(&mut robot, &plan, log, watching.as_ref(), topics)?
        }
        Choice::Ur(host) => {
            let name = format!("ur:{host}");
            let (mut robot, log) = open_arm::<Ur>(args, planner, (&name, host), &watching)?;
            let log = Some((log, about(&name)));
            strike_with(&mut robot, &plan, log, watching.as_ref(), topics)?
        }
        Choice::DryRun => strike_with(&mut DryRun, &plan, None, None, topics)?,
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
    let Some(why) = &answer.log_moved else {
        return Ok(ExitCode::SUCCESS);
    };
    tell(&format!(
        "strike: the strike was made and is kept, but failed to {why}"
    ));
    Ok(ExitCode::from(REJECTED))
}

/// The embedded rig, and the log of its strike. The log is opened first: a number that is taken is a strike that is made.
#[cfg(feature = "sim")]
fn open_sim(
    args: &Args,
    planner: &Planner,
    sim: &SimChoice,
) -> Result<(SimRobot, OpenLog), Failure> {
    let truth = sim.truth(&args.artifacts);
    if truth.is_none() && !args.quiet {
        eprintln!(
            "strike: there is no truth.json in {0} or {0}/rig: the demo's default rig is struck, with hidden effects of its own; \
             name another with --robot sim:FOLDER",
            args.artifacts.display()
        );
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

/// An arm, stopped by whatever signal would end this program, and the log of its strike.
fn open_arm<D: Arm>(
    args: &Args,
    planner: &Planner,
    (name, host): (&str, &str),
    watching: &Option<Watching>,
) -> Result<(Guarded<D>, OpenLog), Failure> {
    let interrupted =
        catch_signals().map_err(|error| Failure::failed(format!("take signals: {error}")))?;
    let room = watching
        .as_ref()
        .map_or(ROOM, |watching| ROOM + watching.room());
    let log = OpenLog::open(destination(args))?.reserve(room)?;
    let ports = ports_of::<D>(host)
        .map_err(|error| Failure::input(format!("find the arm at `{host}`: {error}")))?;
    let robot = Guarded::<D>::connect(name, &ports, planner.rig(), interrupted);
    let mut robot = robot.map_err(|error| match error {
        RobotError::NotReady { .. } => {
            Failure::refused(Reason::NotReady, format!("failed to {error}"))
        }
        RobotError::Busy { .. } => Failure::Busy(error.to_string()),
        error => Failure::failed(error),
    })?;
    if let Some(watching) = watching {
        robot.look_first(watching.strike.look());
    }
    Ok((robot, log))
}

fn destination(args: &Args) -> Destination {
    args.log.clone().map_or_else(
        || Destination::Next(args.artifacts.join("strikes")),
        Destination::File,
    )
}

/// Strikes and keeps the log. Errors only where nothing was struck: a strike that was made is reported, whatever fails after it.
fn strike_with(
    robot: &mut dyn Robot,
    plan: &Plan,
    log: Option<(OpenLog, Lineage)>,
    watching: Option<&Watching>,
    topics: &Topics,
) -> Result<Answer, Failure> {
    let mut answer = Answer::planned(plan);
    let outcome = execute(robot, plan);
    let is_over = outcome.is_ok();
    let received = |answer: &mut Answer| {
        watching.map_or_else(Vec::new, |watching| watching.ended(plan, is_over, answer))
    };
    match outcome {
        Ok(None) => return Ok(answer),
        Ok(Some(struck)) => {
            answer.struck(&struck);
            let received = received(&mut answer);
            keep(&mut answer, log, (&struck.samples, &received), topics);
        }
        Err(RobotError::Refused(refusal)) => return Err(Failure::Refused(refusal)),
        Err(error @ RobotError::NotReady { .. }) => {
            return Err(Failure::Refused(Refusal {
                from: Some(plan.from),
                to: Some(plan.to),
                refused: Reason::NotReady,
                detail: format!("failed to {error}"),
            }));
        }
        Err(error) => {
            answer.failed = Some(error.to_string());
            if let Some(samples) = error.samples() {
                let received = received(&mut answer);
                keep(&mut answer, log, (samples, &received), topics);
            }
        }
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
