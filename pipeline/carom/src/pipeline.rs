//! The pipeline: one function of straight typed calls.

use diagnose::{Diagnose, DiagnoseError, Diagnosed};
use judge::{Candidate, HeldOut, Model, Path, Solve, evaluate, stop_errors};
use stage::{Run, RunError};
use sysid::{Fit, Sysid};
use train::{Kind, Learned, Settings, Train, curve_sizes};
use values::{Rig, Split, StopErrors, Strike};
use world::World;

use crate::growth::{latest, learning_count, learnt};
use crate::inputs::Inputs;
use crate::noise::noise;
use crate::results::{CurvePoint, NewVersion, Results, SolvedWorld, WorldResults, Worlds};
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

/// What is said of logs in which objects slide, and no strike began a slide.
const NO_STRIKE: &str = "no strike was seen: slides that none began tell how the table brakes, and nothing of the arm; log strikes for a version";

/// Goes through the steps up to and with `last`; each answers from the run's cache where nothing changed.
pub fn pipeline(run: &Run, inputs: &Inputs, last: Step) -> Result<Results, Error> {
    let read = reading::read(run, &inputs.rig, &inputs.logs, inputs.seed)?;
    let mut results = Results {
        read,
        strikes: Vec::new(),
        without_stop: 0,
        worlds: None,
    };
    if last < Step::Sysid {
        return Ok(results);
    }
    // From here on all are held.
    results.strikes = results.read.strikes.iter().collect::<Result<_, _>>()?;
    if results.read.check.is_meaningless() {
        return Ok(results);
    }
    // With the fences that were found.
    let inputs = &Inputs {
        rig: results.read.rig.clone(),
        ..inputs.clone()
    };
    let rig = &inputs.rig;

    let slides = &results.read.slides;
    let mut worlds = Worlds::new(identify(run, rig, &results.strikes, slides)?);
    if results.strikes.is_empty() {
        worlds.diagnosis = Some(Err(NO_STRIKE.into()));
        results.worlds = Some(worlds);
        return Ok(results);
    }
    if last >= Step::Diagnose {
        let found = match find_effects(run, inputs, &worlds.sysid.world, &results.strikes) {
            // A ball, and strikes that are too few to decide, still identify, solve and learn.
            Err(Error::Input(why)) if last > Step::Diagnose => Err(format!("failed to {why}")),
            found => Ok(found?),
        };
        let used = found.as_ref().ok().and_then(|found| found.used().cloned());
        worlds.effect = used
            .filter(|_| !inputs.without_effects)
            .map(WorldResults::new);
        worlds.diagnosis = Some(found);
    }
    if last >= Step::Solve {
        beyond_worlds(run, inputs, last, &mut results, &mut worlds)?;
    }
    results.worlds = Some(worlds);
    Ok(results)
}

/// The steps that need stops. Tracks that end before rest have identified and diagnosed; they have no path to solve for, and no stop that
/// judges. Where hardly any rests, the places at their ends judge the worlds.
fn beyond_worlds(
    run: &Run,
    inputs: &Inputs,
    last: Step,
    results: &mut Results,
    worlds: &mut Worlds,
) -> Result<(), Error> {
    let rig = &inputs.rig;
    let evaluated = |worlds: &Worlds, strikes: &[Strike]| -> Result<_, Error> {
        let noise = noise(rig, worlds);
        Ok(evaluate(
            run,
            &models(rig, worlds),
            &judges(strikes),
            &noise,
        )?)
    };
    let has_none = |strike: &&Strike| !strike.has_stop();
    results.without_stop = results.strikes.iter().filter(has_none).count();
    if Strike::many_rest(&results.strikes) {
        results.strikes.retain(Strike::has_stop);
    } else {
        if last >= Step::Evaluate {
            worlds.evaluation = Some(evaluated(worlds, &results.strikes)?);
        }
        results.strikes.clear();
    }
    let strikes = &results.strikes;
    if strikes.is_empty() {
        return Ok(());
    }

    let places = learnt(strikes);
    let paths: Vec<Path> = places
        .iter()
        .map(|place| Path::from(&strikes[*place]))
        .collect();
    for of_world in worlds.each_mut() {
        let model = Model::of_world(rig, &of_world.world);
        let solved = run.items(&Solve::default(), &model, &paths)?;
        let paths = places.iter().copied().zip(solved).collect();
        of_world.solved = Some(SolvedWorld::of(strikes, paths));
    }
    if last < Step::Train {
        return Ok(());
    }

    let learned = learn(run, inputs.seed, worlds, strikes)?;
    for (of_world, learned) in worlds.each_mut().zip(learned) {
        of_world.learned = Some(learned);
    }
    if last < Step::Evaluate {
        return Ok(());
    }

    worlds.evaluation = Some(evaluated(worlds, strikes)?);
    worlds.curve = curve(run, inputs, worlds, strikes)?;
    if last < Step::Publish {
        return Ok(());
    }

    let contents = publishing::contents(run, inputs, results, worlds)?;
    let used = contents.provenance.default_model.name();
    let mut models = models(rig, worlds).into_iter();
    let candidate = models.find(|candidate| candidate.name == used);
    let candidate = candidate.ok_or_else(|| Error::failed("publish: no model was learnt"))?;
    let floor = contents.provenance.noise_floor;
    let diagnosis = worlds.found().map(|found| &found.diagnosis);
    let gate = first_version::judge(run, strikes, &worlds.fit, diagnosis, floor, &candidate)?;
    worlds.version = Some(NewVersion { contents, gate });
    Ok(())
}

