//! `carom nightly`: run on what is new, and promote the result only if it passes two gates.
//!
//! Nobody watches. Until the very end the version in use stays in use, whatever stops the program; a candidate that fails a gate
//! is published nowhere. `nightly.json` and the report say what was decided and why.

use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use check::Severity;
use clap::Args;
use ingest::LogFile;
use serde_json::{Value, json};
use stage::Run;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};
use store::{Artifact, ArtifactError, Contents, Store};
use values::Strike;

use crate::args::{Global, SignArgs};
use crate::error::{Output, to_json};
use crate::first_version::FirstVersion;
use crate::inputs::Inputs;
use crate::left_out::LeftOut;
use crate::nightly::{
    Change, ExecutorGate, FleetNight, HeldOutGate, Log, Night, RigNight, Server, Since, Status,
    changed, compare_held_out, gone, keep, kept, new_strikes, plan_paths, promised, recipes,
    unseen,
};
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
/// Greatest number of earlier strikes that new ones are compared with, the latest.
const MOST_OLDER: usize = 200;
/// Greatest number of strikes since a change, the latest, that say where the table is: enough to know it to a twentieth of what strikes scatter by.
const MOST_SINCE: usize = 200;
/// Number of strikes since a change from which they teach a version by themselves.
const ALONE: usize = 60;
/// Folder below the run's where what was not put to use waits for strikes that it did not learn from. No robot looks there.
const WAITING: &str = "candidate";

