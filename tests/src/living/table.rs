//! Strikes at targets after recent strikes, by the filter and by its peers.

use std::path::Path;

use anyhow::{Context, ensure};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rig::{RecordingWriter, Sim, Truth};
use store::{Artifact, Store};
use strike::{Plan, Planner};
use values::{Command, Point, Strike};

use super::drawn::{Case, LivingRig};
use super::outcome::{Method, Outcome, RECENT};
use crate::carom;

/// Strikes that a version learns from, in one session.
const LEARNT: usize = 100;
/// Targets after each number of recent strikes.
const TARGETS: usize = 24;
/// How often the command for each target is repeated.
const REPEATS: usize = 16;
/// How often each planned command is struck, where the table stands still meanwhile; their orders lie so far apart.
const STRUCK: usize = 8;
const APART: usize = 1000;

type Pair = (Point, Point);

pub fn measure(rig: &LivingRig, scratch: &Path) -> anyhow::Result<Vec<Outcome>> {
    let mut outcomes = Vec::new();
    let learnt = learn(rig, Case::Steady, &scratch.join("usual"))?;
    for case in Case::ALL {
        if case == Case::Wander {
            let learnt = learn(rig, case, &scratch.join("wander"))?;
            outcomes.extend(measure_case(rig, case, &learnt, scratch)?);
        } else {
            outcomes.extend(measure_case(rig, case, &learnt, scratch)?);
        }
    }
    Ok(outcomes)
}

struct Learnt {
    artifact: Artifact,
    paths: Vec<Pair>,
}

fn learn(rig: &LivingRig, case: Case, dir: &Path) -> anyhow::Result<Learnt> {
    let settings = rig::demo::Settings {
        truth: rig.before(case)?,
        sessions: Some(1),
        ..rig::demo::Settings::new(values::Shape::Cylinder, LEARNT, rig.number, None)
    };
    let written = rig::demo::write(&settings, &dir.join("rig"))?;
    carom(&format!(
        "run {} --rig {} --out {}",
        dir.join("rig/logs").display(),
        written.rig.display(),
        dir.join("run").display()
    ))?;
    let strikes = Truth::load(&written.truth)?.strikes;
    Ok(Learnt {
        artifact: Store::open(&dir.join("run")).load(None)?,
        paths: strikes
            .iter()
            .map(|strike| (strike.initial, strike.stop))
            .collect(),
    })
}

/// A strike as the version plans it without any adaptation, and as it is read from its log.
type Struck = (Plan, Strike);

fn measure_case(
    rig: &LivingRig,
    case: Case,
    learnt: &Learnt,
    scratch: &Path,
) -> anyhow::Result<Vec<Outcome>> {
    let artifact = &learnt.artifact;
    let planner = || Planner::new(artifact, artifact.manifest.provenance.default_model);
    let usual = planner()?;
    let mut random = ChaCha8Rng::seed_from_u64(rig.number ^ 0x1E9);
    let most = RECENT[RECENT.len() - 1];
    let count = most + TARGETS;
    let targets = targets(&usual, &learnt.paths, count, &mut random);
    ensure!(
        targets.len() == count,
        "rig {}: too few targets",
        rig.number
    );
    // The rig goes on after the strikes that were learnt from.
    let sim = Sim::from(rig.after(case)?)?;
    let struck = |truth: Truth| -> anyhow::Result<Vec<Struck>> {
        let mut sim = Sim::from(truth)?.after(LEARNT);
        let one = |(place, pair): (usize, &Pair)| {
            let plan = plan(&usual, *pair)?;
            let recording = sim.strike(plan.from, plan.command());
            Ok((plan, ingested(&recording, artifact, place, scratch)?))
        };
        targets.iter().enumerate().map(one).collect()
    };
    let made = struck(rig.after(case)?)?;
    let bad = case.bad().map(|place| Ok((place, struck(rig.bad(case)?)?)));
    let bad: Option<(usize, Vec<Struck>)> =
        bad.transpose().map_err(|error: anyhow::Error| error)?;
    let floor = floor(&usual, rig.repeating(case)?, &targets[most..])?;
    let mut outcomes = Vec::new();
    for recent in RECENT {
        // Each target is the next strike after those that were seen, whichever number of these: it meets the same launch.
        for (place, &pair) in targets.iter().enumerate().skip(most) {
            let seen: Vec<Struck> = (place - recent..place)
                .enumerate()
                .map(|(order, place)| match &bad {
                    Some((is_bad, bad)) if *is_bad == order => bad[place].clone(),
                    _ => made[place].clone(),
                })
                .collect();
            let mut says_changed = false;
            let adapted = if recent == 0 {
                planner()?
            } else {
                let mut followed = usual.recent();
                let strikes: Vec<Strike> = seen.iter().map(|(_, s)| s.clone()).collect();
                // What would be refused is struck all the same, and shows in the misses.
                says_changed = usual.follow(artifact, &mut followed, &strikes).is_err();
                planner()?.adapted(&followed, true)
            };
            for method in Method::ALL {
                if recent == 0 && method != Method::Filter {
                    continue;
                }
                let planned = command(method, (&usual, &adapted), &seen, pair);
                let Some((command, promise)) = planned else {
                    continue;
                };
                let repeats = if case == Case::Wander { 1 } else { STRUCK };
                for repeat in 0..repeats {
                    let mut sim = sim.clone().after(LEARNT + place + repeat * APART);
                    let stop = sim.strike(pair.0, command).stop;
                    outcomes.push(Outcome {
                        rig: rig.number,
                        case,
                        method,
                        recent,
                        miss: stop.distance(pair.1),
                        promise,
                        floor,
                        says_changed: says_changed && method == Method::Filter,
                    });
                }
            }
        }
    }
    Ok(outcomes)
}