/// The strikes that judge models: the latest that are held out.
fn judges(strikes: &[Strike]) -> Vec<HeldOut> {
    let held_out = strikes.iter().filter(|strike| strike.split == Split::Test);
    latest(held_out.map(HeldOut::from).collect())
}

/// Identification is given the strikes that it looks at, and no more than the numbers of others: new ones then leave its answer, and with it every
/// solution, as they were, unless friction wanders.
fn identify(run: &Run, rig: &Rig, strikes: &[Strike], slides: &[Strike]) -> Result<Fit, Error> {
    let sysid = Sysid::default();
    let (mut used, mut later) = (Vec::new(), Vec::new());
    for (i, strike) in strikes.iter().enumerate() {
        let teaches = strike.split == Split::Train && strike.track.len() >= 4;
        if teaches && used.len() < sysid.most_strikes {
            used.push(strike);
        } else if i < learning(strikes).len() {
            later.push(strike.conditions.order);
        }
    }
    let slides = slides.iter().take(sysid.most_strikes);
    let input = sysid::Input {
        rig: rig.clone(),
        world: World::nominal(),
        strikes: used.into_iter().chain(slides).cloned().collect(),
        later,
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
    world: &World,
    strikes: &[Strike],
) -> Result<Diagnosed, Error> {
    let diagnose = Diagnose {
        seed: inputs.seed,
        ..Diagnose::default()
    };
    let (rig, world) = (inputs.rig.clone(), world.clone());
    let input = diagnose::Input::sampled(&diagnose, rig, world, learning(strikes));
    run.stage(&diagnose, &input).map_err(|error| match error {
        RunError::Stage(
            error @ (DiagnoseError::TooFewStrikes { .. }
            | DiagnoseError::NoFit { .. }
            | DiagnoseError::Rolls),
        ) => Error::input(error),
        error => error.into(),
    })
}

/// Learns in each world from the strikes that learn.
fn learn(run: &Run, seed: u64, worlds: &Worlds, strikes: &[Strike]) -> Result<Vec<Learned>, Error> {
    let sets: Vec<_> = worlds
        .each()
        .map(|(_, of_world)| of_world.examples(learning(strikes)))
        .collect();
    Ok(run.items(&train(seed, true), &family(worlds), &sets)?)
}

/// What the first strikes teach in the world that will be used, by their number. Networks are tried where they won on all strikes.
fn curve(
    run: &Run,
    inputs: &Inputs,
    worlds: &Worlds,
    strikes: &[Strike],
) -> Result<Vec<CurvePoint>, Error> {
    let (_, used) = worlds.used();
    let examples = used.examples(learning(strikes));
    let sizes = curve_sizes(examples.len());
    let sets: Vec<_> = sizes
        .iter()
        .map(|size| examples[..*size].to_vec())
        .collect();
    let learned = used.learned.as_ref();
    let are_networks = learned.is_some_and(|learned| learned.kind == Kind::Networks);
    let learned = run.items(&train(inputs.seed, are_networks), &family(worlds), &sets)?;
    let judges = judges(strikes);
    let point = |(strikes, learned): (usize, Learned)| -> Result<CurvePoint, Error> {
        let model = used.model(&inputs.rig, learned.model.as_ref());
        let errors = stop_errors(run, &model, &judges)?.into_iter().flatten();
        Ok(CurvePoint {
            strikes,
            learned,
            error: StopErrors::of(errors).map(|errors| errors.mean),
        })
    };
    sizes.into_iter().zip(learned).map(point).collect()
}

fn train(seed: u64, networks: bool) -> Train {
    Train {
        settings: Settings {
            seed,
            networks,
            ..Settings::default()
        },
    }
}

/// The identified world outlives the one with effects: what was learnt is kept with it.
fn family(worlds: &Worlds) -> String {
    worlds.sysid.world.to_toml()
}

/// The models that are compared, the plainest first.
fn models(rig: &Rig, worlds: &Worlds) -> Vec<Candidate> {
    let mut models = vec![Candidate {
        name: store::Model::Nominal.to_string(),
        model: Model::of_world(rig, &World::nominal()),
    }];
    for (name, of_world) in worlds.each() {
        models.push(Candidate {
            name: name.to_string(),
            model: of_world.model(rig, None),
        });
        // Where nothing is added, the row is the world's own.
        if let Some(learned) = &of_world.learned {
            models.push(Candidate {
                name: name.with_residual().to_string(),
                model: of_world.model(rig, learned.model.as_ref()),
            });
        }
    }
    models
}
