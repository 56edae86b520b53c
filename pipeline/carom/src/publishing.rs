//! The last step: what was computed becomes a version.

use std::collections::BTreeMap;
use std::path::Path;

use evaluate::Evaluation;
use ingest::LogFile;
use publish::Publish;
use stage::Run;
use store::{ArtifactError, Calibrated, Contents, InputFile, Model, Store, TrainingExtent};
use train::Learned;
use values::StopErrors;

use crate::Error;
use crate::inputs::Inputs;
use crate::results::{Results, WorldResults};
use crate::varying::varies;

/// Versions of what computes below the stages: part of every key, so that another engine's answers are not used.
pub fn engine() -> String {
    format!(
        "carom {}, MuJoCo {}",
        env!("CARGO_PKG_VERSION"),
        world::mujoco_version()
    )
}

/// What a version of these results holds.
pub fn contents(run: &Run, inputs: &Inputs, results: &Results) -> Result<Contents, Error> {
    let (Some(sysid), Some(evaluation)) = (&results.sysid, &results.evaluation) else {
        return Err(Error::failed(
            "publish: identification or evaluation is missing",
        ));
    };
    let stage = Publish {
        default_model: None,
        without_effects: inputs.without_effects,
        seeds: [SPLIT_SEED, "train"]
            .map(|name| (name.to_string(), inputs.seed))
            .into(),
    };
    Ok(run.stage(
        &stage,
        &publish::Input {
            rig: inputs.rig.clone(),
            strikes: results.strikes.clone(),
            sysid: calibrated(sysid),
            effect: results.effect.as_ref().map(calibrated),
            metrics: metrics(evaluation, results),
            noise_floor: evaluation.noise_floor,
            best: best_model(results),
            explained: explained(results),
            varies: varies(run, &inputs.rig, results)?,
            logs: input_files(&results.logs)?,
            stages: publish::stage_records(run.records()),
        },
    )?)
}

/// Publishes what the results hold for that, if they do, and gives the version's name; a candidate is kept and not put to use. Contents
/// that are published already make no new version.
pub fn publish(
    store: &Store,
    results: &Results,
    is_candidate: bool,
) -> Result<Option<String>, Error> {
    let contents = results.contents.as_ref();
    let version = contents.map(|contents| match is_candidate {
        true => store.keep_candidate(contents),
        false => store.publish(contents),
    });
    version.transpose().map_err(store_error)
}

fn calibrated(of_world: &WorldResults) -> Calibrated {
    Calibrated {
        world: of_world.world.clone(),
        residual: of_world
            .learned
            .as_ref()
            .and_then(|learned| learned.model.clone()),
    }
}

/// The model that predicts best what it did not learn from, among the training strikes: held-out ones have no part in it.
pub fn best_model(results: &Results) -> Model {
    let worlds = [
        (&results.sysid, Model::Sysid, Model::SysidResidual),
        (&results.effect, Model::Effect, Model::EffectResidual),
    ];
    let (models, learned): (Vec<Model>, Vec<&Learned>) = worlds
        .into_iter()
        .filter_map(|(of_world, plain, residual)| {
            let learned = of_world.as_ref()?.learned.as_ref()?;
            let has_residual = learned.model.is_some();
            Some((if has_residual { residual } else { plain }, learned))
        })
        .unzip();
    train::best(&learned).map_or(Model::Sysid, |place| models[place])
}

/// What the training of each residual explains.
fn explained(results: &Results) -> BTreeMap<Model, TrainingExtent> {
    let worlds = [
        (&results.sysid, Model::SysidResidual),
        (&results.effect, Model::EffectResidual),
    ];
    let explained = worlds.into_iter().filter_map(|(of_world, model)| {
        let explained = of_world.as_ref()?.learned.as_ref()?.explained?;
        Some((model, explained))
    });
    explained.collect()
}

/// Under which name a manifest records the seed of a run.
pub const SPLIT_SEED: &str = "split";

/// A store's error with the exit code that it has.
pub fn store_error(error: ArtifactError) -> Error {
    match error {
        ArtifactError::Busy { .. } => Error::Busy(error.into()),
        ArtifactError::Io(_) => Error::failed(error),
        error => Error::input(error),
    }
}

/// Of the models that the version holds: a residual that adds nothing is none of them.
fn metrics(evaluation: &Evaluation, results: &Results) -> BTreeMap<Model, StopErrors> {
    let is_held = |model: &Model| {
        let of_world = match model {
            Model::SysidResidual => &results.sysid,
            Model::EffectResidual => &results.effect,
            _ => return true,
        };
        let learned = of_world
            .as_ref()
            .and_then(|of_world| of_world.learned.as_ref());
        learned.is_some_and(|learned| learned.model.is_some())
    };
    let models = evaluation.models.iter();
    models
        .filter_map(|(name, errors)| Some((Model::from_name(name)?, *errors)))
        .filter(|(model, _)| is_held(model))
        .collect()
}

/// The logs of a run, as a manifest names them.
pub fn input_files(logs: &[LogFile]) -> Result<Vec<InputFile>, Error> {
    let file = |log: &LogFile| {
        let size = size(&log.path)?;
        Ok(InputFile {
            name: log.name.clone(),
            sha256: log.sha256.clone(),
            size,
        })
    };
    let mut files = logs.iter().map(file).collect::<Result<Vec<_>, Error>>()?;
    files.sort();
    Ok(files)
}

fn size(path: &Path) -> Result<u64, Error> {
    std::fs::metadata(path)
        .map(|metadata| metadata.len())
        .map_err(|error| Error::unreadable(path, &error))
}
