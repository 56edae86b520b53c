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
use crate::view::{images, show};

/// `carom view`.
#[derive(Args, Debug)]
pub struct ViewArgs {
    /// Folder of a run.
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Only this strike, by its id or by how that begins; repeat it for several [default: all that were kept].
    #[arg(long, value_name = "ID")]
    pub strike: Vec<String>,
    /// The file to write, MCAP.
    #[arg(short, long, value_name = "FILE")]
    pub out: PathBuf,
}

/// Writes what the run's cache holds; what is missing is computed.
pub fn run(args: &ViewArgs, global: Global) -> Result<Output, Error> {
    let path = &args.out;
    if path.extension().is_none_or(|extension| extension != "mcap") {
        let name = path.with_extension("mcap");
        return Err(Error::input(format!(
            "write {}: what viewers read is written as MCAP; name {}, of which `rerun mcap convert` makes an .rrd",
            path.display(),
            name.display()
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
    let shown = show(path, &results.read.rig, &worlds, &strikes, &images)?;
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