/// The command for a target, and what its plan promises.
fn command(
    method: Method,
    (usual, adapted): (&Planner, &Planner),
    recent: &[Struck],
    (from, to): Pair,
) -> Option<(Command, Option<f64>)> {
    let last = recent.last();
    let planned = match method {
        Method::Filter => {
            let plan = adapted.plan(from, to).ok()?;
            return Some((plan.command(), plan.expected_miss));
        }
        Method::None => usual.plan(from, to).ok()?.command(),
        Method::LastError => {
            let (plan, strike) = last?;
            usual
                .plan(from, to - (strike.stop - plan.to))
                .ok()?
                .command()
        }
        Method::NewtonLast | Method::NewtonMean => {
            let used = if method == Method::NewtonLast {
                &recent[recent.len() - 1..]
            } else {
                recent
            };
            let errors = used
                .iter()
                .map(|(plan, strike)| error(plan.path, strike.stop - plan.from));
            let sum = errors.fold([0.0; 2], |sum, e| [sum[0] + e[0], sum[1] + e[1]]);
            let mean = sum.map(|sum| sum / used.len() as f64);
            newton(usual.plan(from, to).ok()?.command(), mean)
        }
    };
    Some((planned, None))
}

/// Paths like those learnt from, at which the version plans.
fn targets(planner: &Planner, paths: &[Pair], count: usize, random: &mut ChaCha8Rng) -> Vec<Pair> {
    let mut targets = Vec::new();
    for _ in 0..20 * count {
        if targets.len() == count {
            break;
        }
        let (from, _) = paths[random.random_range(0..paths.len())];
        let (start, stop) = paths[random.random_range(0..paths.len())];
        let to = from + (stop - start) * (0.85 + 0.1 * random.random::<f64>());
        if planner.plan(from, to).is_ok() {
            targets.push((from, to));
        }
    }
    targets
}

fn plan(planner: &Planner, (from, to): Pair) -> anyhow::Result<Plan> {
    planner
        .plan(from, to)
        .map_err(|refusal| anyhow::anyhow!("{refusal}"))
}

/// Mean distance of repeats from their mean, over these targets, on a table that does not wander. On a table that changed the version's
/// own commands end elsewhere, and what goes less far scatters less: their mean error is taken off first, by a Newton step.
fn floor(planner: &Planner, truth: Truth, targets: &[Pair]) -> anyhow::Result<f64> {
    let mut sim = Sim::from(truth)?.after(2 * LEARNT);
    let mut repeat = |from, command| {
        let stops: Vec<Point> = (0..REPEATS)
            .map(|_| sim.strike(from, command).stop)
            .collect();
        let total = stops.iter().fold(Point::default(), |sum, stop| sum + *stop);
        (total * (1.0 / REPEATS as f64), stops)
    };
    let mut sum = 0.0;
    for pair in targets {
        let plan = plan(planner, *pair)?;
        let (mean, _) = repeat(plan.from, plan.command());
        let command = newton(plan.command(), error(plan.path, mean - plan.from));
        let (mean, stops) = repeat(plan.from, command);
        sum += stops.iter().map(|stop| stop.distance(mean)).sum::<f64>();
    }
    let repeats = REPEATS as f64;
    let widening = (repeats / (repeats - 1.0)).sqrt();
    Ok(widening * sum / (repeats * targets.len() as f64))
}

/// By how much a strike went farther (ln) and to the left (rad) than was meant.
fn error(meant: Point, went: Point) -> [f64; 2] {
    [
        (went.norm() / meant.norm()).ln(),
        went.bearing() - meant.bearing(),
    ]
}

/// The command less such an error: distance goes as speed squared, bearing as angle.
fn newton(command: Command, error: [f64; 2]) -> Command {
    Command::new(
        command.speed * (-0.5 * error[0]).exp(),
        command.angle - error[1],
    )
}

fn ingested(
    recording: &rig::Recording,
    artifact: &Artifact,
    place: usize,
    scratch: &Path,
) -> anyhow::Result<Strike> {
    let path = scratch.join(format!("recent_{place}.mcap"));
    let topics = &artifact.rig.topics;
    let mut writer = RecordingWriter::create(&path, topics)?;
    writer.write(&recording.samples)?;
    writer.finish()?;
    let outcome = ingest::ingest_log(&path, &artifact.rig, &ingest::Ingest::default())?;
    let (strikes, rejects) = ingest::assemble(vec![outcome]);
    strikes
        .into_iter()
        .next()
        .with_context(|| format!("no strike was kept: {rejects:?}"))
}
