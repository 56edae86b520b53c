//! Trials in closed loop: targets, strikes and their results (`trial.json`).

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use indicatif::ProgressBar;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use store::{Artifact, Model, Store};
use strike::{Plan, Planner};
use values::{Point, StopErrors, Strike, wrap_angle};

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

pub const FILE: &str = "trial.json";

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TargetStrike {
    /// Where the object rested, in m.
    pub from: Point,
    /// Where it was to stop, in m.
    pub to: Point,
    /// Commanded speed in m/s.
    pub speed: f64,
    /// Commanded angle in rad.
    pub angle: f64,
    /// Where the camera saw it stop, in m.
    pub stop: Point,
    /// Distance from target to stop, in m.
    pub error: f64,
    /// What the plan expected that to be, in m; none where the version does not state it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected_miss: Option<f64>,
}

/// A target that a model's planner refused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Refused {
    /// Where the object rested, in m.
    pub from: Point,
    /// Where it was to stop, in m.
    pub to: Point,
    /// Reason and detail.
    pub refused: String,
}

/// How a model did.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Stop errors; none where every target was refused.
    #[serde(flatten)]
    pub errors: Option<StopErrors>,
    /// Mean of what the plans expected, in m; none where a version does not state it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected_miss: Option<f64>,
    pub strikes: Vec<TargetStrike>,
    /// Every target refused, which no number above counts.
    pub refusals: Vec<Refused>,
}

impl Outcome {
    /// Sums up its strikes.
    pub fn summed_up(mut self) -> Self {
        self.errors = StopErrors::of(self.strikes.iter().map(|strike| strike.error));
        let expected = self.strikes.iter().map(|strike| strike.expected_miss);
        let expected: Option<Vec<f64>> = expected.collect();
        self.expected_miss = expected
            .and_then(|expected| StopErrors::of(expected.into_iter()))
            .map(|expected| expected.mean);
        self
    }
}

/// The random targets struck again in sessions that the version has never seen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NewSessions {
    pub sessions: usize,
    /// Each target struck once, in one of the sessions; by model.
    #[serde(flatten)]
    pub models: BTreeMap<String, Outcome>,
}

/// What `trial.json` holds: a key for each model (its random targets), `noise_floor`, `figure_8` and `new_sessions`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Version that struck.
    pub artifact: String,
    /// Which rig was struck.
    pub robot: String,
    /// Random targets drawn, those included that the reference model refused.
    pub drawn: usize,
    /// The paper's Figure 8: two starts, four targets each, struck several times; by model.
    pub figure_8: BTreeMap<String, Outcome>,
    /// Distances of repeats of one command from their mean: what no model can better.
    pub noise_floor: Option<StopErrors>,
    /// The session that all of this was struck in but `new_sessions`: the last one that was logged; none where the rig was not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub session: Option<String>,
    /// Strikes at random targets in new sessions; none where none was requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub new_sessions: Option<NewSessions>,
    /// Random targets, struck once; by model.
    #[serde(flatten)]
    pub models: BTreeMap<String, Outcome>,
}

/// An earlier trial in a run's folder; none where there is none or it is not readable.
pub fn kept(dir: &Path) -> Option<Trial> {
    let text = std::fs::read_to_string(dir.join(FILE)).ok()?;
    serde_json::from_str(&text).ok()
}

/// Starts and targets of the paper's Figure 8.
const STARTS: usize = 2;
/// Shares of the way from the shortest to the longest path, and from the rightmost to the leftmost bearing.
const TARGETS: [(f64, f64); 4] = [(0.25, 0.25), (0.25, 0.75), (0.75, 0.25), (0.75, 0.75)];
/// Figure 8's targets are drawn in towards the middle of what was trained by this share until they can be planned.
const SHRINK: f64 = 0.8;
const SHRINKS: u32 = 12;
/// Draws for each random target that is wanted.
const TRIES: usize = 20;
/// Share of training strikes at each end that targets keep clear of.
const EDGE: f64 = 0.02;

pub type Pair = (Point, Point);

/// Where the strikes that were learnt from started, and which paths they took.
pub struct Region {
    x: (f64, f64),
    y: (f64, f64),
    distance: (f64, f64),
    bearing: (f64, f64),
}

impl Region {
    /// The region of these strikes; none where there is no strike.
    pub fn of(strikes: &[Strike]) -> Option<Self> {
        // Bearings on either side of ±π are neighbours: they are taken relative to their middle.
        let sum = |sum: Point, strike: &Strike| sum + Point::polar(1.0, strike.path().bearing());
        let middle = strikes.iter().fold(Point::default(), sum).bearing();
        let ends = |value: &dyn Fn(&Strike) -> f64| {
            let mut values: Vec<f64> = strikes.iter().map(value).collect();
            values.sort_by(f64::total_cmp);
            let last = values.len().checked_sub(1)?;
            let skipped = (EDGE * last as f64).round() as usize;
            Some((values[skipped], values[last - skipped]))
        };
        Some(Self {
            x: ends(&|strike| strike.initial.x)?,
            y: ends(&|strike| strike.initial.y)?,
            distance: ends(&|strike| strike.path().norm())?,
            bearing: ends(&|strike| middle + wrap_angle(strike.path().bearing() - middle))?,
        })
    }

    /// The paper's Figure 8 for this rig: two starts, four targets each, near and far, right and left. All can be planned
    /// by `reference`, or are as near to the middle of what was trained as is tried.
    pub fn figure_8(&self, reference: &Planner) -> Vec<Pair> {
        (0..STARTS)
            .flat_map(|start| {
                let share = (start as f64 + 0.5) / STARTS as f64;
                let from = Point::new(between(self.x, 0.5), between(self.y, share));
                TARGETS.map(|target| (from, self.nearest_planned(reference, from, target)))
            })
            .collect()
    }

    fn nearest_planned(&self, reference: &Planner, from: Point, target: (f64, f64)) -> Point {
        let mut away = 1.0;
        let mut to = from;
        for _ in 0..SHRINKS {
            let towards = |share: f64| 0.5 + away * (share - 0.5);
            to = from
                + Point::polar(
                    between(self.distance, towards(target.0)),
                    between(self.bearing, towards(target.1)),
                );
            if reference.plan(from, to).is_ok() {
                break;
            }
            away *= SHRINK;
        }
        to
    }

    /// Random starts and targets that `reference` can plan, and how many were drawn in all.
    pub fn random(&self, reference: &Planner, count: usize, seed: u64) -> (Vec<Pair>, usize) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut pairs = Vec::with_capacity(count);
        let mut drawn = 0;
        while pairs.len() < count && drawn < TRIES * count {
            drawn += 1;
            let mut draw = |ends| between(ends, random.random::<f64>());
            let from = Point::new(draw(self.x), draw(self.y));
            let to = from + Point::polar(draw(self.distance), draw(self.bearing));
            if reference.plan(from, to).is_ok() {
                pairs.push((from, to));
            }
        }
        (pairs, drawn)
    }
}

fn between((low, high): (f64, f64), share: f64) -> f64 {
    low + share * (high - low)
}
