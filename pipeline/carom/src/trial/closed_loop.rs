//! The closed loop: each model plans, the robot strikes, and the distance from target to stop is measured.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use indicatif::ProgressBar;
use rayon::prelude::*;
use rig::{Recording, Sim, SimChoice};
use store::{Artifact, Model, Store};
use strike::{Plan, Planner};
use values::{Point, StopErrors};

use super::outcome::{FILE, NewSessions, Outcome, Refused, TargetStrike, Trial};
use super::targets::{Pair, Region};
use crate::Error;
use crate::outputs::write_json;
use crate::publishing::store_error;
use crate::robot::Embedded;

/// Repeats of one command from which the rig's scatter is estimated.
const FLOOR_REPEATS: usize = 25;

/// What a trial is to strike.
pub struct TrialSettings<'a> {
    /// What strikes.
    pub robot: &'a SimChoice,
    /// Version to strike with; the latest where none is named.
    pub version: Option<&'a str>,
    /// Random targets, each struck once with each model.
    pub targets: usize,
    /// Strikes at each target of the paper's Figure 8, with each model.
    pub repeats: usize,
    /// Sessions that the version has never seen, in which the random targets are struck as well.
    pub sessions: usize,
    /// Where targets and launch scatter come from.
    pub seed: u64,
}

/// Runs the trial with the version in a run's folder and keeps it there.
pub fn run(dir: &Path, wanted: &TrialSettings<'_>, is_quiet: bool) -> Result<Trial, Error> {
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

    let planners = planners(&artifact, robot.session.as_deref())?;
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
        let again = if wanted.sessions > 0 { random.len() } else { 0 };
        ProgressBar::new((planners.len() * (repeated.len() + random.len() + again)) as u64)
    };
    // Every model meets the same launches, and Figure 8's follow those of the random targets.
    let later = robot
        .sim
        .clone()
        .after(robot.sim.index().order + random.len());
    let first = robot.sim.index().session + usize::from(robot.session.is_some());
    let after = later.clone().after(later.index().order + repeated.len());
    let a_session = random.len().div_ceil(wanted.sessions.max(1)).max(1);
    let new: Vec<Course<'_>> = random
        .chunks(a_session)
        .enumerate()
        .map(|(session, pairs)| {
            let order = after.index().order + session * a_session;
            (
                after.clone().after(order).in_session(first + session),
                pairs,
            )
        })
        .collect();
    let mut trial = Trial {
        session: robot.session.clone(),
        new_sessions: None,
        artifact: artifact.version.clone(),
        robot: robot.origin(),
        drawn,
        figure_8: BTreeMap::new(),
        noise_floor: noise_floor(reference, &later, &figure_8),
        models: BTreeMap::new(),
    };
    for (model, planner) in &planners {
        let name = model.name().to_string();
        let outcome = strike_all(planner, vec![(robot.sim.clone(), &random)], &bar);
        trial.models.insert(name.clone(), outcome);
        let outcome = strike_all(planner, vec![(later.clone(), &repeated)], &bar);
        trial.figure_8.insert(name, outcome);
    }
    if wanted.sessions > 0 {
        let mut models = BTreeMap::new();
        for (model, planner) in self::planners(&artifact, None)? {
            let outcome = strike_all(&planner, new.clone(), &bar);
            models.insert(model.name().to_string(), outcome);
        }
        let sessions = new.len();
        trial.new_sessions = Some(NewSessions { sessions, models });
    }
    bar.finish_and_clear();
    write_json(&dir.join(FILE), &trial)?;
    Ok(trial)
}

/// Every model's planner, for this session where the version knows it, else for one that it has never seen.
fn planners(artifact: &Artifact, session: Option<&str>) -> Result<Vec<(Model, Planner)>, Error> {
    let effects = artifact.effect.as_ref();
    let known = effects.map_or_else(BTreeSet::new, |effect| effect.world.known_sessions());
    let session = session.filter(|session| known.contains(session));
    artifact
        .models()
        .into_iter()
        .map(|model| {
            let planner = Planner::new(artifact, model).map_err(Error::input)?;
            let planner = match session {
                Some(session) => planner.in_session(artifact, session),
                None => Ok(planner),
            };
            Ok((model, planner.map_err(Error::input)?))
        })
        .collect()
}

/// The rig in a session, and what is struck there.
type Course<'a> = (Sim, &'a [Pair]);

/// What one model makes of the pairs.
fn strike_all(planner: &Planner, courses: Vec<Course<'_>>, bar: &ProgressBar) -> Outcome {
    let mut outcome = Outcome::default();
    for (sim, pairs) in courses {
        strike_pairs(planner, sim, pairs, &mut outcome, bar);
    }
    outcome.summed_up()
}

/// Plans in parallel, for plans do not depend on each other; strikes in order, for the rig does.
fn strike_pairs(
    planner: &Planner,
    mut sim: Sim,
    pairs: &[Pair],
    outcome: &mut Outcome,
    bar: &ProgressBar,
) {
    let order = sim.index().order;
    let plans: Vec<_> = pairs
        .par_iter()
        .enumerate()
        .map(|(i, (from, to))| {
            // The camera sees how the object was put down.
            let yaw = sim.clone().after(order + i).next_yaw(*from);
            planner.plan_turned(*from, *to, yaw.unwrap_or(0.0))
        })
        .collect();
    for ((from, to), plan) in pairs.iter().zip(plans) {
        let start = sim.index().order;
        match plan {
            Ok(plan) => {
                let stop = sim.strike(*from, plan.command()).stop;
                outcome.strikes.push(struck(&plan, stop));
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
}

fn struck(plan: &Plan, stop: Point) -> TargetStrike {
    TargetStrike {
        from: plan.from,
        to: plan.to,
        speed: plan.speed,
        angle: plan.angle,
        stop,
        error: stop.distance(plan.to),
        expected_miss: plan.expected_miss,
    }
}

/// One strike of a plan for a box that stands straight, put down as the plan says.
fn repeat(sim: &mut Sim, plan: &Plan) -> Recording {
    match sim.next_yaw(plan.from) {
        Some(_) => sim.strike_turned(plan.from, 0.0, plan.command()),
        None => sim.strike(plan.from, plan.command()),
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
            .map(|_| repeat(&mut sim, &plan).stop)
            .collect();
        let sum = stops.iter().fold(Point::default(), |sum, stop| sum + *stop);
        let mean = sum * (1.0 / FLOOR_REPEATS as f64);
        errors.extend(stops.iter().map(|stop| widening * stop.distance(mean)));
    }
    StopErrors::of(errors.into_iter())
}
