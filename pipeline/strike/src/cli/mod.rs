//! The command line: what is asked becomes one plan, one strike and one answer.

mod args;
mod failure;
mod show;

use std::env;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use store::{Artifact, Store};
use strike::{
    Choice, Config, Destination, DryRun, OpenLog, Plan, Planner, Reason, Refusal, Robot, SimRobot,
    Trust, TruthSource, allows, batch, execute, highest, identity,
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
    if let Some(why) = args.robot.lacks_driver() {
        return refuse(
            args,
            &Refusal {
                from: args.from.as_deref().map(point),
                to: args.to.as_deref().map(point),
                refused: Reason::NoDriver,
                detail: why,
            },
        );
    }
    if args.log.is_some() && args.robot == Choice::DryRun {
        return Err(Failure::usage(
            "--log goes with a robot that strikes, and dry-run moves nothing: add --robot sim, or take --log away",
        ));
    }
    let (artifact, rig) = load(args)?;
    let model = args
        .model
        .unwrap_or(artifact.manifest.provenance.default_model);
    let planner = Planner::within(&artifact, model, &rig).map_err(Failure::input)?;
    match (&args.batch, &args.to) {
        (Some(file), _) => plan_batch(args, &planner, file),
        (None, Some(to)) => strike_one(args, &planner, point(to)),
        (None, None) => Err(Failure::usage(
            "give a target, `--to X Y`, or `--batch FILE`",
        )),
    }
}

/// The artifact, and the rig within whose limits it is used: this robot's own where its file is given. Nothing else is
/// opened, and no robot, before the artifact has passed every check.
fn load(args: &Args) -> Result<(Artifact, Rig), Failure> {
    let config = configured(args)?;
    let own = match &config.rig {
        None => None,
        Some(path) => Some((path, load_rig(path)?)),
    };
    let trust = config
        .key
        .as_deref()
        .map(|key| Trust::open(key, config.seen.as_deref()))
        .transpose()?;
    allows(trust.as_ref(), args.robot.moves())?;
    let is_own = |artifact: &Artifact| match &own {
        None => Ok(()),
        Some((path, rig)) => identity::check(&artifact.rig, rig)
            .map_err(|other| Failure::refused(format!("other_rig: {}: {other}", path.display()))),
    };
    let (store, version) = (Store::open(&args.artifacts), args.version.as_deref());
    let artifact = if let Some(trust) = trust {
        trust.load(&store, version, is_own)?
    } else {
        let artifact = store.load(version).map_err(Failure::input)?;
        is_own(&artifact)?;
        if !args.quiet {
            eprintln!(
                "strike: no key is configured: {} is whole, but nobody vouches for it (see --key)",
                artifact.version
            );
        }
        artifact
    };
    let rig = match own {
        Some((_, rig)) => rig,
        None => artifact.rig.clone(),
    };
    Ok((artifact, rig))
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

fn load_rig(path: &Path) -> Result<Rig, Failure> {
    Rig::load(path).map_err(|error| {
        Failure::input(format!(
            "use the rig file {}: failed to {error}",
            path.display()
        ))
    })
}

fn strike_one(args: &Args, planner: &Planner, to: Point) -> Result<ExitCode, Failure> {
    let from = match &args.from {
        Some(from) => Ok(point(from)),
        None => planner.usual_start(to),
    };
    let plan = match from.and_then(|from| planner.plan(from, to)) {
        Ok(plan) => plan,
        Err(refusal) => return refuse(args, &refusal),
    };
    if !args.json {
        show::plan(&plan, args.from.is_none())?;
    }
    let answer = strike_plan(args, planner.rig(), &plan);
    if args.json {
        // The plan is told even where the robot fails.
        let told = answer.as_ref().ok().cloned();
        show::json(&told.unwrap_or_else(|| Answer::planned(&plan)))?;
    } else {
        show::struck(answer.as_ref().ok())?;
    }
    answer.map(|_| ExitCode::SUCCESS)
}

/// A refusal is an answer too, where a machine asks.
fn refuse(args: &Args, refusal: &Refusal) -> Result<ExitCode, Failure> {
    if args.json {
        show::json(refusal)?;
    }
    Err(Failure::refused(refusal))
}

fn strike_plan(args: &Args, rig: &Rig, plan: &Plan) -> Result<Answer, Failure> {
    let strikes = args.artifacts.join("strikes");
    let Choice::Sim(folder) = &args.robot else {
        return strike_with(&mut DryRun, plan, None, rig);
    };
    let truth = truth(folder.as_deref(), &args.artifacts);
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
    let mut robot = SimRobot::open(rig, source, highest(&strikes)).map_err(Failure::input)?;
    let destination = args
        .log
        .clone()
        .map_or(Destination::Next(strikes), Destination::File);
    let log = OpenLog::open(destination)?;
    strike_with(&mut robot, plan, Some(log), rig)
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

/// The truth of the folder that is named; else the one where `carom demo` wrote it for this run; else none.
fn truth(folder: Option<&Path>, artifacts: &Path) -> Option<PathBuf> {
    match folder {
        Some(folder) => Some(folder.join("truth.json")),
        None => ["truth.json", "rig/truth.json"]
            .map(|file| artifacts.join(file))
            .into_iter()
            .find(|path| path.is_file()),
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
