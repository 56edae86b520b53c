//! The steps of a run, from its folder to files, a version and what there is to print.

use std::path::Path;

use check::Severity;
use serde_json::json;
use stage::{Options, Run, Share};
use store::Store;
use sysid::SysidError;

use crate::args::Global;
use crate::error::{Outcome, Output};
use crate::inputs::Inputs;
use crate::pipeline::{Step, pipeline};
use crate::results::Worlds;
use crate::{Error, fetching, outputs, publishing, report, summary, tracking};

/// A run in a folder, alone; the programs below the stages are part of every key.
pub fn open(dir: &Path, global: Global) -> Result<Run, Error> {
    let run = Run::open(dir, options(global))?;
    tracking::sweep(dir)?;
    fetching::sweep(dir)?;
    Ok(run)
}

/// A share of the work on a run, beside others.
pub fn join(dir: &Path, share: Share, global: Global) -> Result<Run, Error> {
    Ok(Run::join(dir, options(global), share)?)
}

fn options(global: Global) -> Options {
    Options {
        engine: publishing::engine(),
        is_quiet: global.quiet,
    }
}

/// Goes through the steps up to and with `last`, writes the run's files, publishes where `last` says so, and reports what came out.
pub fn advance(
    run: &Run,
    store: &Store,
    inputs: &Inputs,
    last: Step,
    global: Global,
) -> Result<Output, Error> {
    let dir = run.dir();
    let results = pipeline(run, inputs, last).map_err(|error| explained(error, run, inputs))?;
    outputs::write(dir, &results, last)?;
    let latest_before = store.latest().ok();
    let is_candidate = latest_before.is_none()
        && results
            .version()
            .is_some_and(|version| !version.gate.passed);
    let version = publishing::publish(store, &results, is_candidate)?;
    let report = match last {
        Step::Diagnose | Step::Publish => {
            Some(report::write(dir, inputs, &results, version.as_deref())?)
        }
        _ => None,
    };
    let summary = run.summary();
    // A command that runs a single step prints all figures of that step.
    let mut text = if global.verbose || last < Step::Publish {
        format!("{summary}\n{}", summary::details(&results))
    } else {
        summary::overview(&results)
    };
    text += &summary::findings(&results.read.check, &inputs.rig, Severity::Told);
    if results.read.check.is_meaningless() && last > Step::Ingest {
        text += "refused    a model of these logs would be meaningless: nothing is fitted, nothing is published\n";
    }
    let latest = store.latest().ok();
    let gate = results.version().map(|version| &version.gate);
    let worlds = results.worlds.as_ref();
    let fit = worlds.map(|worlds| &worlds.fit);
    if let Some(version) = &version {
        text += &format!("\nversion    {version} in {}\n", dir.display());
        if is_candidate {
            text += &summary::candidate(version, gate);
        } else {
            text += &summary::rolled_back(version, latest.as_deref());
        }
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
    let errors = results.evaluation().map(|evaluation| {
        json!({
            "models": evaluation.models,
            "noise_floor": evaluation.noise_floor,
            "new_sessions": evaluation.new_sessions,
        })
    });
    let json = json!({
        "strikes": results.read.strikes.len(),
        "rejects": results.read.rejects,
        "left_out": results.read.left_out,
        "log_notes": results.read.notes,
        "findings": summary::findings_json(&results.read.check, &inputs.rig),
        "first_version": gate,
        "stages": summary.stages,
        "parameters": worlds.map(|worlds| &worlds.used().1.world.parameters),
        "parameters_before_effects": fit.map(|fit| &fit.world.parameters),
        "warnings": results.warnings(),
        "notes": fit.map(|fit| &fit.notes),
        "diagnosis": results.found().map(|found| &found.diagnosis),
        "no_diagnosis": worlds.and_then(Worlds::no_diagnosis),
        "stop_error": errors,
        "version": version,
        "latest": latest,
        "report": report,
    });
    let outcome = if is_candidate {
        Outcome::Refused
    } else {
        results.outcome()
    };
    Ok(Output::ended(outcome, json, text))
}

/// Whether too few strikes learn.
pub fn is_too_few(error: &Error) -> bool {
    let Error::Input(source) = error else {
        return false;
    };
    let too_few = source.downcast_ref::<SysidError>();
    matches!(too_few, Some(SysidError::TooFewStrikes { .. }))
}

/// Where too few strikes learn, how many were kept at all: a person counts those.
pub fn explained(error: Error, run: &Run, inputs: &Inputs) -> Error {
    if !is_too_few(&error) {
        return error;
    }
    match pipeline(run, inputs, Step::Ingest) {
        Ok(results) => Error::input(format!(
            "{error} ({} were kept; of many strikes 81 % are learnt from, the others are held out: 100 are a good start)",
            results.read.strikes.len()
        )),
        Err(_) => error,
    }
}

/// Writes the report again where the folder is a run's: a copy of its versions alone has none.
pub fn refresh_report(dir: &Path, global: Global) -> Result<(), Error> {
    if !dir.join(report::FILE).is_file() {
        return Ok(());
    }
    let inputs = Inputs::kept(dir)?;
    let run = open(dir, global)?;
    let results = pipeline(&run, &inputs, Step::Evaluate)?;
    report::write(dir, &inputs, &results, None).map(drop)
}