/// `carom nightly`.
#[derive(Args, Clone, Debug)]
pub struct NightlyArgs {
    /// MCAP files, or folders that are searched for them with all below [default: those that the run was begun with].
    #[arg(value_name = "LOGS", requires = "rig")]
    pub logs: Vec<PathBuf>,
    /// The rig file.
    #[arg(long, value_name = "FILE", requires = "logs")]
    pub rig: Option<PathBuf>,
    /// Several rigs in place of one: a TOML file with a table for each, `[NAME]`, that holds `logs = [...]`, `rig = "rig.toml"` and, if
    /// wanted, `seed`. Each has its run in DIR/NAME and is decided on by itself; DIR/fleet.json and fleet.html are about all.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["logs", "rig"])]
    pub fleet: Option<PathBuf>,
    /// Folder of the run, or of the fleet's runs.
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

/// The night's work in one folder, or in each of a fleet's.
pub fn run(args: &NightlyArgs, global: Global) -> Result<Output, Error> {
    let global = Global {
        quiet: global.quiet || args.log_json,
        ..global
    };
    if let Some(file) = &args.fleet {
        return fleet(file, args, global);
    }
    let (night, tracked) = one(args, None, global)?;
    let mut output = Output::ended(night.outcome(), to_json(&night)?, night.text());
    if let Some((said, line)) = tracked {
        output.json["mlflow"] = said;
        output.text += &format!("mlflow     {line}\n");
    }
    Ok(output)
}

/// One rig's night after the other's, each whatever became of those before, and what they have in common.
fn fleet(file: &Path, args: &NightlyArgs, global: Global) -> Result<Output, Error> {
    let mut rigs = Vec::new();
    let mut in_use_by = BTreeMap::new();
    durable::create_dir(&args.out)?;
    for (name, recipe) in recipes(file)? {
        let dir = args.out.join(&name);
        let worked = recipe.named(&[]).and_then(|logs| {
            let args = NightlyArgs {
                logs,
                rig: Some(recipe.rig_file()),
                fleet: None,
                out: dir.clone(),
                seed: recipe.seed,
                ..args.clone()
            };
            // A defect that one rig's strikes bring to light is no other's.
            let one = AssertUnwindSafe(|| one(&args, Some(&name), global));
            let one = catch_unwind(one).unwrap_or_else(|_| Err(Error::failed("go on: a defect")));
            one.map(|(night, tracked)| (night, tracked.map(|(_, line)| line)))
        });
        rigs.push(RigNight::of(&name, worked));
        if let Ok(Some(artifact)) = in_use(&Store::open(&dir)) {
            in_use_by.insert(name, artifact);
        }
    }
    let night = FleetNight::of(rigs, &in_use_by);
    outputs::write_json(&args.out.join("fleet.json"), &night)?;
    report::write_fleet(&args.out, &night)?;
    Ok(Output::ended(
        night.outcome(),
        to_json(&night)?,
        night.text(),
    ))
}

/// A night, and what an MLflow server said of it, where one was to be told.
type Told = (Night, Option<(Value, String)>);

/// The night's work in one folder, of that rig where it is one of a fleet.
fn one(args: &NightlyArgs, rig: Option<&str>, global: Global) -> Result<Told, Error> {
    let dir = &args.out;
    let log = Log::new(args.log_json, rig);
    let worked = begin(args, global, &log).and_then(|(run, store, inputs)| {
        let night = work(&run, &store, &inputs, args, &log);
        if let Err(error) = &night
            && !durable::faults::dead()
            && let Ok(last) = kept(dir)
        {
            // The error is the one to report.
            let _ = keep(
                dir,
                &Night::failed(error, store.latest().ok(), last.as_ref()),
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
            let server = args.mlflow.as_ref();
            let tracked = server.and_then(|server| track(server, dir, &night, &log));
            Ok((night, tracked))
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
fn track(server: &Server, dir: &Path, night: &Night, log: &Log<'_>) -> Option<(Value, String)> {
    if night.status == Status::NothingNew {
        return None;
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
    Some((said, line))
}

/// The run, locked; its store; and the logs as they are tonight.
fn begin(args: &NightlyArgs, global: Global, log: &Log<'_>) -> Result<(Run, Store, Inputs), Error> {
    let dir = &args.out;
    let inputs = match &args.rig {
        Some(rig) => Inputs::of(&args.logs, rig, args.seed, args.without_effects, dir)?,
        None => Inputs::kept(dir)?.again(dir)?,
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
    log: &Log<'_>,
) -> Result<Night, Error> {
    let dir = run.dir();
    let logs = reading::open(run, &inputs.logs);
    let before = in_use(store)?;
    let last = kept(dir)?;
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
            night.because(format!("failed to {error}"));
            keep(dir, &night)?;
            return Ok(night);
        }
        results => results.map_err(|error| explained(error, run, &learnt_from))?,
    };
    outputs::write(dir, &results, Step::Publish)?;
    let mut night = Night::new(&results.read.logs, before.as_ref(), String::new());
    night.record(&results);
    if let Some(last) = &last {
        night = night.after(last);
    }
    if results.read.check.is_meaningless() {
        night.basis = basis(inputs, &logs, in_use_now);
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
    log.line("info", "run", &json!({ "strikes": night.strikes, "rejected": night.rejected, "new_logs": night.new_logs, "left_out": night.left_out, "damaged": night.damaged }));
    let choice = match &before {
        None => {
            night.because("nothing was published before that it could be compared with".into());
            let contents = contents(&results)?;
            let passed = first(&results, contents, &mut night)?;
            Choice {
                chosen: passed.then(|| contents.clone()),
                waits: None,
            }
        }
        Some(before) => {
            let new = report_new(run, inputs, before, &results, &mut night)?;
            // What is new may have begun on the table of before: a change lies among the strikes of a night, or a night was not learnt from.
            let step = score::step(run, before, &new)?;
            let (earlier, latest) = new.split_at(step);
            if step > 0 {
                (_, night.drift) = score::judge(run, before, latest)?;
            }
            night.report_missing(before, &results);
            log.line(
                "info",
                "score",
                &json!({ "drift": night.drift, "missing": night.missing }),
            );
            let was_quarantined = last.as_ref().is_some_and(|last| last.quarantined);
            let gone = gone(before, &results.read.logs);
            if !gone.is_empty() {
                night.because(format!(
                    "what {} learnt from is no longer there: {}; put it back, or publish without it by `carom run`",
                    before.version,
                    gone.join(", ")
                ));
            }
            if !gone.is_empty() && night.new_logs.is_empty() {
                // Nothing was learnt that the version in use does not know.
                night.status = Status::Kept;
                Choice::default()
            } else if !was_quarantined && scatters(run, [earlier, latest], &results, &mut night)? {
                Choice::default()
            } else {
                choose(
                    run,
                    store,
                    before,
                    latest,
                    &learnt_from,
                    &results,
                    &mut night,
                )?
            }
        }
    };
    log.line("info", "gates", &json!({ "status": night.status, "why": night.why, "beats": night.beats, "executor": night.executor }));
    let promoted = match &choice.chosen {
        Some(contents) => promote(store, contents, &mut night)?,
        None => None,
    };
    if matches!(night.status, Status::Promoted | Status::Kept) {
        night.waiting = wait(dir, choice.waits.as_ref())?;
    }
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

/// Keeps what is not put to use: tomorrow's strikes judge it, for it learnt from none of them.
fn wait(dir: &Path, waits: Option<&Contents>) -> Result<Option<String>, Error> {
    let waiting = Store::open(&dir.join(WAITING));
    let version = waits.map(|contents| waiting.publish(contents));
    version.transpose().map_err(store_error)
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
    // Where the strikes that showed the change were taken away, for a clock was set, those that came after them are since.
    if let (Some(change), Some(first)) = (&mut night.change, new.first())
        && results
            .strikes
            .iter()
            .all(|strike| strike.t_start < change.since)
    {
        change.since = first.t_start;
    }
    let since = night.since();
    let read = new.len();
    new.retain(|strike| strike.t_start >= since);
    night.new_strikes = new.len();
    night.behind = read - new.len();
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

/// Whether the new strikes scatter more than the older ones beside what learnt from both, beyond chance: then those logs are set aside that do.
fn scatters(
    run: &Run,
    parts: [&[Strike]; 2],
    results: &Results,
    night: &mut Night,
) -> Result<bool, Error> {
    let new = parts.concat();
    let tonight: BTreeSet<&str> = new.iter().map(|strike| strike.id.as_str()).collect();
    let is_older = |strike: &&Strike| !tonight.contains(strike.id.as_str());
    let older: Vec<Strike> = results.strikes.iter().filter(is_older).cloned().collect();
    if older.len() < MATURE {
        return Ok(false);
    }
    let candidate = loaded(contents(results)?)?;
    let varies = score::varies(&candidate);
    // About where each part has the table.
    let scatter = |parts: &[Vec<Strike>]| -> Result<_, Error> {
        let (mut squares, mut freedom) = (0.0, 0.0);
        for part in parts {
            let fitted = score::fitted(run, &candidate, part)?;
            if let Some(scatter) = fitted.and_then(|fitted| varies.scatter_of(&fitted.seen)) {
                squares += scatter.mean_square * scatter.freedom;
                freedom += scatter.freedom;
            }
        }
        Ok((squares / freedom, freedom))
    };
    let latest = older[older.len().saturating_sub(MOST_OLDER)..].to_vec();
    let (before, freedom_before) = scatter(&[latest])?;
    // How many times as much as those before the new strikes scatter, or those of one log; none where that may be chance.
    let beyond_chance = |log: Option<&str>| -> Result<Option<f64>, Error> {
        let of_log = |strike: &&Strike| log.is_none_or(|log| strike.log == log);
        let of_parts = parts.map(|part| part.iter().filter(of_log).cloned().collect());
        let (here, freedom) = scatter(&of_parts)?;
        let ratio = here / before;
        // Of too few there is no such number.
        let chance = FisherSnedecor::new(freedom, freedom_before).map_or(1.0, |f| f.sf(ratio));
        Ok((chance < QUARANTINE).then_some(ratio))
    };
    let Some(ratio) = beyond_chance(None)? else {
        return Ok(false);
    };
    let all: BTreeSet<&str> = new.iter().map(|strike| strike.log.as_str()).collect();
    let mut logs = Vec::new();
    for log in &all {
        if beyond_chance(Some(log))?.is_some() {
            logs.push(*log);
        }
    }
    // Where none does by itself, all of them do together.
    if logs.is_empty() {
        logs.extend(&all);
    }
    night.status = Status::Refused;
    night.quarantined = true;
    night.set_aside.extend(logs.into_iter().map(String::from));
    night.because(format!(
        "the new strikes scatter {:.1} times as much as those before: they are not learnt from",
        ratio.sqrt()
    ));
    Ok(true)
}

/// What might be put to use tonight.
struct Candidate {
    /// What it learnt from, in words.
    name: String,
    contents: Contents,
    /// Beside the version in use, on strikes that neither learnt from.
    gate: HeldOutGate,
    executor: ExecutorGate,
    /// Whether it has the table where tonight's strikes show it, if they show a change.
    follows: bool,
    /// Whether it is the version from before the last change: the change found tonight takes that back.
    takes_back: bool,
}

impl Candidate {
    fn passed(&self) -> bool {
        self.gate.passed && self.executor.passed && self.follows
    }
}

/// What was decided: what is put to use, if anything, and what waits for strikes that it did not learn from.
#[derive(Default)]
struct Choice {
    chosen: Option<Contents>,
    waits: Option<Contents>,
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
) -> Result<Choice, Error> {
    // A version of a few strikes does not know the table well enough to say that it changed.
    let is_mature = score::varies(before).strikes >= MATURE;
    let is_changed = is_mature && night.drift.as_ref().is_some_and(Drift::is_beyond_chance);
    let last_change = night.change.clone().filter(|_| is_changed);
    let known = before.manifest.provenance.strikes;
    // When it changed cannot be told by a clock that was set.
    let is_back = |first: &Strike| known.is_some_and(|known| first.t_start <= known.last);
    if let (true, Some(first)) = (is_changed, new.first()) {
        if is_back(first) {
            night.because(format!(
                "the new strikes show a change and are stamped before the last that {} learnt from: if a clock was set, set it right and take their logs away",
                before.version
            ));
        } else {
            night.change = Some(Change {
                version: before.version.clone(),
                since: first.t_start,
                what: night
                    .drift
                    .as_ref()
                    .map_or_else(String::new, Drift::sentence),
            });
        }
    }
    let since = night.since();
    let is_since = |strike: &&Strike| strike.t_start >= since;
    let strikes: Vec<Strike> = results.strikes.iter().filter(is_since).cloned().collect();
    let follows = |artifact: &Artifact| -> Result<bool, Error> {
        let drift = match is_changed {
            true => score::drift(run, artifact, new)?,
            false => None,
        };
        Ok(!drift.is_some_and(|drift| drift.is_beyond_chance()))
    };
    let all = contents(results)?;
    let mut waits = all.clone();
    let judged = |name: &str, contents: &Contents| -> Result<Option<Candidate>, Error> {
        let artifact = loaded(contents)?;
        if before.manifest == artifact.manifest {
            return Ok(None);
        }
        let judges = unseen(&results.strikes, since, [before, &artifact]);
        Ok(Some(Candidate {
            name: name.into(),
            contents: contents.clone(),
            gate: compare_held_out(run, before, &artifact, &judges)?,
            executor: plan_paths(&artifact, &strikes),
            follows: follows(&artifact)?,
            takes_back: false,
        }))
    };
    // What is put to use tonight knows all that was read tonight, whatever it learnt from.
    let (strikes_read, logs_read) = (
        publishing::logged(&results.strikes),
        publishing::input_files(&results.read.logs)?,
    );
    let as_of_tonight = |mut contents: Contents| {
        contents.provenance.strikes = Some(strikes_read);
        contents.provenance.inputs.clone_from(&logs_read);
        contents
    };
    let mut candidates: Vec<Candidate> = judged("all nights", all)?.into_iter().collect();
    // What came out last night and waits: it learnt from none of tonight's strikes, so all of them judge. One that is gone is no candidate.
    let waiting = night.waiting.as_deref();
    let waiting =
        waiting.and_then(|name| Store::open(&run.dir().join(WAITING)).load(Some(name)).ok());
    if let Some(waiting) = waiting {
        candidates.extend(judged(
            "the nights before tonight",
            &Contents::from(waiting),
        )?);
    }
    // A change may take back the one before: a shift of a day. What was known before both is right again.
    if let Some(change) = &last_change
        && let Ok(earlier) = store.load(Some(&change.version))
    {
        let name = format!("{} from before the last change", change.version);
        let earlier = judged(&name, &Contents::from(earlier))?;
        candidates.extend(earlier.map(|one| Candidate {
            contents: as_of_tonight(one.contents),
            takes_back: true,
            ..one
        }));
    }
    let base = night.change.as_ref().map(|change| &change.version);
    if let Some(base) = base.and_then(|version| store.load(Some(version)).ok()) {
        let latest = &strikes[strikes.len().saturating_sub(MOST_SINCE)..];
        let logs: BTreeSet<&str> = strikes.iter().map(|strike| strike.log.as_str()).collect();
        if strikes.len() >= ALONE {
            let older = results.read.logs.iter();
            let older = older.filter(|log| !logs.contains(log.name.as_str()));
            let older: Vec<String> = older.map(|log| log.name.clone()).collect();
            let alone = pipeline(run, &inputs.without(&older), Step::Publish)?;
            waits = as_of_tonight(contents(&alone)?.clone());
            candidates.extend(judged("the strikes since the change alone", &waits)?);
        }
        let since = Since {
            base: &base,
            strikes: latest,
        };
        if let Some(moved) = since.moved(run)? {
            let artifact = loaded(&moved.contents)?;
            candidates.push(Candidate {
                name: format!(
                    "{} moved by {} (each strike by what the others show)",
                    base.version, moved.shift
                ),
                gate: since.compare_cross_fitted(run, before)?,
                executor: plan_paths(&artifact, &strikes),
                follows: follows(&artifact)?,
                contents: as_of_tonight(moved.contents),
                takes_back: false,
            });
        }
    }
    // The one that knows most, unless a later one is better by more than the margin.
    let passed = candidates.iter().filter(|one| one.passed());
    let best = passed.reduce(|best, one| match one.gate.is_better_than(&best.gate) {
        true => one,
        false => best,
    });
    // What is put to use is told, or else every candidate.
    let told: Vec<&Candidate> = best.map_or_else(|| candidates.iter().collect(), |best| vec![best]);
    for one in &told {
        let name = &one.name;
        night.because(format!("from {name}: {}", one.gate.sentence()));
        if !one.executor.passed {
            night.because(format!("{name}: {}", one.executor.sentence()));
        }
        if !one.follows {
            night.because(format!("{name}: it does not follow the change"));
        }
        night.beats = Some(one.gate.clone());
        night.executor = Some(one.executor.clone());
    }
    if let (Some(change), Some(last)) = (night.change.as_mut(), last_change)
        && best.is_some_and(|best| best.takes_back)
    {
        // What is learnt since stands on what is right again.
        change.version = last.version;
    }
    // A table that changed and is not followed is somebody's business, and so is what the executor cannot use.
    let is_unusable = candidates.first().is_some_and(|one| !one.executor.passed);
    let is_behind = new.is_empty() && night.behind > 0;
    if is_behind {
        let later = strikes.iter().map(|strike| strike.log.as_str());
        let later: BTreeSet<&str> = later.collect();
        night.because(format!(
            "all {} new strikes are stamped before the last change (stamp {since:.0} s): if a clock was set, take away what it stamped later: {}",
            night.behind,
            Vec::from_iter(later).join(", ")
        ));
    }
    night.status = if best.is_some() {
        Status::Promoted
    } else if is_changed || is_unusable || is_behind {
        Status::Refused
    } else if candidates.is_empty() {
        night.because("what came out is the version in use".into());
        Status::NothingNew
    } else {
        Status::Kept
    };
    let chosen = best.map(|best| best.contents.clone());
    Ok(Choice {
        waits: Some(waits).filter(|waits| chosen.as_ref() != Some(waits)),
        chosen,
    })
}

/// The first version: the executor's gate, and that of first versions.
fn first(results: &Results, contents: &Contents, night: &mut Night) -> Result<bool, Error> {
    let executor = plan_paths(&loaded(contents)?, &results.strikes);
    night.because(executor.sentence());
    let mut passed = executor.passed;
    let gate = results.version().map(|version| &version.gate);
    if let Some(gate) = gate {
        night.why.extend(gate.sentences());
        passed &= gate.passed;
    }
    let is_gathering = executor.passed && gate.is_some_and(FirstVersion::is_gathering);
    night.status = if passed {
        Status::Promoted
    } else if is_gathering {
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
            night.because(format!("failed to {error}"));
            return Ok(None);
        }
        Err(error) => return Err(store_error(error)),
    };
    if store.latest().is_ok_and(|latest| latest == version) {
        return Ok(Some(version));
    }
    night.status = Status::Refused;
    night.because(format!(
        "it is {version}, which was rolled back: `carom artifacts rollback {version}` takes it again"
    ));
    Ok(None)
}
