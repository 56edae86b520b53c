//! `carom nightly`: run on what is new, and promote the result only if it passes two gates.
//!
//! Nobody watches. Until the very end the version in use stays in use, whatever stops the program; a candidate that fails a gate
//! is published nowhere. `nightly.json` and the report say what was decided and why.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use check::Severity;
use clap::Args;
use ingest::LogFile;
use serde_json::json;
use stage::Run;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};
use store::{Artifact, ArtifactError, Contents, Store};
use values::{Split, Strike};

use crate::args::{Global, SignArgs};
use crate::first_version::FirstVersion;
use crate::inputs::Inputs;
use crate::left_out::LeftOut;
use crate::nightly::{
    Change, HeldOutGate, LEAST_HELD_OUT, Log, MovedVersion, Night, Server, Since, Status, changed,
    compare_held_out, keep, kept, new_strikes, plan_paths, promised, unseen,
};
use crate::output::{Output, to_json};
use crate::pipeline::{Step, pipeline};
use crate::publishing::store_error;
use crate::results::Results;
use crate::score::Drift;
use crate::steps::{explained, is_too_few, open};
use crate::{Error, outputs, publishing, reading, report, score, signing, words};

/// Chance that good strikes scatter so much that they are set aside.
const QUARANTINE: f64 = 1e-4;
/// A version of fewer strikes is no measure of a table.
const MATURE: usize = 20;
/// New strikes are compared with the latest so many.
const MOST_OLDER: usize = 200;
/// So many strikes since a change teach a version by themselves.
const ALONE: usize = 60;
/// Folder below the run's where what was not put to use waits for strikes that it did not learn from. No robot looks there.
const WAITING: &str = "candidate";

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
    #[arg(long, value_name = "DIR")]
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
    /// Tell an MLflow server what was decided, as a run with the report and the version in use. Where it does not answer the night's
    /// work stands all the same.
    #[arg(long, value_name = "http://HOST:PORT")]
    pub mlflow: Option<Server>,
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
            let mut output = Output {
                outcome: night.outcome(),
                json: to_json(&night)?,
                text: night.text(),
            };
            if let Some(server) = &args.mlflow {
                track(server, dir, &night, &log, &mut output);
            }
            Ok(output)
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

/// Tells a server of the night, unless there was nothing to decide; where that fails it is said, and the night stands.
fn track(server: &Server, dir: &Path, night: &Night, log: &Log, output: &mut Output) {
    if night.status == Status::NothingNew {
        return;
    }
    let (level, said, line) = match server.track(dir, night) {
        Ok(tracked) => {
            let line = format!("run {}, {} files", tracked.run, tracked.files);
            ("info", json!(tracked), line)
        }
        Err(error) => {
            let line = format!("failed to {error}");
            ("warning", json!({ "error": line }), line)
        }
    };
    log.line(level, "mlflow", &said);
    output.json["mlflow"] = said;
    output.text += &format!("mlflow     {line}\n");
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
    if let Some(last) = &last
        && last.basis == basis(inputs, &logs, in_use_now)
    {
        // What was decided then stays to be read; what is wrong with the logs is reported again.
        return Ok(last.clone().again(logs.0, before.as_ref()));
    }

    let learnt_from = inputs.without(last.as_ref().map_or(&[], |last| &last.set_aside));
    let results = match pipeline(run, &learnt_from, Step::Publish) {
        Err(error) if before.is_none() && is_too_few(&error) => {
            let mut night = Night::new(&logs.0, None, basis(inputs, &logs, None));
            night.status = Status::Gathering;
            let error = explained(error, run, &learnt_from);
            night.why.push(format!("failed to {error}"));
            keep(dir, &night)?;
            return Ok(night);
        }
        results => results.map_err(|error| explained(error, run, &learnt_from))?,
    };
    outputs::write(dir, &results, Step::Publish)?;
    if results.read.check.is_meaningless() {
        let mut night = Night::new(
            &results.read.logs,
            before.as_ref(),
            basis(inputs, &logs, in_use_now),
        );
        night.record(&results);
        if let Some(last) = &last {
            night = night.after(last);
        }
        night.status = Status::Refused;
        let findings = &results.read.check.findings;
        let wrong = findings
            .iter()
            .filter(|f| f.severity() == Severity::Meaningless);
        night.why = wrong
            .map(|finding| words::say(finding, &inputs.rig).sentence())
            .collect();
        keep(dir, &night)?;
        report::write(dir, inputs, &results, None)?;
        return Ok(night);
    }
    let mut night = Night::new(&results.read.logs, before.as_ref(), String::new());
    night.record(&results);
    if let Some(last) = &last {
        night = night.after(last);
    }
    log.line("info", "run", &json!({ "strikes": night.strikes, "rejected": night.rejected, "new_logs": night.new_logs, "left_out": night.left_out, "damaged": night.damaged }));
    let chosen = match &before {
        None => {
            night
                .why
                .push("nothing was published before that it could be compared with".into());
            let contents = contents(&results)?;
            first(&results, contents, &mut night)?.then(|| contents.clone())
        }
        Some(before) => {
            let new = report_new(run, inputs, before, &results, &mut night)?;
            night.report_missing(before, &results);
            log.line(
                "info",
                "score",
                &json!({ "drift": night.drift, "missing": night.missing }),
            );
            let was_quarantined = last.as_ref().is_some_and(|last| last.quarantined);
            if !was_quarantined && scatters(run, &new, &results, &mut night)? {
                None
            } else {
                choose(run, store, before, &new, &learnt_from, &results, &mut night)?
            }
        }
    };
    log.line("info", "gates", &json!({ "status": night.status, "why": night.why, "beats": night.beats, "executor": night.executor }));
    let promoted = match &chosen {
        Some(contents) => promote(store, contents, &mut night)?,
        None => None,
    };
    wait(dir, &results, chosen.as_ref(), &mut night)?;
    if night.status == Status::Promoted {
        night.removed = store.retain(usize::from(args.keep)).map_err(store_error)?;
    }
    night.latest = store.latest().ok();
    night.in_use_for = in_use_for(dir);
    // By the version that was compared: one that a person put to use meanwhile makes the next night decide anew.
    let decided = promoted.as_deref().or(night.before.as_deref());
    night.basis = basis(inputs, &logs, decided);
    keep(dir, &night)?;
    // Only now is the one before no longer named.
    if night.waiting.is_some() {
        Store::open(&dir.join(WAITING))
            .retain(1)
            .map_err(store_error)?;
    }
    report::write(dir, inputs, &results, None)?;
    Ok(night)
}

