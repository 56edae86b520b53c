//! `carom dataset`: logs pinned by hash, tables built from them, and the proof that they are the same bytes elsewhere.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use durable::sha256;
use ingest::LogFile;
use rayon::prelude::*;
use serde_json::json;
use values::Rig;

use crate::Error;
use crate::args::examples;
use crate::dataset::{
    FILES, Lock, MOST_FPS, PinnedLog, Recipe, Rows, all_turn, episode, hashes, pin, usual_fps,
};
use crate::error::{Outcome, Output};
use crate::naming::name_logs;

/// `carom dataset`.
#[derive(Debug, Subcommand)]
pub enum DatasetCommand {
    /// Pin every log of a recipe by SHA-256 and record the hashes of the tables, in RECIPE's `.lock`.
    #[command(after_help = examples(&[
        "carom dataset lock datasets/recipes/demo.toml",
        "carom dataset lock datasets/recipes/demo.toml --again",
    ]))]
    Lock {
        /// What and where.
        #[command(flatten)]
        dataset: DatasetArgs,
        /// Pin again, even where pinned logs have changed or are gone.
        #[arg(long)]
        again: bool,
    },
    /// Write the tables from the pinned logs.
    #[command(after_help = examples(&["carom dataset build datasets/recipes/demo.toml --out datasets/demo"]))]
    Build {
        /// What and where.
        #[command(flatten)]
        dataset: DatasetArgs,
        /// Folder of the tables [default: RECIPE without its `.toml`].
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
    /// Build again in a temporary folder, and compare with the lock and with existing tables, byte by byte.
    #[command(after_help = examples(&["carom dataset verify datasets/recipes/demo.toml --logs /mnt/copy"]))]
    Verify {
        /// What and where.
        #[command(flatten)]
        dataset: DatasetArgs,
        /// Folder of the tables [default: RECIPE without its `.toml`].
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
    /// Write the strikes of a run, or of a dataset, as policies read them: a LeRobotDataset, an episode a strike.
    #[command(after_help = examples(&["carom dataset export artifacts/demo --lerobot demo_lerobot --fps 50"]))]
    Export(ExportArgs),
}

/// `carom dataset export`.
#[derive(Args, Debug)]
pub struct ExportArgs {
    /// Folder of a run, or of a dataset's tables.
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Folder to write as a LeRobotDataset of version 3; it must not hold anything yet.
    #[arg(long, value_name = "OUT")]
    pub lerobot: PathBuf,
    /// Frames a second, at which tracks are interpolated [default: the camera's].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_FPS)))]
    pub fps: Option<u32>,
}

/// A recipe and its logs.
#[derive(Args, Debug)]
pub struct DatasetArgs {
    /// The recipe, a TOML file that names logs, rig, filters and seed.
    pub recipe: PathBuf,
    /// Further files or folders to search for the logs, under any name; repeat it for several.
    #[arg(long, value_name = "PATH")]
    pub logs: Vec<PathBuf>,
}

/// Does what was asked.
pub fn run(command: &DatasetCommand) -> Result<Output, Error> {
    match command {
        DatasetCommand::Lock { dataset, again } => make_lock(dataset, *again),
        DatasetCommand::Build { dataset, out } => build(dataset, &folder(dataset, out.as_deref())),
        DatasetCommand::Verify { dataset, out } => {
            verify(dataset, &folder(dataset, out.as_deref()))
        }
        DatasetCommand::Export(args) => export(args),
    }
}

fn export(args: &ExportArgs) -> Result<Output, Error> {
    let (dir, out) = (args.dir.display(), &args.lerobot);
    let strikes = tables::read_strikes(&args.dir).map_err(Error::input)?;
    // Where no track has two frames there is nothing to resample.
    let fps = usual_fps(&strikes).map(|usual| args.fps.unwrap_or(usual));
    let Some(fps) = fps else {
        return Err(Error::input(format!(
            "export {dir}: it holds no strike with a track; rejects.parquet says why strikes were not kept, slides.parquet has slides that none began"
        )));
    };
    if std::fs::read_dir(out).is_ok_and(|mut entries| entries.next().is_some()) {
        return Err(Error::input(format!(
            "write {}: there is something in it already; name another folder with --lerobot",
            out.display()
        )));
    }
    let with_yaw = all_turn(&strikes);
    let episodes: Vec<_> = strikes.iter().map(|strike| episode(strike, fps)).collect();
    let frames: usize = episodes.iter().map(|episode| episode.states.len()).sum();
    tables::write_lerobot(out, fps, with_yaw, episodes)?;
    let text = format!(
        "dataset    {}: {} episodes, {frames} frames at {fps} a second\n",
        out.display(),
        strikes.len()
    );
    let json = json!({ "out": out, "episodes": strikes.len(), "frames": frames, "fps": fps });
    Ok(Output::done(json, text))
}

/// Where a dataset's tables lie: in a folder named as its recipe, unless another is given.
fn folder(args: &DatasetArgs, out: Option<&Path>) -> PathBuf {
    out.map_or_else(|| args.recipe.with_extension(""), Path::to_path_buf)
}

fn make_lock(args: &DatasetArgs, again: bool) -> Result<Output, Error> {
    let recipe = Recipe::load(&args.recipe)?;
    let (rig, found) = (recipe.rig()?, open_logs(&recipe, args)?);
    let before = if again {
        None
    } else {
        Lock::load(&args.recipe)?
    };
    let known = match &before {
        Some(before) => {
            before.locate(&found)?;
            before.log.clone()
        }
        None => Vec::new(),
    };
    // What was pinned keeps its name.
    let is_new = |log: &PinnedLog| known.iter().all(|known| known.sha256 != log.sha256);
    let mut logs = pin(&found, &recipe.filters);
    logs.retain(is_new);
    let new = logs.len();
    logs.extend(
        known
            .iter()
            .filter(|log| !recipe.filters.leave_out(Path::new(&log.name)))
            .cloned(),
    );
    logs.sort();

    let lock = Lock::new(
        sha256(rig.to_toml().as_bytes()),
        recipe.seed,
        recipe.filters,
        logs,
    );
    let rows = Rows::read(&rig, &lock, &found)?;
    let scratch = tempfile::tempdir().map_err(Error::failed)?;
    let lock = Lock {
        files: rows.write(&rig, scratch.path())?,
        strikes: rows.strikes.len(),
        rejected: rows.rejects.len(),
        filtered: rows.filtered,
        ..lock
    };
    lock.save(&args.recipe)?;
    let path = Lock::path(&args.recipe);
    let text = format!(
        "{} logs pinned in {}, {new} of them new\n{}",
        lock.log.len(),
        path.display(),
        counts(&lock)
    );
    Ok(output(
        &lock,
        rows.is_clean,
        json!({ "lock": path, "new": new }),
        text,
    ))
}

fn build(args: &DatasetArgs, out: &Path) -> Result<Output, Error> {
    let (lock, rig, rows) = rebuild(args)?;
    let scratch = tempfile::tempdir().map_err(Error::failed)?;
    let differing = differing(&lock, &rows.write(&rig, scratch.path())?);
    if !differing.is_empty() {
        return Err(Error::failed(rebuilt_otherwise(&differing)));
    }
    rows.write(&rig, out)?;
    let text = format!("{} in {}\n", counts(&lock).trim_end(), out.display());
    Ok(output(&lock, rows.is_clean, json!({ "out": out }), text))
}

fn verify(args: &DatasetArgs, out: &Path) -> Result<Output, Error> {
    let (lock, rig, rows) = rebuild(args)?;
    let scratch = tempfile::tempdir().map_err(Error::failed)?;
    let rebuilt = differing(&lock, &rows.write(&rig, scratch.path())?);
    let mut built = Vec::new();
    if out.is_dir() {
        let names = differing(&lock, &hashes(out)?).into_iter();
        built.extend(names.map(|name| out.join(name).display().to_string()));
    }
    if !(rebuilt.is_empty() && built.is_empty()) {
        let why = if rebuilt.is_empty() {
            format!(
                "find the locked bytes in {}: the logs still give them, `carom dataset build {}` writes them again",
                built.join(", "),
                args.recipe.display()
            )
        } else {
            rebuilt_otherwise(&rebuilt)
        };
        let differing = [rebuilt, built].concat();
        let json = json!({ "same": false, "differing": differing });
        let text = format!("failed to {why}\n");
        return Ok(Output::ended(Outcome::Failed, json, text));
    }
    let text = format!("every byte is the same: {}", counts(&lock));
    Ok(output(
        &lock,
        true,
        json!({ "same": true, "differing": [] }),
        text,
    ))
}

/// The rows again, from the logs that are pinned.
fn rebuild(args: &DatasetArgs) -> Result<(Lock, Rig, Rows), Error> {
    let recipe = Recipe::load(&args.recipe)?;
    let rig = recipe.rig()?;
    let lock = Lock::load(&args.recipe)?.ok_or_else(|| {
        Error::input(format!(
            "find {}: the dataset was never locked; `carom dataset lock {}` pins its logs",
            Lock::path(&args.recipe).display(),
            args.recipe.display()
        ))
    })?;
    let is_same = lock.rig == sha256(rig.to_toml().as_bytes())
        && lock.seed == recipe.seed
        && lock.filters == recipe.filters;
    if !is_same {
        return Err(Error::input(format!(
            "build {}: its rig, seed or filters are not those that were locked; `carom dataset lock` takes the new ones",
            args.recipe.display()
        )));
    }
    let rows = Rows::read(&rig, &lock, &open_logs(&recipe, args)?)?;
    Ok((lock, rig, rows))
}

fn open_logs(recipe: &Recipe, args: &DatasetArgs) -> Result<Vec<LogFile>, Error> {
    let paths = recipe.find_logs(&args.logs)?;
    let open = |path: &PathBuf| LogFile::open(path).map_err(Error::input);
    let mut logs: Vec<LogFile> = paths.par_iter().map(open).collect::<Result<_, _>>()?;
    name_logs(&mut logs);
    Ok(logs)
}

/// Files whose bytes are not those that the lock records.
fn differing(lock: &Lock, files: &BTreeMap<String, String>) -> Vec<String> {
    let differs = |name: &&str| files.get(*name) != lock.files.get(*name);
    let names = FILES.into_iter().filter(differs);
    names.map(String::from).collect()
}

fn rebuilt_otherwise(differing: &[String]) -> String {
    format!(
        "rebuild the dataset: other bytes in {}; use the carom that locked it, or lock it again",
        differing.join(", ")
    )
}

fn counts(lock: &Lock) -> String {
    format!(
        "{} strikes, {} rejected, {} left out by filters\n",
        lock.strikes, lock.rejected, lock.filtered
    )
}

fn output(lock: &Lock, is_clean: bool, more: serde_json::Value, text: String) -> Output {
    let mut json = json!({
        "logs": lock.log, "strikes": lock.strikes, "rejected": lock.rejected, "filtered": lock.filtered, "files": lock.files,
    });
    if let (Some(json), serde_json::Value::Object(more)) = (json.as_object_mut(), more) {
        json.extend(more);
    }
    Output::ended(Outcome::of(is_clean), json, text)
}
