//! The last step: what was computed becomes a version.

use std::collections::BTreeMap;

use ingest::LogFile;
use judge::{Evaluation, Observe};
use stage::{Record, Run};
use store::{
    ArtifactError, Calibrated, Contents, InputFile, Logged, Model, Provenance, StageRecord, Store,
    TrainedRegion,
};
use strike::SESSION_GAP;
use train::Learned;
use values::{Rig, Split, StopErrors, Strike};
use world::{Session, Varies};

use crate::Error;
use crate::fetching::object_error;
use crate::inputs::Inputs;
use crate::results::{Results, WorldResults, Worlds};

/// Versions of what computes below the stages: part of every key, so that another engine's answers are not used.
pub fn engine() -> String {
    format!(
        "carom {}, MuJoCo {}",
        env!("CARGO_PKG_VERSION"),
        world::mujoco_version()
    )
}

/// What a version of these results holds. The record holds neither time nor place, and logs in the order of their names, so that the same
/// inputs give the same version whatever way they were named.
pub fn contents(
    run: &Run,
    inputs: &Inputs,
    results: &Results,
    worlds: &Worlds,
) -> Result<Contents, Error> {
    let evaluation = worlds.evaluation.as_ref();
    let evaluation = evaluation.ok_or_else(|| Error::failed("publish: no model was evaluated"))?;
    let varies = varies(run, &inputs.rig, results, worlds)?;
    let calibrated = |of_world: &WorldResults| Calibrated {
        world: of_world.world.clone(),
        residual: of_world.residual().cloned(),
    };
    let explained = worlds.each().filter_map(|(name, of_world)| {
        let explained = of_world.learned.as_ref()?.explained?;
        Some((name.with_residual(), explained))
    });
    Ok(Contents {
        rig: inputs.rig.clone(),
        sysid: calibrated(&worlds.sysid),
        effect: worlds.effect.as_ref().map(calibrated),
        provenance: Provenance {
            default_model: best_model(worlds),
            metrics: metrics(evaluation, worlds),
            noise_floor: evaluation.noise_floor,
            explained: explained.collect(),
            varies,
            trained_region: trained_region(&results.strikes)?,
            strikes: Some(logged(&results.strikes)),
            moved: None,
            without_effects: inputs.without_effects,
            seeds: [SPLIT_SEED, "train"]
                .map(|name| (name.to_string(), inputs.seed))
                .into(),
            inputs: input_files(&results.read.logs)?,
            stages: run.records().into_iter().map(stage_record).collect(),
        },
    })
}

/// How a stage was run, as a manifest keeps it.
fn stage_record(record: Record) -> StageRecord {
    StageRecord {
        name: record.name.into(),
        version: record.version,
        settings: record.settings,
    }
}

/// The strikes that learn bound the trained region.
fn trained_region(strikes: &[Strike]) -> Result<TrainedRegion, Error> {
    let learnt_from = strikes.iter().filter(|strike| strike.split == Split::Train);
    let region = TrainedRegion::of(learnt_from.map(|strike| (strike.initial, strike.stop)));
    region.ok_or_else(|| {
        Error::failed(format!(
            "bound the trained region: none of {} strikes is for training; log more strikes",
            strikes.len()
        ))
    })
}

/// Number of strikes, and the last one's stamp.
pub fn logged(strikes: &[Strike]) -> Logged {
    let stamps = strikes.iter().map(|strike| strike.t_start);
    Logged {
        count: strikes.len(),
        last: stamps.reduce(f64::max).unwrap_or(0.0),
    }
}

/// Publishes what the results hold for that, if they do, and gives the version's name; a candidate is kept and not put to use. Contents
/// that are published already make no new version.
pub fn publish(
    store: &Store,
    results: &Results,
    is_candidate: bool,
) -> Result<Option<String>, Error> {
    let version = results.version().map(|version| match is_candidate {
        true => store.keep_candidate(&version.contents),
        false => store.publish(&version.contents),
    });
    version.transpose().map_err(store_error)
}

/// The model that predicts best what it did not learn from, among the training strikes: held-out ones have no part in it.
pub fn best_model(worlds: &Worlds) -> Model {
    let learned = worlds.each().filter_map(|(name, of_world)| {
        let learned = of_world.learned.as_ref()?;
        let has_residual = learned.model.is_some();
        Some((
            if has_residual {
                name.with_residual()
            } else {
                name
            },
            learned,
        ))
    });
    let (models, learned): (Vec<Model>, Vec<&Learned>) = learned.unzip();
    train::best(&learned).map_or(Model::Sysid, |place| models[place])
}

/// Under which name a manifest records the seed of a run.
pub const SPLIT_SEED: &str = "split";