/// Keeps what came out and is not put to use: tomorrow's strikes judge it, for it learnt from none of them.
fn wait(
    dir: &Path,
    results: &Results,
    chosen: Option<&Contents>,
    night: &mut Night,
) -> Result<(), Error> {
    if night.quarantined || !matches!(night.status, Status::Promoted | Status::Kept) {
        return Ok(());
    }
    let contents = results.version().map(|version| &version.contents);
    let unused = contents.filter(|contents| chosen != Some(*contents));
    let waiting = Store::open(&dir.join(WAITING));
    let version = unused.map(|contents| waiting.publish(contents));
    night.waiting = version.transpose().map_err(store_error)?;
    Ok(())
}

fn contents(results: &Results) -> Result<&Contents, Error> {
    let version = results.version();
    let contents = version.map(|version| &version.contents);
    contents.ok_or_else(|| Error::failed("publish: nothing came out"))
}

/// Days since `latest` was written.
fn in_use_for(dir: &Path) -> Option<f64> {
    let written = std::fs::metadata(dir.join("latest"))
        .and_then(|metadata| metadata.modified())
        .ok()?;
    let age = SystemTime::now().duration_since(written).ok()?;
    Some(age.as_secs_f64() / 86_400.0)
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

/// The strikes that are new to the version in use, how well it predicts them, and what it promised.
fn report_new(
    run: &Run,
    inputs: &Inputs,
    before: &Artifact,
    results: &Results,
    night: &mut Night,
) -> Result<Vec<Strike>, Error> {
    let mut known = BTreeSet::new();
    let rig = &results.read.rig;
    for input in changed(before, &results.read.logs) {
        // Where it is not kept what it held, its name must do.
        let of_name = results
            .strikes
            .iter()
            .filter(|strike| strike.log == input.name);
        let of_name = || of_name.map(|strike| strike.id.clone()).collect();
        known.extend(reading::known(run, rig, inputs.seed, input)?.unwrap_or_else(of_name));
    }
    let mut new = new_strikes(before, &results.read.logs, &results.strikes, &known);
    let since = night
        .change
        .as_ref()
        .map_or(f64::NEG_INFINITY, |change| change.since);
    new.retain(|strike| strike.t_start >= since);
    night.new_strikes = new.len();
    if !new.is_empty() {
        let (evaluation, drift) = score::judge(run, before, &new)?;
        let model = before.manifest.provenance.default_model;
        let missed = evaluation.models.get(model.name());
        night.achieved = missed.map(|missed| missed.mean.hypot(missed.sd));
        night.promised = promised(before, &new);
        night.drift = drift;
    }
    Ok(new)
}

/// Whether the new strikes scatter more than the older ones beside what learnt from both, beyond chance: then they are set aside.
fn scatters(
    run: &Run,
    new: &[Strike],
    results: &Results,
    night: &mut Night,
) -> Result<bool, Error> {
    let tonight: BTreeSet<&str> = new.iter().map(|strike| strike.id.as_str()).collect();
    let is_older = |strike: &&Strike| !tonight.contains(strike.id.as_str());
    let older: Vec<Strike> = results.strikes.iter().filter(is_older).cloned().collect();
    if older.len() < MATURE {
        return Ok(false);
    }
    let candidate = loaded(contents(results)?)?;
    let scatter = |strikes: &[Strike]| -> Result<_, Error> {
        let seen = score::observed(run, &candidate, strikes)?;
        Ok(score::varies(&candidate).scatter_of(&seen))
    };
    let latest = &older[older.len().saturating_sub(MOST_OLDER)..];
    let (Some(here), Some(before)) = (scatter(new)?, scatter(latest)?) else {
        return Ok(false);
    };
    let ratio = here.mean_square / before.mean_square;
    let f = FisherSnedecor::new(here.freedom, before.freedom);
    if f.map_or(1.0, |f| f.sf(ratio)) >= QUARANTINE {
        return Ok(false);
    }
    night.status = Status::Refused;
    night.quarantined = true;
    let logs: BTreeSet<&str> = new.iter().map(|strike| strike.log.as_str()).collect();
    night.set_aside.extend(logs.into_iter().map(String::from));
    night.why.push(format!(
        "the new strikes scatter {:.1} times as much as those before: they are not learnt from",
        ratio.sqrt()
    ));
    Ok(true)
}

/// What is put to use in place of the version before: what learnt from all nights, or what learnt since a change for good.
fn choose(
    run: &Run,
    store: &Store,
    before: &Artifact,
    new: &[Strike],
    inputs: &Inputs,
    results: &Results,
    night: &mut Night,
) -> Result<Option<Contents>, Error> {
    // A version of a few strikes does not know the table well enough to say that it changed.
    let is_mature = score::varies(before).strikes >= MATURE;
    let is_changed = is_mature && night.drift.as_ref().is_some_and(Drift::is_beyond_chance);
    if let (true, Some(first)) = (is_changed, new.first()) {
        night.change = Some(Change {
            version: before.version.clone(),
            since: first.t_start,
            what: night
                .drift
                .as_ref()
                .map_or_else(String::new, Drift::sentence),
        });
    }
    let change = night.change.clone();
    let since = change
        .as_ref()
        .map_or(f64::NEG_INFINITY, |change| change.since);
    let mut candidates = vec![("all nights", contents(results)?.clone())];
    if let Some(change) = &change
        && let Ok(base) = store.load(Some(&change.version))
    {
        let strikes: Vec<Strike> = results
            .strikes
            .iter()
            .filter(|strike| strike.t_start >= since)
            .cloned()
            .collect();
        let since = Since {
            base: &base,
            strikes: &strikes,
            all: publishing::logged(&results.strikes),
            inputs: publishing::input_files(&results.read.logs)?,
        };
        if let Some(moved) = since.moved(run)? {
            let held_out = strikes.iter().filter(|strike| strike.split == Split::Test);
            if held_out.count() < LEAST_HELD_OUT {
                return at_once(run, &since, before, moved, results, night);
            }
            candidates.push((
                "the version before, moved by the strikes since",
                moved.contents,
            ));
        }
        let logs: BTreeSet<&str> = strikes.iter().map(|strike| strike.log.as_str()).collect();
        if strikes.len() >= ALONE {
            let older: Vec<String> = results
                .read
                .logs
                .iter()
                .filter(|log| !logs.contains(log.name.as_str()))
                .map(|log| log.name.clone())
                .collect();
            let alone = pipeline(run, &inputs.without(&older), Step::Publish)?;
            candidates.push(("the strikes since alone", contents(&alone)?.clone()));
        }
    }
    let mut best: Option<(f64, &str, HeldOutGate, Contents)> = None;
    let mut gates = Vec::new();
    for (name, contents) in candidates {
        let candidate = loaded(&contents)?;
        if before.manifest == candidate.manifest {
            continue;
        }
        let executor = plan_paths(&candidate, &results.strikes);
        let judges = unseen(&results.strikes, since, [before, &candidate]);
        let gate = compare_held_out(run, before, &candidate, &judges)?;
        let passed = executor.passed;
        if !passed {
            night.why.push(format!("{name}: {}", executor.sentence()));
            night.status = Status::Refused;
        }
        night.executor = Some(executor);
        gates.push((name, gate.clone()));
        let mean = gate.candidate_mean;
        if passed && gate.passed && best.as_ref().is_none_or(|(least, ..)| mean < *least) {
            best = Some((mean, name, gate, contents));
        }
    }
    let waiting = Store::open(&run.dir().join(WAITING));
    if best.is_none() && change.is_none() {
        best = of_last_night(run, &waiting, before, results, night)?;
    }
    if let Some((_, name, gate, contents)) = best {
        night.why.push(format!("from {name}: {}", gate.sentence()));
        night.beats = Some(gate);
        night.status = Status::Promoted;
        return Ok(Some(contents));
    }
    if gates.is_empty() {
        night.why.push("what came out is the version in use".into());
    }
    for (name, gate) in gates {
        night.why.push(format!("from {name}: {}", gate.sentence()));
        night.beats = Some(gate);
    }
    if night.status != Status::Refused {
        // A table that changed and is not followed is somebody's business.
        night.status = if is_changed {
            Status::Refused
        } else if night.beats.is_some() {
            Status::Kept
        } else {
            Status::NothingNew
        };
    }
    Ok(None)
}

/// What came out last night and was not put to use, if it passes on tonight's strikes: it learnt from none of them, so all of them judge.
fn of_last_night(
    run: &Run,
    waiting: &Store,
    before: &Artifact,
    results: &Results,
    night: &mut Night,
) -> Result<Option<(f64, &'static str, HeldOutGate, Contents)>, Error> {
    let Some(version) = &night.waiting else {
        return Ok(None);
    };
    // One that is damaged or gone is no candidate.
    let Ok(candidate) = waiting.load(Some(version)) else {
        return Ok(None);
    };
    if before.manifest == candidate.manifest {
        return Ok(None);
    }
    let judges = unseen(&results.strikes, f64::NEG_INFINITY, [before, &candidate]);
    let gate = compare_held_out(run, before, &candidate, &judges)?;
    let executor = plan_paths(&candidate, &results.strikes);
    if !(gate.passed && executor.passed) {
        return Ok(None);
    }
    night.executor = Some(executor);
    let mean = gate.candidate_mean;
    let contents = Contents::from(candidate);
    Ok(Some((mean, "all nights before tonight", gate, contents)))
}

/// On the night of a change hardly any strike is held out: the moved version is compared by a cross-fit.
fn at_once(
    run: &Run,
    since: &Since<'_>,
    before: &Artifact,
    moved: MovedVersion,
    results: &Results,
    night: &mut Night,
) -> Result<Option<Contents>, Error> {
    let gate = since.compare_cross_fitted(run, before)?;
    let executor = plan_paths(&loaded(&moved.contents)?, &results.strikes);
    night.why.push(format!(
        "{} moved by {}: {} (each strike by what the others show)",
        since.base.version,
        moved.shift,
        gate.sentence()
    ));
    let passed = gate.passed && executor.passed;
    night.status = if passed {
        Status::Promoted
    } else {
        Status::Refused
    };
    (night.beats, night.executor) = (Some(gate), Some(executor));
    Ok(passed.then_some(moved.contents))
}

/// The first version: the executor's gate, and that of first versions.
fn first(results: &Results, contents: &Contents, night: &mut Night) -> Result<bool, Error> {
    let executor = plan_paths(&loaded(contents)?, &results.strikes);
    night.why.push(executor.sentence());
    let mut passed = executor.passed;
    let gate = results.version().map(|version| &version.gate);
    if let Some(gate) = gate {
        night.why.extend(gate.sentences());
        passed &= gate.passed;
    }
    let is_waiting = gate.is_some_and(FirstVersion::is_waiting);
    night.status = if passed {
        Status::Promoted
    } else if is_waiting {
        Status::Gathering
    } else {
        Status::Refused
    };
    night.executor = Some(executor);
    Ok(passed)
}

/// What came out as a robot would load it: published in a folder that is thrown away.
fn loaded(contents: &Contents) -> Result<Artifact, Error> {
    let scratch = tempfile::tempdir().map_err(Error::failed)?;
    let store = Store::open(scratch.path());
    store.publish(contents).map_err(store_error)?;
    store.load(None).map_err(store_error)
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
