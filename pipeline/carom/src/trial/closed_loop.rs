//! The closed loop: each model plans, the robot strikes, and the distance from target to stop is measured.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use indicatif::ProgressBar;
use rayon::prelude::*;
use store::{Artifact, Model, Store};
use strike::{Plan, Planner};
use values::{Point, StopErrors, Strike};

use super::outcome::{FILE, NewSessions, Outcome, Refused, TargetStrike, Trial};
use super::targets::{Pair, Region};
use crate::Error;
use crate::outputs::write_json;
use crate::publishing::store_error;
use crate::robot::{Opened, Table, TrialRobot};

/// Repeats of one command from which the rig's scatter is estimated.
const FLOOR_REPEATS: usize = 25;

pub struct TrialSettings<'a> {
    pub robot: &'a TrialRobot,
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
    let mut strikes = tables::read_strikes(dir).map_err(Error::input)?;
    strikes.retain(Strike::has_stop);
    let region = Region::of(&strikes)
        .ok_or_else(|| Error::input("choose targets: the run's strikes.parquet is empty"))?;
    let robot = Opened::open(wanted.robot, dir, &artifact, wanted.seed)?;

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
        .table
        .clone()
        .after(robot.table.index().order + random.len());
    let first = robot.table.index().session + usize::from(robot.session.is_some());
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
        robot: robot.origin.clone(),
        drawn,
        figure_8: BTreeMap::new(),
        noise_floor: noise_floor(reference, &later, &figure_8),
        models: BTreeMap::new(),
    };
    for (model, planner) in &planners {
        let name = model.name().to_string();
        let outcome = strike_all(planner, vec![(robot.table.clone(), &random)], &bar);
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
type Course<'a> = (Table, &'a [Pair]);

/// What one model makes of the pairs.
fn strike_all(planner: &Planner, courses: Vec<Course<'_>>, bar: &ProgressBar) -> Outcome {
    let mut outcome = Outcome::default();
    for (table, pairs) in courses {
        strike_pairs(planner, table, pairs, &mut outcome, bar);
    }
    outcome.summed_up()
}

/// Plans in parallel, for plans do not depend on each other; strikes in order, for the rig does.
fn strike_pairs(
    planner: &Planner,
    mut table: Table,
    pairs: &[Pair],
    outcome: &mut Outcome,
    bar: &ProgressBar,
) {
    let order = table.index().order;
    let plans: Vec<_> = pairs
        .par_iter()
        .enumerate()
        .map(|(i, (from, to))| {
            // The camera sees how the object was put down.
            let yaw = table.clone().after(order + i).next_yaw(*from);
            planner.plan_turned(*from, *to, yaw.unwrap_or(0.0))
        })
        .collect();
    for ((from, to), plan) in pairs.iter().zip(plans) {
        let next = table.index().order + 1;
        let stopped = plan
            .map_err(|refusal| refusal.to_string())
            .and_then(|plan| {
                let stop = table.strike(*from, None, plan.command());
                let stop = stop.ok_or("the strike comes to no rest in this world")?;
                Ok(struck(&plan, stop))
            });
        match stopped {
            Ok(strike) => outcome.strikes.push(strike),
            Err(refused) => outcome.refusals.push(Refused {
                from: *from,
                to: *to,
                refused,
            }),
        }
        // The launches of the targets that follow stay those that other models meet.
        table = table.after(next);
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

/// Distances of repeats from their mean, widened for the mean's own error.
fn noise_floor(planner: &Planner, table: &Table, pairs: &[Pair]) -> Option<StopErrors> {
    let mut table = table.clone();
    let widening = (FLOOR_REPEATS as f64 / (FLOOR_REPEATS as f64 - 1.0)).sqrt();
    let mut errors = Vec::new();
    for (from, to) in pairs {
        let Ok(plan) = planner.plan(*from, *to) else {
            continue;
        };
        let stops: Vec<Point> = (0..FLOOR_REPEATS)
            // A box that stands straight, put down as the plan says.
            .filter_map(|_| {
                let yaw = table.next_yaw(plan.from).map(|_| 0.0);
                table.strike(plan.from, yaw, plan.command())
            })
            .collect();
        if stops.is_empty() {
            continue;
        }
        let sum = stops.iter().fold(Point::default(), |sum, stop| sum + *stop);
        let mean = sum * (1.0 / stops.len() as f64);
        errors.extend(stops.iter().map(|stop| widening * stop.distance(mean)));
    }
    StopErrors::of(errors.into_iter())
}
