//! Each command: from checked arguments to files and a result that can be printed.

use std::path::Path;

use serde_json::{Value, json};
use stage::{Options, Run};
use store::Store;
use sysid::SysidError;

use crate::args::{ArtifactsCommand, Cli, Command, Global, KeyCommand, LogsArgs, RigCommand};
use crate::error::Outcome;
use crate::inputs::Inputs;
use crate::pipeline::{Step, pipeline};
use crate::report::{self, Shown};
use crate::results::Results;
use crate::{
    Error, artifacts, dataset, demo, nightly, outputs, publishing, rebuild, score, signing,
    summary, trial,
};

/// What a command has to say: for machines and for people.
pub struct Said {
    /// How it ended.
    pub outcome: Outcome,
    /// For `--json`.
    pub json: Value,
    /// For people.
    pub text: String,
}

impl Said {
    /// Done, with nothing to complain of.
    pub fn done(json: Value, text: String) -> Self {
        Self {
            outcome: Outcome::Done,
            json,
            text,
        }
    }
}

/// Does what was asked.
pub fn execute(cli: &Cli) -> Result<Said, Error> {
    let global = cli.global;
    match &cli.command {
        Command::Demo(args) => {
            let written = demo::demo(args)?;
            let logs = written.logs.len();
            Ok(Said::done(
                json!({
                    "rig": written.rig, "logs": written.logs, "truth": written.truth, "strikes": written.strikes,
                }),
                format!(
                    "{} strikes in {logs} logs under {}, rig file {}\n",
                    written.strikes,
                    args.out.join("logs").display(),
                    written.rig.display()
                ),
            ))
        }
        Command::Rig(RigCommand::Init { out }) => {
            let text = demo::rig_init(out.as_deref())?;
            Ok(Said::done(json!({ "rig": out }), text))
        }
        Command::Ingest(args) => begin(args, Step::Ingest, None, global),
        Command::Run(args) => begin(&args.logs, Step::Publish, args.sign.key.as_deref(), global),
        Command::Sysid(args) => proceed(&args.out, Step::Sysid, global),
        Command::Diagnose(args) => proceed(&args.out, Step::Diagnose, global),
        Command::Solve(args) => proceed(&args.out, Step::Solve, global),
        Command::Residual(args) => proceed(&args.out, Step::Residual, global),
        Command::Train(args) => proceed(&args.out, Step::Train, global),
        Command::Evaluate(args) => proceed(&args.out, Step::Evaluate, global),
        Command::Publish(args) => {
            let inputs = Inputs::kept(&args.out)?;
            let store = signing::store(&args.out, args.sign.key.as_deref())?;
            go(&open(&args.out, global)?, &store, &inputs, Step::Publish)
        }
        Command::Report(args) => {
            let inputs = Inputs::kept(&args.dir)?;
            let run = open(&args.dir, global)?;
            let results = pipeline(&run, &inputs, Step::Evaluate)?;
            let path = write_report(&args.dir, &inputs, &results)?;
            Ok(Said::done(
                json!({ "report": path }),
                format!("report     {path}\n"),
            ))
        }
        Command::Nightly(args) => {
            // A log of objects has no other lines in it.
            let is_quiet = global.quiet || args.log_json;
            nightly::nightly(
                args,
                Global {
                    quiet: is_quiet,
                    ..global
                },
            )
        }
        Command::Trial(args) => {
            let trial = trial::trial(args, global.quiet)?;
            let text = summary::trial(&trial);
            refresh_report(&args.artifacts, global)?;
            Ok(Said::done(to_json(&trial)?, text))
        }
        Command::Score(args) => score::score(args, global),
        Command::Dataset(command) => dataset::dataset(command),
        Command::Rebuild(args) => rebuild::rebuild(args, global),
        Command::Key(KeyCommand::New { out }) => signing::new_key(out),
        Command::Artifacts(command) => artifacts(command),
    }
}

/// A new run, or one that goes on with other logs.
fn begin(args: &LogsArgs, last: Step, key: Option<&Path>, global: Global) -> Result<Said, Error> {
    let inputs = Inputs::named(args)?;
    let store = signing::store(&args.out, key)?;
    let run = open(&args.out, global)?;
    inputs.keep(&args.out)?;
    go(&run, &store, &inputs, last)
}

/// A run that goes on with what it was given.
fn proceed(dir: &Path, last: Step, global: Global) -> Result<Said, Error> {
    let inputs = Inputs::kept(dir)?;
    let run = open(dir, global)?;
    go(&run, &Store::open(dir), &inputs, last)
}

/// A run in a folder; the programs below the stages are part of every key.
pub fn open(dir: &Path, global: Global) -> Result<Run, Error> {
    let options = Options {
        engine: publishing::engine(),
        is_quiet: global.quiet,
    };
    Ok(Run::open(dir, options)?)
}

