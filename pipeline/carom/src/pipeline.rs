//! The pipeline: one function of straight typed calls.

use evaluate::{Candidate, Evaluate, Evaluation};
use ingest::LogFile;
use residual::{ResidualTable, Residuals};
use solve::Solve;
use stage::Run;
use sysid::{Fit, Sysid};
use train::{CurvePoint, LearningCurve, Settings, Train, Trained};
use values::{Reject, Rig, Split, Strike};
use world::{Solution, World};

use crate::inputs::Inputs;
use crate::noise::noise;
use crate::{Error, publishing, reading};

/// How far to go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Step {
    /// Strikes from logs.
    Ingest,
    /// The identified world.
    Sysid,
    /// Every path solved backwards in it.
    Solve,
    /// What the world still gets wrong.
    Residual,
    /// A network that knows it.
    Train,
    /// Stop errors on held-out strikes.
    Evaluate,
    /// A version for the executor.
    Publish,
}

/// What came of the steps that were gone.
#[derive(Clone, Debug, Default)]
pub struct Results {
    /// Strikes kept, in order of time.
    pub strikes: Vec<Strike>,
    /// Strikes seen and not kept.
    pub rejects: Vec<Reject>,
    /// The logs, by name and hash.
    pub logs: Vec<LogFile>,
    /// Names of logs that are cut off or damaged.
    pub damaged: Vec<String>,
    /// What a person should know of the logs.
    pub log_notes: Vec<String>,
    /// From [`Step::Sysid`] on.
    pub fit: Option<Fit>,
    /// From [`Step::Solve`] on, one a strike.
    pub solutions: Vec<Solution>,
    /// From [`Step::Residual`] on.
    pub residuals: ResidualTable,
    /// From [`Step::Train`] on; none where there are too few strikes to train on.
    pub trained: Option<Trained>,
    /// From [`Step::Train`] on.
    pub curve: Vec<CurvePoint>,
    /// From [`Step::Evaluate`] on.
    pub evaluation: Option<Evaluation>,
    /// Mean stop error in m by the number of strikes learnt from; from [`Step::Evaluate`] on.
    pub curve_errors: Vec<(usize, f64)>,
    /// The version published; from [`Step::Publish`] on.
    pub version: Option<String>,
}

/// Goes through the steps up to and with `last`; each answers from the run's cache where nothing changed.
pub fn pipeline(run: &Run, inputs: &Inputs, last: Step) -> Result<Results, Error> {
    let Inputs { rig, seed, .. } = inputs;

    let read = reading::read(run, rig, &inputs.logs, *seed)?;
    let mut results = Results {
        strikes: read.strikes,
        rejects: read.rejects,
        logs: read.logs,
        damaged: read.damaged,
        log_notes: read.notes,
        ..Results::default()
    };
    if last < Step::Sysid {
        return Ok(results);
    }
    let strikes = &results.strikes;

    let fit = identify(run, rig, strikes)?;
    let world = fit.world.clone();
    results.fit = Some(fit);
    if last < Step::Solve {
        return Ok(results);
    }

    let shared = solve::Shared {
        rig: rig.clone(),
        world: world.clone(),
    };
    let paths: Vec<solve::Path> = strikes.iter().map(solve::Path::from).collect();
    results.solutions = run.items(&Solve::default(), &shared, &paths)?;
    if last < Step::Residual {
        return Ok(results);
    }

    let solved = (strikes.clone(), results.solutions.clone());
    results.residuals = run.stage(&Residuals::default(), &solved)?;
    if last < Step::Train {
        return Ok(results);
    }

    let settings = Settings {
        seed: *seed,
        ..Settings::default()
    };
    let rows = &results.residuals.rows;
    let train = Train {
        settings: settings.clone(),
    };
    results.trained = run.stage(&train, rows)?;
    let learning_curve = LearningCurve {
        settings,
        ..LearningCurve::default()
    };
    results.curve = run.stage(&learning_curve, rows)?;
    if last < Step::Evaluate {
        return Ok(results);
    }

    let judges: Vec<Strike> = strikes
        .iter()
        .filter(|strike| strike.split == Split::Test)
        .cloned()
        .collect();
    let noise = noise(rig, &world, results.trained.as_ref(), rows);
    let judge = |candidates: Vec<Candidate>| {
        let input = evaluate::Input {
            rig: rig.clone(),
            strikes: judges.clone(),
            candidates,
            noise,
        };
        run.stage(&Evaluate::default(), &input)
    };
    let evaluation = judge(models(rig, &world, results.trained.as_ref()))?;
    let curve = judge(curve_candidates(&world, &results.curve))?;
    results.curve_errors = results
        .curve
        .iter()
        .filter_map(|point| {
            let error = curve.models.get(&point.strikes.to_string())?;
            Some((point.strikes, error.mean))
        })
        .collect();
    results.evaluation = Some(evaluation);
    if last < Step::Publish {
        return Ok(results);
    }

    results.version = Some(publishing::publish(run, inputs, &results)?);
    Ok(results)
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
        stage::RunError::Stage(error @ sysid::SysidError::TooFewStrikes { .. }) => {
            Error::input(error)
        }
        error => error.into(),
    })
}

/// The models that are compared, the plainest first.
pub fn models(rig: &Rig, world: &World, trained: Option<&Trained>) -> Vec<Candidate> {
    let candidate = |name: &str, world: &World, trained: Option<&Trained>| Candidate {
        name: name.into(),
        world: world.clone(),
        residual: trained.map(|trained| trained.network.clone()),
    };
    let mut models = vec![
        candidate("nominal", &World::nominal(rig), None),
        candidate("sysid", world, None),
    ];
    if trained.is_some() {
        models.push(candidate("sysid_residual", world, trained));
    }
    models
}

/// The network of each point of the curve, named by its number of strikes.
fn curve_candidates(world: &World, curve: &[CurvePoint]) -> Vec<Candidate> {
    curve
        .iter()
        .map(|point| Candidate {
            name: point.strikes.to_string(),
            world: world.clone(),
            residual: Some(point.trained.network.clone()),
        })
        .collect()
}
