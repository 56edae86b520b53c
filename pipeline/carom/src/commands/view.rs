//! `carom view`: a run for viewers.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;
use values::Strike;

use super::track::is_same;
use crate::Error;
use crate::args::Global;
use crate::error::{Outcome, Output};
use crate::inputs::Inputs;
use crate::pipeline::{Step, pipeline};
use crate::results::Results;
use crate::steps::open;
use crate::view::{Shown, images, show};

/// `carom view`.
#[derive(Args, Debug)]
pub struct ViewArgs {
    /// Folder of a run.
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Only this strike, by its id or by how that begins; repeat it for several [default: all that were kept].
    #[arg(long, value_name = "ID")]
    pub strike: Vec<String>,
    /// The file to write: .mcap, or .rrd, which Rerun's program `rerun` makes of it.
    #[arg(short, long, value_name = "FILE")]
    pub out: PathBuf,
}

/// Writes what the run's cache holds; what is missing is computed.
pub fn run(args: &ViewArgs, global: Global) -> Result<Output, Error> {
    let path = &args.out;
    let (mcap, rrd) = (path.with_extension("mcap"), path.with_extension("rrd"));
    let is_rrd = path.extension() == rrd.extension();
    if !is_rrd && path.extension() != mcap.extension() {
        return Err(Error::input(format!(
            "write {}: a view is an .mcap or an .rrd; name {}",
            path.display(),
            mcap.display()
        )));
    }
    let inputs = Inputs::kept(&args.dir)?;
    if inputs.logs.iter().any(|log| is_same(log, path)) {
        let why = "write the view over a log of the run; name another file with -o";
        return Err(Error::input(why));
    }
    let run = open(&args.dir, global)?;
    let results = match pipeline(&run, &inputs, Step::Diagnose) {
        // Strikes too few to diagnose are seen beside the identified world.
        Err(error) if error.outcome() == Outcome::BadInput => pipeline(&run, &inputs, Step::Sysid)?,
        found => found?,
    };
    let strikes = chosen(&results, &args.strike, &args.dir)?;
    let worlds: Vec<_> = results
        .worlds
        .iter()
        .flat_map(|worlds| worlds.each())
        .collect();
    let worlds: Vec<_> = worlds.iter().map(|(_, of_world)| &of_world.world).collect();
    let images = images(&results.read, &strikes)?;
    let show = |path: &Path| show(path, &results.read.rig, &worlds, &strikes, &images);
    let shown = match is_rrd {
        true => converted(path, show)?,
        false => show(path)?,
    };
    let mut text = format!(
        "view       {} of {} strikes, {:.0} s long",
        path.display(),
        shown.strikes,
        shown.duration
    );
    if shown.images > 0 {
        text += &format!(", with {} images", shown.images);
    }
    text += "\n";
    for note in &images.notes {
        text += &format!("           {note}\n");
    }
    if worlds.is_empty() {
        text += "           measured tracks alone: a model of these logs would be meaningless; `carom check` says what to mend\n";
    }
    Ok(Output::done(
        json!({ "view": path, "shown": shown, "notes": images.notes }),
        text,
    ))
}

/// Writes a view beside `path` and has Rerun make `path` of it: its own program knows what its viewer of that version reads.
fn converted(
    path: &Path,
    show: impl FnOnce(&Path) -> Result<Shown, Error>,
) -> Result<Shown, Error> {
    let doing = || format!("write {}", path.display());
    let folder = path.parent().filter(|folder| *folder != Path::new(""));
    let aside = tempfile::tempdir_in(folder.unwrap_or(Path::new(".")))
        .map_err(|error| Error::input(format!("{}: {error}", doing())))?;
    let (mcap, rrd) = (
        aside.path().join("view.mcap"),
        aside.path().join("view.rrd"),
    );
    let shown = show(&mcap)?;
    let mut convert = std::process::Command::new("rerun");
    let convert = convert.args(["mcap", "convert"]).arg(&mcap);
    let ran = convert.arg("-o").arg(&rrd).output();
    let ran = ran.map_err(|error| {
        let mcap = path.with_extension("mcap");
        Error::input(format!(
            "{}: start Rerun's program `rerun`, which makes it: {error}; `pip install rerun-sdk` brings it, or name {}, which Rerun opens, too",
            doing(),
            mcap.display()
        ))
    })?;
    if !ran.status.success() {
        let said = String::from_utf8_lossy(&ran.stderr);
        return Err(Error::failed(format!(
            "{}: `rerun mcap convert`: {}",
            doing(),
            said.trim()
        )));
    }
    durable::rename(&rrd, path)?;
    Ok(shown)
}

/// The strikes that were asked for, in the order in which they were made.
fn chosen<'a>(results: &'a Results, ids: &[String], dir: &Path) -> Result<Vec<&'a Strike>, Error> {
    let all = &results.strikes;
    if all.is_empty() {
        return Err(Error::input(format!(
            "show {}: no strike was kept; rejects.parquet there says why, slides.parquet has slides that none began",
            dir.display()
        )));
    }
    if ids.is_empty() {
        return Ok(all.iter().collect());
    }
    let mut places = Vec::new();
    for id in ids {
        let begins = |(_, strike): &(usize, &Strike)| strike.id.starts_with(&**id);
        let found: Vec<usize> = all
            .iter()
            .enumerate()
            .filter(begins)
            .map(|(at, _)| at)
            .collect();
        let &[place] = &found[..] else {
            let count = if found.is_empty() {
                "no strike"
            } else {
                "more than one"
            };
            let dir = dir.display();
            return Err(Error::input(format!(
                "find strike {id:?} in {dir}: {count} has an id that begins so; `carom query {dir} \"SELECT strike_id, session, speed \
                 FROM strikes\"` lists them"
            )));
        };
        places.push(place);
    }
    places.sort_unstable();
    places.dedup();
    Ok(places.into_iter().map(|place| &all[place]).collect())
}
