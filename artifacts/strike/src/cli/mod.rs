//! The command line: what is asked becomes one plan, one strike and one answer.

mod args;
mod failure;
mod show;

use std::env;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use artifacts::{Artifact, Store};
use strike::{
    Choice, Config, Destination, DryRun, OpenLog, Plan, Planner, Robot, SimRobot, Trust,
    TruthSource, allows, batch, execute, highest, identity,
};
use values::{Point, Rig};

pub use args::Args;
use failure::Failure;
use show::Answer;

/// Done, but a line of the batch was refused.
const REJECTED: u8 = 3;

/// Does what is asked. The artifact is verified whole before anything else, and no robot is opened before a plan has
/// passed every limit.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let artifact = load(args)?;
    let model = args
        .model
        .unwrap_or(artifact.manifest.provenance.default_model);
    let planner = Planner::new(&artifact, model).map_err(Failure::input)?;
    match (&args.batch, &args.to) {
        (Some(file), _) => plan_batch(args, &planner, file),
        (None, Some(to)) => strike_one(args, &artifact, &planner, point(to)),
        (None, None) => Err(Failure::usage(
            "give a target, `--to X Y`, or `--batch FILE`",
        )),
    }
}

/// Nothing else is opened, and no robot, before the artifact has passed every check.
fn load(args: &Args) -> Result<Artifact, Failure> {
    let config = configured(args)?;
    let trust = config
        .key
        .as_deref()
        .map(|key| Trust::open(key, config.seen.as_deref()))
        .transpose()?;
    allows(trust.as_ref(), args.robot.moves())?;
    let own = |artifact: &Artifact| fits(artifact, config.rig.as_deref());
    let (store, version) = (Store::open(&args.artifacts), args.version.as_deref());
    if let Some(trust) = trust {
        return trust.load(&store, version, own);
    }
    let artifact = store.load(version).map_err(Failure::input)?;
    own(&artifact)?;
    if !args.quiet {
        eprintln!(
            "strike: no key is configured: {} is whole, but nobody vouches for it (see --key)",
            artifact.version
        );
    }
    Ok(artifact)
}

/// What is configured, and what the command line says in its place.
fn configured(args: &Args) -> Result<Config, Failure> {
    let file = match &args.config {
        Some(path) => Config::load(path),
        None => {
            let program = env::current_exe().map_err(|error| {
                Failure::failed(format!("find strike.toml beside this program: {error}"))
            })?;
            Config::beside(&program)
        }
    }
    .map_err(Failure::input)?;
    Ok(Config {
        key: args.key.clone().or(file.key),
        rig: args.rig.clone().or(file.rig),
        seen: args.seen.clone().or(file.seen),
    })
}

/// Whether the artifact is this robot's own, where its rig file is given.
fn fits(artifact: &Artifact, rig: Option<&Path>) -> Result<(), Failure> {
    let Some(path) = rig else {
        return Ok(());
    };
    let here = Rig::load(path).map_err(Failure::input)?;
    identity::check(&artifact.rig, &here)
        .map_err(|other| Failure::refused(format!("other_rig: {}: {other}", path.display())))
}

fn strike_one(
    args: &Args,
    artifact: &Artifact,
    planner: &Planner,
    to: Point,
) -> Result<ExitCode, Failure> {
    let from = args
        .from
        .as_ref()
        .map_or_else(|| planner.usual_start(to), |from| point(from));
    let plan = match planner.plan(from, to) {
        Ok(plan) => plan,
        Err(refusal) => {
            if args.json {
                show::json(&refusal)?;
            }
            return Err(Failure::refused(refusal.to_string()));
        }
    };
    if !args.json {
        show::plan(&plan, args.from.is_none())?;
    }
    let answer = strike_plan(args, artifact, &plan);
    if args.json {
        // The plan is told even where the robot fails.
        let told = answer.as_ref().ok().cloned();
        show::json(&told.unwrap_or_else(|| Answer::planned(&plan)))?;
    } else {
        show::struck(answer.as_ref().ok())?;
    }
    answer.map(|_| ExitCode::SUCCESS)
}

fn strike_plan(args: &Args, artifact: &Artifact, plan: &Plan) -> Result<Answer, Failure> {
    let strikes = args.artifacts.join("strikes");
    let Choice::Sim(folder) = &args.robot else {
        return strike_with(&mut DryRun, plan, None, &artifact.rig);
    };
    let truth = truth(folder.as_deref(), &args.artifacts);
    let source = truth
        .as_deref()
        .map_or(TruthSource::Demo, TruthSource::File);
    let mut robot =
        SimRobot::open(&artifact.rig, source, highest(&strikes)).map_err(Failure::input)?;
    let destination = args
        .log
        .clone()
        .map_or(Destination::Next(strikes), Destination::File);
    let log = OpenLog::open(destination)?;
    strike_with(&mut robot, plan, Some(log), &artifact.rig)
}

fn strike_with(
    robot: &mut dyn Robot,
    plan: &Plan,
    log: Option<OpenLog>,
    rig: &Rig,
) -> Result<Answer, Failure> {
    let struck = execute(robot, plan)?;
    let mut answer = Answer::planned(plan);
    if let (Some(struck), Some(log)) = (struck, log) {
        answer.struck(struck.stop, log.write(&struck.samples, &rig.topics)?);
    }
    Ok(answer)
}

/// The truth of the folder that is named; else the one beside the artifact, whose logs the rig wrote; else none.
fn truth(folder: Option<&Path>, artifacts: &Path) -> Option<PathBuf> {
    let beside = artifacts.join("truth.json");
    match folder {
        Some(folder) => Some(folder.join("truth.json")),
        None => beside.exists().then_some(beside),
    }
}

fn plan_batch(args: &Args, planner: &Planner, file: &Path) -> Result<ExitCode, Failure> {
    let output = io::stdout().lock();
    let tally = if file == Path::new("-") {
        batch::run(planner, io::stdin(), output)
    } else {
        let opened = File::open(file).map_err(|error| {
            Failure::input(format!("read the batch {}: {error}", file.display()))
        })?;
        batch::run(planner, opened, output)
    }
    .map_err(|error| Failure::failed(format!("plan the batch: {error}")))?;
    if !args.quiet {
        writeln!(
            io::stderr(),
            "{} planned, {} refused",
            tally.planned,
            tally.refused
        )
        .map_err(|error| Failure::failed(format!("tell the result: {error}")))?;
    }
    Ok(if tally.refused == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(REJECTED)
    })
}

fn point(coordinates: &[f64]) -> Point {
    Point::new(coordinates[0], coordinates[1])
}
