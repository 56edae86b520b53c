//! The pipeline: one function of straight typed calls.

use diagnose::{Diagnose, DiagnoseError, Diagnosed};
use evaluate::{Candidate, Evaluation, Judge, Model, NewSessions, Noise, Predict, Repeat};
use residual::{LaunchItem, Launches, Residuals};
use solve::Solve;
use stage::{Run, RunError};
use store::ResidualModel;
use sysid::{Fit, Sysid};
use train::{CurvePoint, Learned, Settings, Train, curve_sizes, examples};
use values::{Rig, Split, Strike};
use world::World;

use crate::growth::learning_count;
use crate::inputs::Inputs;
use crate::noise::noise;
use crate::results::{Results, WorldResults};
use crate::{Error, first_version, publishing, reading};

/// How far to go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Step {
    /// Strikes from logs.
    Ingest,
    /// The identified world.
    Sysid,
    /// The effects that it lacks.
    Diagnose,
    /// Every path solved backwards in it.
    Solve,
    /// What the world still gets wrong.
    Residual,
    /// A network that knows it.
    Train,
    /// Stop errors on held-out strikes.
    Evaluate,
    /// What a version for the executor holds.
    Publish,
}

/// Goes through the steps up to and with `last`; each answers from the run's cache where nothing changed.
pub fn pipeline(run: &Run, inputs: &Inputs, last: Step) -> Result<Results, Error> {
    let read = reading::read(run, &inputs.rig, &inputs.logs, inputs.seed)?;
    // With the fences that were found.
    let inputs = &Inputs {
        rig: read.rig,
        ..inputs.clone()
    };
    let Inputs { rig, seed, .. } = inputs;
    let mut results = Results {
        kept: read.strikes,
        rejects: read.rejects,
        logs: read.logs,
        left_out: read.left_out,
        damaged: read.damaged,
        log_notes: read.notes,
        check: read.check,
        rig: Some(rig.clone()),
        ..Results::default()
    };
    if last < Step::Sysid {
        return Ok(results);
    }
    // From here on all are held.
    results.strikes = results.kept.iter().collect::<Result<_, _>>()?;
    if results.check.is_meaningless() {
        return Ok(results);
    }
    let strikes = &results.strikes;

    let fit = identify(run, rig, strikes)?;
    let identified = fit.world.clone();
    results.sysid = Some(WorldResults::new(identified.clone()));
    results.fit = Some(fit);
    if last < Step::Diagnose {
        return Ok(results);
    }

    match find_effects(run, inputs, identified, strikes) {
        // A ball, and strikes that are too few to decide, still identify, solve and learn.
        Err(Error::Input(why)) if last > Step::Diagnose => {
            results.no_diagnosis = Some(format!("failed to {why}"));
        }
        found => results.found = Some(found?),
    }
    if !inputs.without_effects {
        let world = results.found.as_ref().and_then(|found| found.world.clone());
        results.effect = world.map(WorldResults::new);
    }
    if last < Step::Solve {
        return Ok(results);
    }

    // Tracks that end before rest have identified and diagnosed; they have no path to solve for, and no stop that judges. Where none
    // rests, the places at their ends judge the worlds.
    if last >= Step::Evaluate && !results.strikes.iter().any(Strike::has_stop) {
        results.evaluation = evaluated(run, rig, &results)?;
    }
    let all = results.strikes.len();
    results.strikes.retain(Strike::has_stop);
    results.without_stop = all - results.strikes.len();
    if results.strikes.is_empty() {
        return Ok(results);
    }
    let strikes = &results.strikes;
    let paths: Vec<solve::Path> = strikes.iter().map(solve::Path::from).collect();
    for of_world in results.sysid.iter_mut().chain(&mut results.effect) {
        let shared = solve::Shared {
            rig: rig.clone(),
            world: of_world.world.clone(),
        };
        of_world.solutions = run.items(&Solve::default(), &shared, &paths)?;
    }
    if last < Step::Residual {
        return Ok(results);
    }

    let launched: Vec<LaunchItem> = strikes.iter().map(LaunchItem::from).collect();
    for of_world in results.sysid.iter_mut().chain(&mut results.effect) {
        let solved = (strikes.clone(), of_world.solutions.clone());
        of_world.residuals = run.stage(&Residuals::default(), &solved)?;
        let shared = residual::Shared {
            rig: rig.clone(),
            world: of_world.world.clone(),
        };
        of_world.launches = run.items(&Launches {}, &shared, &launched)?;
    }
    if last < Step::Train {
        return Ok(results);
    }

    let (learned, curve) = learn(run, *seed, &results)?;
    let worlds = results.sysid.iter_mut().chain(&mut results.effect);
    for (of_world, learned) in worlds.zip(learned) {
        of_world.learned = Some(learned);
    }
    results.curve = curve;
    if last < Step::Evaluate {
        return Ok(results);
    }

    results.evaluation = evaluated(run, rig, &results)?;
    if let Some((_, used)) = results.used() {
        let candidates = curve_candidates(&used.world, &results.curve);
        let curve = judge(run, rig, &judges(strikes), &candidates, &noise(rig, used))?;
        results.curve_errors = mean_errors(&results.curve, &curve);
    }
    if last < Step::Publish {
        return Ok(results);
    }

    let contents = publishing::contents(run, inputs, &results)?;
    let used = contents.provenance.default_model;
    let candidate = models(rig, &results)
        .into_iter()
        .find(|one| one.name == used.name());
    if let Some(candidate) = candidate {
        results.first_version = Some(first_version::judge(
            run,
            rig,
            &results.strikes,
            results.fit.as_ref(),
            results.evaluation.as_ref(),
            &candidate,
        )?);
    }
    results.contents = Some(contents);
    Ok(results)
}