fn go(run: &Run, store: &Store, inputs: &Inputs, last: Step) -> Result<Said, Error> {
    let dir = run.dir();
    let mut results = pipeline(run, inputs, last).map_err(|error| explained(error, run, inputs))?;
    outputs::write(dir, &results, last)?;
    results.version = publishing::publish(store, &results)?;
    let report = match last {
        Step::Diagnose | Step::Publish => Some(write_report(dir, inputs, &results)?),
        _ => None,
    };
    let summary = run.summary();
    let mut text = format!("{summary}\n{}", summary::results(&results));
    let latest = store.latest().ok();
    if let Some(version) = &results.version {
        text += &format!("\nversion    {version} in {}\n", dir.display());
        text += &summary::rolled_back(version, latest.as_deref());
    }
    if let Some(report) = &report {
        text += &format!("report     {report}\n");
    }
    if last == Step::Diagnose {
        text += &format!(
            "           up to the diagnosis; `carom report {}` shows every step\n",
            dir.display()
        );
    }
    let errors = results.evaluation.as_ref().map(
        |evaluation| json!({ "models": evaluation.models, "noise_floor": evaluation.noise_floor }),
    );
    let json = json!({
        "strikes": results.kept.len(),
        "rejects": results.rejects,
        "left_out": results.left_out,
        "log_notes": results.log_notes,
        "stages": summary.stages,
        "parameters": results.fit.as_ref().map(|fit| &fit.world.parameters),
        "notes": results.fit.as_ref().map(|fit| &fit.notes),
        "diagnosis": results.found.as_ref().map(|found| &found.diagnosis),
        "no_diagnosis": results.no_diagnosis,
        "stop_error": errors,
        "version": results.version,
        "latest": latest,
        "report": report,
    });
    Ok(Said {
        outcome: results.outcome(),
        json,
        text,
    })
}

/// Where too few strikes learn, how many were kept at all: a person counts those.
pub fn explained(error: Error, run: &Run, inputs: &Inputs) -> Error {
    let Error::Input(source) = &error else {
        return error;
    };
    let too_few = source.downcast_ref::<SysidError>();
    if !matches!(too_few, Some(SysidError::TooFewStrikes { .. })) {
        return error;
    }
    match pipeline(run, inputs, Step::Ingest) {
        Ok(results) => Error::input(format!(
            "{error} ({} were kept; only those of the training split learn, about 81 %)",
            results.kept.len()
        )),
        Err(_) => error,
    }
}

/// The report of a run, with its latest trial, and its version (else the latest) where there are any. Gives its path.
pub fn write_report(dir: &Path, inputs: &Inputs, results: &Results) -> Result<String, Error> {
    let trial = trial::kept(dir);
    let provenance = artifacts::provenance(dir, results)?.unwrap_or_default();
    let night = nightly::kept(dir);
    let shown = Shown {
        inputs,
        results,
        trial: trial.as_ref(),
        provenance: &provenance,
        night: night.as_ref(),
    };
    report::write(&shown, dir)?;
    Ok(dir.join(report::FILE).display().to_string())
}

/// Writes the report again where the folder is a run's: a copy of its versions alone has none.
fn refresh_report(dir: &Path, global: Global) -> Result<(), Error> {
    if !dir.join(report::FILE).is_file() {
        return Ok(());
    }
    let inputs = Inputs::kept(dir)?;
    let run = open(dir, global)?;
    let results = pipeline(&run, &inputs, Step::Evaluate)?;
    write_report(dir, &inputs, &results).map(drop)
}

fn artifacts(command: &ArtifactsCommand) -> Result<Said, Error> {
    let (json, text) = match command {
        ArtifactsCommand::List(args) => artifacts::list(&args.artifacts)?,
        ArtifactsCommand::Show(args) => artifacts::show(&args.artifacts, args.version.as_deref())?,
        ArtifactsCommand::Verify { version, key } => {
            let key = key.as_deref().map(signing::public_key).transpose()?;
            artifacts::verify(&version.artifacts, version.version.as_deref(), key.as_ref())?
        }
        ArtifactsCommand::Sign { artifacts, key } => {
            artifacts::sign(&signing::store(artifacts, Some(key))?)?
        }
        ArtifactsCommand::Rollback {
            version,
            artifacts,
            sign,
        } => {
            let store = signing::store(artifacts, sign.key.as_deref())?;
            artifacts::rollback(&store, version.as_deref())?
        }
    };
    Ok(Said::done(json, text))
}

/// A result for machines.
pub fn to_json<T: serde::Serialize>(value: &T) -> Result<Value, Error> {
    serde_json::to_value(value).map_err(Error::failed)
}
