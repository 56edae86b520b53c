//! The command line: arguments become one plan, one strike and one answer.

mod adapt;
mod failure;
mod load;
mod show;
mod strike_one;

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

use strike::{Args, Choice, Planner, batch};
use values::Point;

use failure::Failure;
use load::load;
use strike_one::strike_one;

/// Done, but a line of the batch was refused, the log was written under another name, or the camera did not see the object moved and at rest.
const REJECTED: u8 = 3;

/// Runs the command. The artifact is verified whole before anything else, and no robot is opened before a plan has
/// passed every limit.
pub fn run(args: Args) -> Result<ExitCode, Failure> {
    if args.log.is_some() && args.robot == Choice::DryRun {
        return Err(Failure::usage(
            "--log goes with a robot that strikes, and dry-run moves nothing: add --robot sim, or take --log away",
        ));
    }
    #[cfg(feature = "sim")]
    if args.watch.is_some() && matches!(args.robot, Choice::Sim(_)) {
        return Err(Failure::usage(
            "--watch goes with an arm or with dry-run: the embedded rig has a camera of its own",
        ));
    }
    if args.robot.moves() && args.from.is_none() && args.watch.is_none() {
        return Err(Failure::usage(
            "say where the object lies before an arm strikes: --from X Y, or --watch ws://HOST:PORT, whose camera sees it",
        ));
    }
    let args = Args {
        artifacts: load::local(&args)?,
        ..args
    };
    let args = &args;
    let (artifact, rig) = load(args)?;
    let model = args
        .model
        .unwrap_or(artifact.manifest.provenance.default_model);
    let planner = Planner::within(&artifact, model, &rig).map_err(Failure::input)?;
    let planner = match &args.session {
        Some(session) => planner
            .in_session(&artifact, session)
            .map_err(Failure::input)?,
        None if args.adapt => adapt::by_own_strikes(args, &artifact, planner)?,
        None if !args.recent.is_empty() => adapt::by_logs(&args.recent, &artifact, planner)?,
        None => planner,
    };
    let planner = planner.good_for_longer(args.pause());
    match (&args.batch, &args.to) {
        (Some(file), _) => plan_batch(args, &planner, file),
        (None, Some(to)) => strike_one(args, &planner, &artifact.manifest.sha256, point(to)),
        (None, None) => Err(Failure::usage(
            "give a target, `--to X Y`, or `--batch FILE`",
        )),
    }
}

fn plan_batch(args: &Args, planner: &Planner, file: &Path) -> Result<ExitCode, Failure> {
    let output = io::stdout().lock();
    let counts = if file == Path::new("-") {
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
            counts.planned,
            counts.refused
        )
        .map_err(|error| Failure::failed(format!("print the result: {error}")))?;
    }
    Ok(if counts.refused == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(REJECTED)
    })
}

fn point(coordinates: &[f64]) -> Point {
    Point::new(coordinates[0], coordinates[1])
}