/// Every model's errors on the strikes that judge; none where there is no world.
fn evaluated(run: &Run, rig: &Rig, results: &Results) -> Result<Option<Evaluation>, Error> {
    let Some((_, used)) = results.used() else {
        return Ok(None);
    };
    let judges = judges(&results.strikes);
    let models = models(rig, results);
    let new_sessions = judge_new_sessions(run, rig, &judges, &models)?;
    Ok(Some(Evaluation {
        new_sessions,
        ..judge(run, rig, &judges, &models, &noise(rig, used))?
    }))
}

/// The strikes that judge models.
fn judges(strikes: &[Strike]) -> Vec<Judge> {
    let held_out = strikes.iter().filter(|strike| strike.split == Split::Test);
    held_out.map(Judge::from).collect()
}

/// Identification is given the strikes that it looks at and no others: new ones then leave its answer, and with it every
/// solution, as they were.
fn identify(run: &Run, rig: &Rig, strikes: &[Strike]) -> Result<Fit, Error> {
    let sysid = Sysid::default();
    let learnt_from = |strike: &&Strike| strike.split == Split::Train && strike.track.len() >= 4;
    let input = sysid::Input {
        rig: rig.clone(),
        world: World::nominal(rig),
        strikes: strikes
            .iter()
            .filter(learnt_from)
            .take(sysid.most_strikes)
            .cloned()
            .collect(),
    };
    run.stage(&sysid, &input).map_err(|error| match error {
        RunError::Stage(error @ sysid::SysidError::TooFewStrikes { .. }) => Error::input(error),
        error => error.into(),
    })
}

/// The strikes that diagnosis and training look at: the earliest ([`learning_count`]).
fn learning(strikes: &[Strike]) -> &[Strike] {
    &strikes[..learning_count(strikes.len())]
}

/// Diagnosis, too, is given the strikes that it looks at and no others.
fn find_effects(
    run: &Run,
    inputs: &Inputs,
    world: World,
    strikes: &[Strike],
) -> Result<Diagnosed, Error> {
    let diagnose = Diagnose {
        seed: inputs.seed,
        ..Diagnose::default()
    };
    let input = diagnose::Input {
        rig: inputs.rig.clone(),
        world,
        strikes: diagnose.sample(learning(strikes)),
    };
    run.stage(&diagnose, &input).map_err(|error| match error {
        RunError::Stage(error @ (DiagnoseError::TooFewStrikes { .. } | DiagnoseError::Rolls)) => {
            Error::input(error)
        }
        error => error.into(),
    })
}

