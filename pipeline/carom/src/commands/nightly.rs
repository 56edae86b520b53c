//! `carom nightly`: run on what is new, and promote the result only if it passes two gates.
//!
//! Nobody watches. Until the very end the version in use stays in use, whatever stops the program; a candidate that fails a gate
//! is published nowhere. `nightly.json` and the report say what was decided and why.

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::Args;
use ingest::LogFile;
use serde_json::json;
use stage::Run;
use store::{Artifact, ArtifactError, Contents, Store};

use crate::args::{Global, SignArgs};
use crate::inputs::Inputs;
use crate::left_out::LeftOut;
use crate::nightly::{
    Log, Night, Status, changed, compare_held_out, held_out, keep, kept, new_strikes, plan_paths,
};
use crate::output::{Output, to_json};
use crate::pipeline::{Step, pipeline};
use crate::publishing::store_error;
use crate::results::Results;
use crate::steps::{explained, open};
use crate::{Error, outputs, publishing, reading, report, score, signing};

/// `carom nightly`.
#[derive(Args, Debug)]
pub struct NightlyArgs {
    /// MCAP files, or folders that are searched for them with all below [default: those that the run was begun with].
    #[arg(value_name = "LOGS", requires = "rig")]
    pub logs: Vec<PathBuf>,
    /// The rig file.
    #[arg(long, value_name = "FILE", requires = "logs")]
    pub rig: Option<PathBuf>,
    /// Folder of the run.
    #[arg(long, value_name = "DIR", default_value = "artifacts/demo")]
    pub out: PathBuf,
    /// Seed of the split into training and held-out strikes, and of training; goes with LOGS.
    #[arg(long, default_value_t = 0, requires = "logs")]
    pub seed: u64,
    /// Diagnose, but add no effect to the world; goes with LOGS.
    #[arg(long, requires = "logs")]
    pub without_effects: bool,
    /// Versions to keep: older ones are removed, the one in use never.
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u16).range(2..))]
    pub keep: u16,
    /// Log as JSON, an object a line, on standard error, and nothing else there.
    #[arg(long)]
    pub log_json: bool,
    /// Who signs.
    #[command(flatten)]
    pub sign: SignArgs,
}

/// The night's work in one folder.
pub fn run(args: &NightlyArgs, global: Global) -> Result<Output, Error> {
    let dir = &args.out;
    let log = Log::new(args.log_json);
    let global = Global {
        quiet: global.quiet || args.log_json,
        ..global
    };
    let worked = begin(args, global, &log).and_then(|(run, store, inputs)| {
        let night = work(&run, &store, &inputs, args, &log);
        if let Err(error) = &night
            && !durable::faults::dead()
        {
            // The error is the one to report.
            let _ = keep(
                dir,
                &Night::failed(error, store.latest().ok(), kept(dir).as_ref()),
            );
        }
        night
    });
    match worked {
        Ok(night) => {
            log.line(
                "info",
                "end",
                &json!({ "status": night.status, "latest": night.latest }),
            );
            Ok(Output {
                outcome: night.outcome(),
                json: to_json(&night)?,
                text: night.text(),
            })
        }
        Err(error) => {
            let outcome = error.outcome() as u8;
            log.line(
                "error",
                "end",
                &json!({ "exit": outcome, "error": error.to_string() }),
            );
            Err(error)
        }
    }
}

/// The run, locked; its store; and the logs as they are tonight.
fn begin(args: &NightlyArgs, global: Global, log: &Log) -> Result<(Run, Store, Inputs), Error> {
    let dir = &args.out;
    let inputs = match &args.rig {
        Some(rig) => Inputs::of(&args.logs, rig, args.seed, args.without_effects)?,
        None => Inputs::kept(dir)?.again()?,
    };
    let store = signing::store(dir, args.sign.key.as_deref())?;
    let run = open(dir, global)?;
    // Better now than after hours.
    store.check_key().map_err(store_error)?;
    inputs.keep(dir)?;
    log.line(
        "info",
        "begin",
        &json!({ "out": dir, "logs": inputs.logs.len() }),
    );
    Ok((run, store, inputs))
}

fn work(
    run: &Run,
    store: &Store,
    inputs: &Inputs,
    args: &NightlyArgs,
    log: &Log,
) -> Result<Night, Error> {
    let dir = run.dir();
    let logs = reading::open(&inputs.logs);
    let before = in_use(store)?;
    let last = kept(dir);
    let in_use_now = before.as_ref().map(|before| before.version.as_str());
    let asked = last.as_ref().map_or(0, |last| last.asked_of(in_use_now));
    if let Some(last) = last.filter(|last| last.basis == basis(inputs, &logs, in_use_now)) {
        // What was decided then stays to be read; what is wrong with the logs is reported again.
        return Ok(last.again(logs.0, before.as_ref()));
    }

    let results =
        pipeline(run, inputs, Step::Publish).map_err(|error| explained(error, run, inputs))?;
    outputs::write(dir, &results, Step::Publish)?;
    let contents = results
        .contents
        .as_ref()
        .ok_or_else(|| Error::failed("publish: nothing came out"))?;
    let mut night = Night::new(&results.logs, before.as_ref(), String::new());
    night.record(&results);
    night.asked = asked;
    log.line("info", "run", &json!({ "strikes": night.strikes, "rejected": night.rejected, "new_logs": night.new_logs, "left_out": night.left_out, "damaged": night.damaged }));
    if let Some(before) = &before {
        report_drift(run, inputs, before, &results, &mut night)?;
        night.report_missing(before, &results);
        log.line(
            "info",
            "score",
            &json!({ "drift": night.drift, "missing": night.missing }),
        );
    }

    let is_passed = pass_gates(run, before.as_ref(), contents, &results, &mut night)?;
    log.line("info", "gates", &json!({ "status": night.status, "why": night.why, "beats": night.beats, "executor": night.executor }));
    let promoted = if is_passed {
        promote(store, contents, &mut night)?
    } else {
        None
    };
    if night.status == Status::Promoted {
        night.removed = store.retain(usize::from(args.keep)).map_err(store_error)?;
    }
    night.latest = store.latest().ok();
    // By the version that was compared: one that a person put to use meanwhile makes the next night decide anew.
    let decided = promoted.as_deref().or(night.before.as_deref());
    night.basis = basis(inputs, &logs, decided);
    keep(dir, &night)?;
    report::write(dir, inputs, &results)?;
    Ok(night)
}

