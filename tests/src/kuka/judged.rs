//! One fold: the steps of a run on what is not held out, and the stop errors of every model on what is.

use std::collections::BTreeMap;

use diagnose::Diagnose;
use judge::{HeldOut, Model, Path, Solve, predict, residuals};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use stage::{ItemStage, Progress, Stage};
use store::ResidualModel;
use sysid::Sysid;
use train::{Kind, Learned, Settings, best, examples, learn};
use values::{Rig, Split, Strike, split_of};
use world::World;

/// Names of the models, the plainest first; `default` is the one that the training strikes choose.
pub const MODELS: [&str; 6] = [
    "nominal",
    "sysid",
    "sysid_residual",
    "effect",
    "effect_residual",
    "default",
];

#[derive(Clone, Debug)]
pub struct Judged {
    pub fold: Fold,
    /// Stop errors in m of each of [`MODELS`], a held-out strike each; none where a model predicts no stop.
    pub errors: BTreeMap<&'static str, Vec<Option<f64>>>,
    pub named: Vec<String>,
    /// What is added to the identified world, and to the one with effects.
    pub added: [Kind; 2],
}

/// Learns from all strikes but those held out, with the splits that a run would give them, and judges by those.
pub fn judge(rig: &Rig, strikes: &[Strike], fold: &Fold) -> anyhow::Result<Judged> {
    let (mut known, mut held_out) = (Vec::new(), Vec::new());
    for (place, strike) in strikes.iter().enumerate() {
        if fold.held_out.contains(&place) {
            held_out.push(Strike {
                split: Split::Test,
                ..strike.clone()
            });
        } else {
            let split = split_of(&strike.id, fold.seed);
            known.push(Strike {
                split,
                ..strike.clone()
            });
        }
    }
    let progress = Progress::hidden();
    let fit = Sysid::default().run(
        &sysid::Input {
            rig: rig.clone(),
            world: World::nominal(),
            strikes: known.clone(),
            later: Vec::new(),
        },
        &progress,
    )?;
    let diagnose = Diagnose {
        seed: fold.seed,
        ..Diagnose::default()
    };
    let found = diagnose.run(
        &diagnose::Input::of(rig.clone(), fit.world.clone(), known.clone()),
        &progress,
    )?;
    let settings = Settings {
        seed: fold.seed,
        ..Settings::default()
    };
    let sysid = learned(rig, &fit.world, &known, &settings)?;
    let effect = match found.used() {
        Some(world) => Some((world.clone(), learned(rig, world, &known, &settings)?)),
        None => None,
    };

    let judges: Vec<HeldOut> = held_out.iter().map(HeldOut::from).collect();
    let errors =
        |world: &World, residual: Option<&ResidualModel>| errors(rig, world, residual, &judges);
    let mut all = BTreeMap::new();
    all.insert("nominal", errors(&World::nominal(), None)?);
    all.insert("sysid", errors(&fit.world, None)?);
    all.insert("sysid_residual", errors(&fit.world, sysid.model.as_ref())?);
    let (world, with_effects) = match &effect {
        Some((world, learned)) => (world, learned),
        None => (&fit.world, &sysid),
    };
    all.insert("effect", errors(world, None)?);
    all.insert(
        "effect_residual",
        errors(world, with_effects.model.as_ref())?,
    );
    let default = match best(&[&sysid, with_effects]) {
        Some(1) => "effect_residual",
        _ => "sysid_residual",
    };
    all.insert("default", all[default].clone());
    Ok(Judged {
        fold: fold.clone(),
        errors: all,
        named: found
            .diagnosis
            .effects
            .iter()
            .map(|effect| effect.name.clone())
            .collect(),
        added: [sysid.kind, with_effects.kind],
    })
}

fn learned(
    rig: &Rig,
    world: &World,
    strikes: &[Strike],
    settings: &Settings,
) -> anyhow::Result<Learned> {
    let progress = Progress::hidden();
    let paths: Vec<Path> = strikes.iter().map(Path::from).collect();
    let solved = Solve::default().run_items(
        &Model::of_world(rig, world),
        &paths.iter().collect::<Vec<_>>(),
        &progress,
    )?;
    let residuals = residuals(strikes.iter().zip(solved.iter().map(|path| &path.solution)));
    let launches = solved.iter().map(|path| path.launch);
    let examples = examples(strikes.iter().zip(launches), &residuals.rows);
    Ok(learn(&examples, settings, &|_| {})?)
}

fn errors(
    rig: &Rig,
    world: &World,
    residual: Option<&ResidualModel>,
    judges: &[HeldOut],
) -> anyhow::Result<Vec<Option<f64>>> {
    let simulator = ResidualModel::simulator(rig, world, residual)?;
    let mut worker = simulator.worker();
    let networks = residual.and_then(ResidualModel::networks);
    let error = |judge: &HeldOut| {
        let predicted = predict(&mut worker, networks, judge);
        predicted.stop.map(|stop| stop.distance(judge.stop))
    };
    Ok(judges.iter().map(error).collect())
}

const PARTS: usize = 5;

/// Strikes that are held out together, by their place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fold {
    /// The deal that it belongs to; what is random in learning follows from it, too.
    pub seed: u64,
    /// What is held out, by place.
    pub held_out: Vec<usize>,
    pub name: String,
}

/// Five folds by setting: strikes of one commanded speed and angle, to a hundredth of both, stay together.
pub fn setting_folds(strikes: &[Strike], seed: u64) -> Vec<Fold> {
    let hundredths = |value: f64| (100.0 * value).round() as i64;
    let mut settings: BTreeMap<(i64, i64), Vec<usize>> = BTreeMap::new();
    for (place, strike) in strikes.iter().enumerate() {
        let setting = (
            hundredths(strike.command.speed),
            hundredths(strike.command.angle),
        );
        settings.entry(setting).or_default().push(place);
    }
    let mut groups: Vec<Vec<usize>> = settings.into_values().collect();
    groups.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    (0..PARTS)
        .map(|part| {
            let mut held_out: Vec<usize> = groups
                .iter()
                .skip(part)
                .step_by(PARTS)
                .flatten()
                .copied()
                .collect();
            held_out.sort_unstable();
            Fold {
                seed,
                held_out,
                name: format!("settings {part}"),
            }
        })
        .collect()
}

/// Two folds by session: a and a2, whose boxes were measured as high, against b.
pub fn session_folds(strikes: &[Strike], seed: u64) -> Vec<Fold> {
    ["session_a", "session_b"]
        .into_iter()
        .map(|session| Fold {
            seed,
            held_out: (0..strikes.len())
                .filter(|place| strikes[*place].conditions.session.starts_with(session))
                .collect(),
            name: session.into(),
        })
        .collect()
}