/// Learns in each world from the strikes that learn, and from the first of them for the learning curve of the world
/// that will be used.
fn learn(run: &Run, seed: u64, results: &Results) -> Result<Training, Error> {
    let settings = Settings {
        seed,
        ..Settings::default()
    };
    let worlds: Vec<&WorldResults> = results.sysid.iter().chain(&results.effect).collect();
    // The identified world outlives the one with effects: what was learnt is kept with it.
    let family = worlds
        .first()
        .map_or(String::new(), |of_world| of_world.world.to_toml());
    let learning = learning(&results.strikes);
    let of =
        |of_world: &WorldResults| examples(learning, &of_world.launches, &of_world.residuals.rows);
    let mut sets: Vec<_> = worlds.iter().map(|of_world| of(of_world)).collect();
    let mut sizes = Vec::new();
    if let Some((_, used)) = results.used() {
        let examples = of(used);
        sizes = curve_sizes(examples.len());
        sets.extend(sizes.iter().map(|size| examples[..*size].to_vec()));
    }
    let mut learned = run.items(&Train { settings }, family.as_str(), &sets)?;
    let points = learned.split_off(worlds.len());
    let curve = sizes
        .into_iter()
        .zip(points)
        .map(|(strikes, learned)| CurvePoint { strikes, learned });
    Ok((learned, curve.collect()))
}

/// What was learnt in each world, and what makes the learning curve.
type Training = (Vec<Learned>, Vec<CurvePoint>);

/// The candidates' stop errors on the judges; what a strike said of a model is kept.
fn judge(
    run: &Run,
    rig: &Rig,
    judges: &[Judge],
    candidates: &[Candidate],
    noise: &Noise,
) -> Result<Evaluation, Error> {
    let mut predicted = Vec::new();
    for candidate in candidates {
        let answers = run.items(&Predict, &Model::of(rig, candidate), judges)?;
        predicted.push((candidate.name.clone(), answers));
    }
    let repeats = match candidates.last() {
        Some(last) => run.items(&Repeat, &Model::of(rig, last).world_alone(), judges)?,
        None => Vec::new(),
    };
    evaluate::evaluation(judges, &predicted, &repeats, noise).map_err(Error::failed)
}

/// The same where the candidates have never seen the judges' sessions. A candidate in which nothing differs by session has answered
/// already.
fn judge_new_sessions(
    run: &Run,
    rig: &Rig,
    judges: &[Judge],
    candidates: &[Candidate],
) -> Result<Option<NewSessions>, Error> {
    let mut predicted = Vec::new();
    for candidate in candidates {
        let mut answers = Vec::new();
        for (model, judges) in evaluate::unseen(rig, candidate, judges) {
            let predicted = run.items(&Predict, &model, &judges)?;
            answers.extend(judges.into_iter().zip(predicted));
        }
        predicted.push((candidate.name.clone(), answers));
    }
    evaluate::new_sessions(&predicted).map_err(Error::failed)
}

/// The models that are compared, the plainest first.
fn models(rig: &Rig, results: &Results) -> Vec<Candidate> {
    let mut models = vec![Candidate {
        name: "nominal".into(),
        world: World::nominal(rig),
        residual: None,
    }];
    for (name, of_world) in [("sysid", &results.sysid), ("effect", &results.effect)] {
        let Some(of_world) = of_world else { continue };
        let candidate = |name: String, residual: Option<&ResidualModel>| Candidate {
            name,
            world: of_world.world.clone(),
            residual: residual.cloned(),
        };
        models.push(candidate(name.into(), None));
        // Where nothing is added, the row is the world's own.
        if let Some(learned) = &of_world.learned {
            let name = format!("{name}_residual");
            models.push(candidate(name, learned.model.as_ref()));
        }
    }
    models
}

/// What was learnt at each point of the curve, named by its number of strikes.
fn curve_candidates(world: &World, curve: &[CurvePoint]) -> Vec<Candidate> {
    curve
        .iter()
        .map(|point| Candidate {
            name: point.strikes.to_string(),
            world: world.clone(),
            residual: point.learned.model.clone(),
        })
        .collect()
}

/// The curve's points by their mean stop errors in m.
fn mean_errors(curve: &[CurvePoint], evaluation: &Evaluation) -> Vec<(usize, f64)> {
    let point = |point: &CurvePoint| {
        let error = evaluation.models.get(&point.strikes.to_string())?;
        Some((point.strikes, error.mean))
    };
    curve.iter().filter_map(point).collect()
}
