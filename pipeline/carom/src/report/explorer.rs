//! Strike by strike: the list, and what a click opens. `page.js` shows what is gathered here.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use maud::{Markup, html};
use rayon::prelude::*;
use serde::Serialize;
use values::Strike;
use world::{Simulator, World, WorldError};

use super::input::ReportInput;
use super::markup::{PageError, model_names, section, title};
use super::plot::{Short, data};
use crate::beside::simulate;
use crate::publishing::best_model;
use crate::results::{Results, Worlds};

/// Strikes in the page, at the most.
const MOST: usize = 1000;
/// Rejected strikes in the list, at the most.
const MOST_REJECTED: usize = 500;
/// Frames of a track in the page, at the most.
const FRAMES: usize = 40;
/// A unit of coordinates in the page, in m, and of times, in s: a tenth of a millimetre, a millisecond.
const UNITS: (f64, f64) = (1e-4, 1e-3);

/// All that the page knows of strikes.
#[derive(Serialize)]
struct Strikes<'a> {
    /// Models, in the order of tables, with their titles.
    models: Vec<(&'static str, String)>,
    logs: Vec<&'a str>,
    sessions: Vec<&'a str>,
    /// By the strike's place in the run: plots name strikes by it.
    strikes: BTreeMap<usize, Row<'a>>,
    rejects: Vec<Rejected<'a>>,
}

/// A strike.
#[derive(Serialize)]
struct Row<'a> {
    id: &'a str,
    log: usize,
    index: u32,
    /// Stamp in s.
    time: f64,
    session: usize,
    split: &'static str,
    /// Start and stop in m; no stop where it did not come to rest.
    from: [Short; 2],
    stop: Option<[Short; 2]>,
    speed: Short,
    angle: Short,
    /// Stop errors in m, by model, of one that is held out.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    errors: BTreeMap<&'a str, Short>,
    #[serde(skip_serializing_if = "Option::is_none")]
    track: Option<Tracks>,
}

/// A measured track beside simulated ones, each number less the one before, in [`UNITS`].
#[derive(Serialize)]
struct Tracks {
    t: Vec<i64>,
    x: Vec<i64>,
    y: Vec<i64>,
    /// At the same times, by model.
    worlds: BTreeMap<&'static str, [Vec<i64>; 2]>,
}

/// A strike that was not kept.
#[derive(Serialize)]
struct Rejected<'a> {
    log: &'a str,
    index: u32,
    time: f64,
    reason: &'static str,
    detail: &'a str,
}

pub fn explorer_section(
    shown: &ReportInput<'_>,
    listed: &BTreeSet<usize>,
) -> Result<Markup, PageError> {
    let strikes = gathered(shown, listed)?;
    let all = shown.results.strikes.len();
    Ok(section(
        "Strike by strike",
        html! {
            (data(&strikes, Some("strikes")))
            noscript { p { "The list and the plots need JavaScript; it is within this page, and fetches nothing." } }
            form.filters aria-label="Which strikes" {
                label { "session " select name="session" {
                    option value="" { "all" }
                    @for (place, session) in strikes.sessions.iter().enumerate() { option value=(place) { (session) } }
                } }
                label { "strikes " select name="split" {
                    option value="" { "all kept" }
                    option value="test" { "held out" }
                    option value="train" { "learnt from" }
                    option value="rejected" { "rejected" }
                } }
                label { "speed from " input name="low" type="number" step="0.05" min="0"; }
                label { "to " input name="high" type="number" step="0.05" min="0"; " m/s" }
                label { "errors of " select name="model" {
                    @for (model, title) in &strikes.models { option value=(model) { (title) } }
                } }
                output name="count" aria-live="polite" {}
            }
            div.list {}
            p.note {
                "The filters hold for every plot of strikes on this page. Point at a dot to see which strike it is; click it, or choose a \
                 row, to open it. With the keyboard: arrows go from dot to dot, Enter opens."
                @if all > listed.len() { " Of " (all) " strikes " (listed.len()) " are in this page, those that models were judged by first; strikes.parquet has all." }
            }
            dialog.strike aria-label="A strike" {}
        },
    ))
}

/// Places of the strikes that the page lists, draws and opens: those that models were judged by and that the diagnosis learnt from come first.
pub fn listed(results: &Results) -> BTreeSet<usize> {
    let judged = results.evaluation().into_iter();
    let judged = judged.flat_map(|evaluation| &evaluation.predictions);
    let learnt = results.found().into_iter();
    let learnt = learnt.flat_map(|found| found.residuals.iter().filter(|look| !look.is_heldout));
    let first: HashSet<&str> = judged
        .map(|row| row.strike_id.as_str())
        .chain(learnt.map(|look| look.strike_id.as_str()))
        .collect();
    let is_first = |place: &usize| first.contains(results.strikes[*place].id.as_str());
    let (first, others) = (0..results.strikes.len()).partition(is_first);
    chosen([first, others], MOST)
}

/// At most `most` of these places: those of the first group before those of the second, each evenly.
fn chosen(groups: [Vec<usize>; 2], most: usize) -> BTreeSet<usize> {
    let mut chosen = BTreeSet::new();
    for places in groups {
        let room = most - chosen.len();
        if room > 0 {
            let every = places.len().div_ceil(room).max(1);
            chosen.extend(places.into_iter().step_by(every));
        }
    }
    chosen
}

