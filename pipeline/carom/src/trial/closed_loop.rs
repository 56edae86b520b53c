//! The closed loop: each model plans, the robot strikes, and the distance from target to stop is measured.

use std::collections::BTreeMap;
use std::path::Path;

use indicatif::ProgressBar;
use rayon::prelude::*;
use rig::{Sim, SimChoice};
use store::{Artifact, Model, Store};
use strike::Planner;
use values::{Command, Point, StopErrors};

use super::outcome::{FILE, Outcome, Refused, Struck, Trial};
use super::targets::{Pair, Region};
use crate::Error;
use crate::outputs::write_json;
use crate::publishing::store_error;
use crate::robot::Embedded;

/// Repeats of one command that tell the rig's scatter.
const FLOOR_REPEATS: usize = 25;

/// What a trial is to strike.
pub struct Wanted<'a> {
    /// What strikes.
    pub robot: &'a SimChoice,
    /// Version to strike with; the latest where none is named.
    pub version: Option<&'a str>,
    /// Random targets, each struck once with each model.
    pub targets: usize,
    /// Strikes at each target of the paper's Figure 8, with each model.
    pub repeats: usize,
    /// Where targets and launch scatter come from.
    pub seed: u64,
}

/// Runs the trial with the version in a run's folder and keeps it there.
pub fn run(dir: &Path, wanted: &Wanted<'_>, is_quiet: bool) -> Result<Trial, Error> {
    let artifact = Store::open(dir).load(wanted.version).map_err(store_error)?;
    let strikes = tables::read_strikes(dir).map_err(Error::input)?;
    let region = Region::of(&strikes)
        .ok_or_else(|| Error::input("choose targets: the run's strikes.parquet is empty"))?;
    let robot = Embedded::open(wanted.robot, dir, &artifact.rig, wanted.seed)?;
    if robot.truth.is_none() && !is_quiet {
        eprintln!(
            "carom: there is no truth.json in {0} or {0}/rig: the demo's default rig is struck, with hidden effects of its own; \
             name another with --robot sim:FOLDER",
            dir.display()
        );
    }

    let planners = planners(&artifact)?;
    let (_, reference) = planners
        .iter()
        .find(|(model, _)| *model == artifact.manifest.provenance.default_model)
        .ok_or_else(|| Error::input("find the artifact's default model"))?;
    let figure_8 = region.figure_8(reference);
    let repeated: Vec<Pair> = figure_8
        .iter()
        .flat_map(|pair| std::iter::repeat_n(*pair, wanted.repeats))
        .collect();
    let (random, drawn) = region.random(reference, wanted.targets, wanted.seed);

    let bar = if is_quiet {
        ProgressBar::hidden()
    } else {
        ProgressBar::new((planners.len() * (repeated.len() + random.len())) as u64)
    };
    // Every model meets the same launches, and Figure 8's follow those of the random targets.
    let later = robot
        .sim
        .clone()
        .after(robot.sim.index().order + random.len());
    let mut trial = Trial {
        artifact: artifact.version.clone(),
        robot: robot.origin(),
        drawn,
        figure_8: BTreeMap::new(),
        noise_floor: noise_floor(reference, &later, &figure_8),
        models: BTreeMap::new(),
    };
    for (model, planner) in &planners {
        let name = model.name().to_string();
        let outcome = strike_all(planner, robot.sim.clone(), &random, &bar);
        trial.models.insert(name.clone(), outcome);
        let outcome = strike_all(planner, later.clone(), &repeated, &bar);
        trial.figure_8.insert(name, outcome);
    }
    bar.finish_and_clear();
    write_json(&dir.join(FILE), &trial)?;
    Ok(trial)
}

fn planners(artifact: &Artifact) -> Result<Vec<(Model, Planner)>, Error> {
    artifact
        .models()
        .into_iter()
        .map(|model| Ok((model, Planner::new(artifact, model).map_err(Error::input)?)))
        .collect()
}

/// Plans in parallel, for plans do not depend on each other; strikes in order, for the rig does.
fn strike_all(planner: &Planner, mut sim: Sim, pairs: &[Pair], bar: &ProgressBar) -> Outcome {
    let plans: Vec<_> = pairs
        .par_iter()
        .map(|(from, to)| planner.plan(*from, *to))
        .collect();
    let mut outcome = Outcome::default();
    for ((from, to), plan) in pairs.iter().zip(plans) {
        let start = sim.index().order;
        match plan {
            Ok(plan) => {
                let command = plan.command();
                let stop = sim.strike(*from, command).stop;
                outcome.strikes.push(struck(*from, *to, command, stop));
            }
            Err(refusal) => {
                // The launches of the targets that follow stay those that other models meet.
                sim = sim.after(start + 1);
                outcome.refusals.push(Refused {
                    from: *from,
                    to: *to,
                    refused: refusal.to_string(),
                });
            }
        }
        bar.inc(1);
    }
    outcome.errors = StopErrors::of(outcome.strikes.iter().map(|strike| strike.error));
    outcome
}

fn struck(from: Point, to: Point, command: Command, stop: Point) -> Struck {
    Struck {
        from,
        to,
        speed: command.speed,
        angle: command.angle,
        stop,
        error: stop.distance(to),
    }
}

/// Distances of repeats from their mean, widened for the mean's own error.
fn noise_floor(planner: &Planner, sim: &Sim, pairs: &[Pair]) -> Option<StopErrors> {
    let mut sim = sim.clone();
    let widening = (FLOOR_REPEATS as f64 / (FLOOR_REPEATS as f64 - 1.0)).sqrt();
    let mut errors = Vec::new();
    for (from, to) in pairs {
        let Ok(plan) = planner.plan(*from, *to) else {
            continue;
        };
        let stops: Vec<Point> = (0..FLOOR_REPEATS)
            .map(|_| sim.strike(*from, plan.command()).stop)
            .collect();
        let sum = stops.iter().fold(Point::default(), |sum, stop| sum + *stop);
        let mean = sum * (1.0 / FLOOR_REPEATS as f64);
        errors.extend(stops.iter().map(|stop| widening * stop.distance(mean)));
    }
    StopErrors::of(errors.into_iter())
}