/// A store's error with the exit code that it has.
pub fn store_error(error: ArtifactError) -> Error {
    match error {
        ArtifactError::Busy { .. } => Error::Busy(error.into()),
        ArtifactError::Object(error) => object_error(error),
        ArtifactError::Io(_) => Error::failed(error),
        error => Error::input(error),
    }
}

/// Stop errors of the models that the version holds: a residual that adds nothing is none of them.
fn metrics(evaluation: &Evaluation, worlds: &Worlds) -> BTreeMap<Model, StopErrors> {
    let without: Vec<Model> = worlds
        .each()
        .filter(|(_, of_world)| of_world.residual().is_none())
        .map(|(name, _)| name.with_residual())
        .collect();
    let models = evaluation.models.iter();
    models
        .filter_map(|(name, errors)| Some((Model::from_name(name)?, *errors)))
        .filter(|(model, _)| !without.contains(model))
        .collect()
}

/// The logs of a run, as a manifest names them.
pub fn input_files(logs: &[LogFile]) -> Result<Vec<InputFile>, Error> {
    let file = |log: &LogFile| {
        let size = logs::part::size(&log.path);
        let size = size.map_err(|error| Error::unreadable(&log.path, &error))?;
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

/// The latest so many strikes say how a table varies: enough to know scatter to a twentieth.
const MOST: usize = 240;
/// A log of fewer strikes is none of a session's own: an executor writes one for each strike.
const LEAST_OF_A_LOG: usize = 3;

/// Beside every model of the results that learnt from strikes.
pub fn varies(
    run: &Run,
    rig: &Rig,
    results: &Results,
    worlds: &Worlds,
) -> Result<BTreeMap<Model, Varies>, Error> {
    let learnt_from = |strike: &&Strike| strike.split != Split::Test;
    let learnt_from: Vec<&Strike> = results.strikes.iter().filter(learnt_from).collect();
    let latest = &learnt_from[learnt_from.len().saturating_sub(MOST)..];
    let latest: Vec<Strike> = latest.iter().map(|strike| (*strike).clone()).collect();
    let sessions = sessions(&latest);
    let mut varies = BTreeMap::new();
    for (name, of_world) in worlds.each() {
        let plain = std::iter::once((name, None));
        let residual = of_world.residual();
        for (name, residual) in plain.chain(residual.map(|r| (name.with_residual(), Some(r)))) {
            let seen = run.items(&Observe, &of_world.model(rig, residual), &latest)?;
            let mut of_sessions =
                vec![Session::default(); sessions.iter().max().map_or(0, |last| last + 1)];
            for ((strike, seen), session) in latest.iter().zip(seen).zip(&sessions) {
                if let Some(seen) = seen {
                    of_sessions[*session]
                        .0
                        .push((strike.conditions.order, seen));
                }
            }
            varies.insert(name, Varies::of(&of_world.world, &of_sessions));
        }
    }
    Ok(varies)
}

/// The number of each strike's session, rising; the strikes are in the order of time.
fn sessions(strikes: &[Strike]) -> Vec<usize> {
    let mut sizes: BTreeMap<&str, usize> = BTreeMap::new();
    for strike in strikes {
        *sizes.entry(&strike.log).or_default() += 1;
    }
    let is_large = |strike: &Strike| sizes[strike.log.as_str()] >= LEAST_OF_A_LOG;
    let mut session = 0;
    let mut numbers = Vec::with_capacity(strikes.len());
    for (place, strike) in strikes.iter().enumerate() {
        if let Some(before) = place.checked_sub(1).map(|before| &strikes[before]) {
            let is_later = strike.t_start - before.t_start > SESSION_GAP;
            let is_other = strike.log != before.log && (is_large(strike) || is_large(before));
            session += usize::from(is_later || is_other);
        }
        numbers.push(session);
    }
    numbers
}

#[cfg(test)]
mod tests {
    use values::{Command, Point};

    use super::*;

    #[test]
    fn a_log_is_a_session_unless_it_holds_a_strike_alone() {
        let strike = |(log, t_start): &(&str, f64)| Strike {
            log: (*log).into(),
            t_start: *t_start,
            ..Strike::bare(Command::new(1.0, 0.0), Point::default(), Point::default())
        };
        let made = [
            ("monday", 0.0),
            ("monday", 5.0),
            ("monday", 10.0),
            ("strike_1", 60.0),
            ("strike_2", 70.0),
            ("strike_3", 70.0 + 1.1 * SESSION_GAP),
        ];
        let strikes: Vec<Strike> = made.iter().map(strike).collect();
        assert_eq!(sessions(&strikes), [0, 0, 0, 1, 1, 2]);
    }
}