fn gathered<'a>(
    shown: &'a ReportInput<'_>,
    listed: &BTreeSet<usize>,
) -> Result<Strikes<'a>, PageError> {
    let results = shown.results;
    let all = &results.strikes;
    let mut errors: HashMap<&str, BTreeMap<&str, Short>> = HashMap::new();
    let evaluation = results.evaluation().into_iter();
    for row in evaluation.flat_map(|evaluation| &evaluation.predictions) {
        if let Some(error) = row.error {
            let of_strike = errors.entry(row.strike_id.as_str()).or_default();
            of_strike.insert(&row.model, Short(error));
        }
    }
    let names = |name: fn(&Strike) -> &str| -> Vec<&'a str> {
        let names: BTreeSet<&str> = listed.iter().map(|at| name(&all[*at])).collect();
        names.into_iter().collect()
    };
    let (logs, sessions) = (
        names(|strike| &strike.log),
        names(|strike| &strike.conditions.session),
    );
    let place = |names: &[&str], name: &str| names.binary_search(&name).unwrap_or(0);
    let tracks = tracks(shown, listed)?;
    let strikes = listed
        .iter()
        .zip(tracks)
        .map(|(at, track)| {
            let strike = &all[*at];
            let short = |point: values::Point| [Short(point.x), Short(point.y)];
            let row = Row {
                id: &strike.id,
                log: place(&logs, &strike.log),
                index: strike.index,
                time: strike.t_start,
                session: place(&sessions, &strike.conditions.session),
                split: strike.split.name(),
                from: short(strike.initial),
                stop: strike.has_stop().then(|| short(strike.stop)),
                speed: Short(strike.command.speed),
                angle: Short(strike.command.angle),
                errors: errors.remove(strike.id.as_str()).unwrap_or_default(),
                track,
            };
            (*at, row)
        })
        .collect();
    let models = model_names().into_iter();
    let judged = |model: &&str| {
        let evaluation = results.evaluation();
        evaluation.is_some_and(|evaluation| evaluation.models.contains_key(*model))
    };
    // The model in use first: its errors are listed unless another is chosen.
    let mut models: Vec<_> = models
        .filter(judged)
        .map(|model| (model, title(model)))
        .collect();
    let used = results
        .worlds
        .as_ref()
        .map(|worlds| best_model(worlds).name());
    models.sort_by_key(|(model, _)| Some(*model) != used);
    Ok(Strikes {
        models,
        logs,
        sessions,
        strikes,
        rejects: results
            .read
            .rejects
            .iter()
            .take(MOST_REJECTED)
            .map(|reject| Rejected {
                log: &reject.log,
                index: reject.index,
                time: reject.t_start,
                reason: reject.reason.name(),
                detail: &reject.detail,
            })
            .collect(),
    })
}

/// For each listed strike its track beside those of the worlds.
fn tracks(
    shown: &ReportInput<'_>,
    listed: &BTreeSet<usize>,
) -> Result<Vec<Option<Tracks>>, WorldError> {
    let results = shown.results;
    let rig = &shown.inputs.rig;
    let nominal = World::nominal();
    let found = results.worlds.iter().flat_map(Worlds::each);
    let found = found.map(|(model, of_world)| (model.name(), &of_world.world));
    let simulators = std::iter::once(("nominal", &nominal))
        .chain(found)
        .map(|(model, world)| Ok((model, Simulator::new(rig, world)?)))
        .collect::<Result<Vec<_>, WorldError>>()?;
    let listed: Vec<&Strike> = listed.iter().map(|at| &results.strikes[*at]).collect();
    Ok(listed
        .par_iter()
        .map(|strike| (!strike.track.is_empty()).then(|| beside(strike, &simulators)))
        .collect())
}

fn beside(strike: &Strike, simulators: &[(&'static str, Simulator)]) -> Tracks {
    let track = &strike.track;
    let last = track.len() - 1;
    let every = track.len().div_ceil(FRAMES).max(1);
    let frames = (0..last).step_by(every).chain([last]);
    let frames: Vec<usize> = frames.collect();
    let of = |values: &[f64], unit: f64| steps(frames.iter().map(|frame| values[*frame]), unit);
    let simulated = simulators.iter().filter_map(|(model, simulator)| {
        let (simulated, before) = simulate(strike, simulator)?;
        let at = frames
            .iter()
            .map(|frame| simulated.at(track.t[*frame] + before));
        let (x, y): (Vec<f64>, Vec<f64>) = at.map(|point| (point.x, point.y)).unzip();
        let [x, y] = [x, y].map(|values| steps(values.into_iter(), UNITS.0));
        Some((*model, [x, y]))
    });
    Tracks {
        t: of(&track.t, UNITS.1),
        x: of(&track.x, UNITS.0),
        y: of(&track.y, UNITS.0),
        worlds: simulated.collect(),
    }
}

/// Values in units, each less the one before: short in the page, and no error adds up.
fn steps(values: impl Iterator<Item = f64>, unit: f64) -> Vec<i64> {
    let mut before = 0;
    values
        .map(|value| {
            let now = (value / unit).round() as i64;
            now - std::mem::replace(&mut before, now)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_strikes_so_many_are_listed_and_those_that_count_come_first() {
        let of = |count: usize, most| {
            let (first, others) = (0..count).partition(|place| place % 5 == 0);
            let chosen = chosen([first, others], most);
            (chosen.len(), chosen.iter().filter(|p| *p % 5 == 0).count())
        };
        assert_eq!(of(100, MOST), (100, 20));
        assert_eq!(of(100, 30), (30, 20));
        let (all, first) = of(50_000, MOST);
        assert!(all <= MOST && first > MOST * 9 / 10, "{all} {first}");
    }

    #[test]
    fn a_track_is_told_in_steps_that_add_up_to_it() {
        let values = [0.300_04, 0.312_3, 0.311_96];
        let steps = steps(values.into_iter(), UNITS.0);
        let mut sum = 0;
        for (step, value) in steps.into_iter().zip(values) {
            sum += step;
            assert!((sum as f64 * UNITS.0 - value).abs() <= 0.5 * UNITS.0);
        }
    }
}