/// The version in use, checked; none where nothing was published yet.
fn in_use(store: &Store) -> Result<Option<Artifact>, Error> {
    match store.load(None) {
        Ok(artifact) => Ok(Some(artifact)),
        Err(ArtifactError::NoLatest { .. }) => Ok(None),
        Err(error) => Err(store_error(error)),
    }
}

/// What a decision hangs on: where nothing of it changed, there is nothing to decide.
fn basis(
    inputs: &Inputs,
    (logs, left_out): &(Vec<LogFile>, Vec<LeftOut>),
    in_use: Option<&str>,
) -> String {
    // By their names, too, for tables name them: a copy that was taken away is no longer listed.
    let logs: BTreeSet<_> = logs.iter().map(|log| (&log.name, &log.sha256)).collect();
    let (seed, without_effects) = (inputs.seed, inputs.without_effects);
    let all = json!([
        logs,
        left_out,
        inputs.rig.to_toml(),
        seed,
        without_effects,
        publishing::engine(),
        in_use,
    ]);
    durable::sha256(all.to_string().as_bytes())
}

/// How well the version in use predicts the strikes that are new to it.
fn report_drift(
    run: &Run,
    inputs: &Inputs,
    before: &Artifact,
    results: &Results,
    night: &mut Night,
) -> Result<(), Error> {
    let mut known = BTreeSet::new();
    for input in changed(before, &results.logs) {
        // Where it is not kept what it held, its name must do.
        let of_name = results
            .strikes
            .iter()
            .filter(|strike| strike.log == input.name);
        let of_name = || of_name.map(|strike| strike.id.clone()).collect();
        known.extend(reading::known(run, inputs, input)?.unwrap_or_else(of_name));
    }
    let strikes = new_strikes(before, &results.logs, &results.strikes, &known);
    night.new_strikes = strikes.len();
    if !strikes.is_empty() {
        (_, night.drift) = score::judge(run, before, strikes)?;
    }
    Ok(())
}

/// Both gates. What came out is published in a folder that is thrown away, and loaded from there as a robot would.
fn pass_gates(
    run: &Run,
    before: Option<&Artifact>,
    contents: &Contents,
    results: &Results,
    night: &mut Night,
) -> Result<bool, Error> {
    let scratch = tempfile::tempdir().map_err(Error::failed)?;
    let store = Store::open(scratch.path());
    store.publish(contents).map_err(store_error)?;
    let candidate = store.load(None).map_err(store_error)?;
    if before.is_some_and(|before| before.manifest == candidate.manifest) {
        night.why.push("what came out is the version in use".into());
        return Ok(false);
    }
    let executor = plan_paths(&candidate, &results.strikes);
    night.why.push(executor.sentence());
    let mut is_passed = executor.passed;
    night.executor = Some(executor);
    match before {
        Some(before) => {
            let strikes = held_out(&results.strikes);
            night.asked += 1;
            let beats = compare_held_out(run, before, &candidate, &strikes, night.asked)?;
            night.why.push(beats.sentence());
            is_passed &= beats.passed;
            night.beats = Some(beats);
        }
        None => night
            .why
            .push("nothing was published before that it could be compared with".into()),
    }
    night.status = if is_passed {
        Status::Promoted
    } else {
        Status::Refused
    };
    Ok(is_passed)
}

/// Publishes the candidate, if the version in use is still the one that it was compared with; its name where it is then in use. One
/// that a person rolled back stays out of use.
fn promote(store: &Store, contents: &Contents, night: &mut Night) -> Result<Option<String>, Error> {
    let version = match store.promote(contents, night.before.as_deref()) {
        Ok(version) => version,
        Err(error @ ArtifactError::Overtaken { .. }) => {
            night.status = Status::Refused;
            night.why.push(format!("failed to {error}"));
            return Ok(None);
        }
        Err(error) => return Err(store_error(error)),
    };
    if store.latest().is_ok_and(|latest| latest == version) {
        return Ok(Some(version));
    }
    night.status = Status::Refused;
    night.why.push(format!(
        "it is {version}, which was rolled back: `carom artifacts rollback {version}` takes it again"
    ));
    Ok(None)
}
