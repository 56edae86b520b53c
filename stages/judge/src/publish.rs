//! Puts together what a version holds: worlds, residuals, and the record of how they came to be.
//!
//! The stage computes the [`Contents`] alone; [`Store::publish`](store::Store::publish) makes them a version. The
//! record holds neither time nor place, and logs in the order of their names, so that the same inputs give the same
//! version whatever way they were named.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use stage::{Progress, Record, Stage};
use store::{
    Calibrated, Contents, InputFile, Logged, Model, Provenance, StageRecord, TrainedRegion,
    TrainingExtent,
};
use values::{Rig, Split, StopErrors, Strike};
use world::Varies;

/// The stage.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Publish {
    /// The model to use unless another is asked for; none means the input's best.
    pub default_model: Option<Model>,
    /// Whether effects that the data name were kept out of the world on request; a rebuild does the same.
    pub without_effects: bool,
    /// Where everything random came from, by what it was drawn for.
    pub seeds: BTreeMap<String, u64>,
}

/// What the stage computes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Input {
    /// The set-up.
    pub rig: Rig,
    /// The strikes that were kept; those of [`Split::Train`] bound the trained region.
    pub strikes: Vec<Strike>,
    /// The identified world and its residual.
    pub sysid: Calibrated,
    /// The world with the effects that the data named, and its residual.
    pub effect: Option<Calibrated>,
    /// Stop errors on held-out strikes, by model.
    pub metrics: BTreeMap<Model, StopErrors>,
    /// What repeats of one command scatter by.
    pub noise_floor: Option<StopErrors>,
    /// The model that predicts best what it did not learn from, among the training strikes: held-out strikes, which judge, do not choose.
    pub best: Model,
    /// What the training of each residual explains.
    pub explained: BTreeMap<Model, TrainingExtent>,
    /// How the table varies beside each model.
    pub varies: BTreeMap<Model, Varies>,
    /// The logs that everything was computed from.
    pub logs: Vec<InputFile>,
    /// The stages that computed it, in order.
    pub stages: Vec<StageRecord>,
}

/// Why nothing can be published. Texts complete "failed to …".
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PublishError {
    /// No strike was learnt from.
    #[error(
        "bound the trained region: none of {strikes} strikes is for training; log more strikes"
    )]
    NothingLearnt {
        /// Strikes kept.
        strikes: usize,
    },
    /// The default model is not among those that the version holds.
    #[error("make {model} the default model: the version holds [{has}]")]
    NoModel {
        /// The model.
        model: Model,
        /// Models that it holds.
        has: String,
    },
}

impl Stage for Publish {
    const NAME: &'static str = "publish";
    const VERSION: u32 = 4;
    type Input = Input;
    type Output = Contents;
    type Error = PublishError;

    fn run(&self, input: &Input, _: &Progress) -> Result<Contents, PublishError> {
        let mut contents = Contents {
            rig: input.rig.clone(),
            sysid: input.sysid.clone(),
            effect: input.effect.clone(),
            provenance: Provenance {
                default_model: input.best,
                metrics: input.metrics.clone(),
                noise_floor: input.noise_floor,
                explained: input.explained.clone(),
                varies: input.varies.clone(),
                trained_region: trained_region(&input.strikes)?,
                strikes: Some(logged(&input.strikes)),
                moved: None,
                without_effects: self.without_effects,
                seeds: self.seeds.clone(),
                inputs: in_order(&input.logs),
                stages: input.stages.clone(),
            },
        };
        if let Some(model) = self.default_model {
            contents.provenance.default_model = model;
        }
        let (model, has) = (contents.provenance.default_model, contents.models());
        if has.contains(&model) {
            Ok(contents)
        } else {
            let has = has
                .iter()
                .map(|model| model.name())
                .collect::<Vec<_>>()
                .join(", ");
            Err(PublishError::NoModel { model, has })
        }
    }
}

/// How the stages of a run were run, as a manifest keeps it.
pub fn stage_records(records: Vec<Record>) -> Vec<StageRecord> {
    let keep = |Record {
                    name,
                    version,
                    settings,
                }| StageRecord {
        name: name.into(),
        version,
        settings,
    };
    records.into_iter().map(keep).collect()
}

fn trained_region(strikes: &[Strike]) -> Result<TrainedRegion, PublishError> {
    let learnt_from = strikes.iter().filter(|strike| strike.split == Split::Train);
    TrainedRegion::of(learnt_from.map(|strike| (strike.initial, strike.stop))).ok_or(
        PublishError::NothingLearnt {
            strikes: strikes.len(),
        },
    )
}

/// How many strikes there are, and the last one's stamp.
pub fn logged(strikes: &[Strike]) -> Logged {
    let stamps = strikes.iter().map(|strike| strike.t_start);
    Logged {
        count: strikes.len(),
        last: stamps.reduce(f64::max).unwrap_or(0.0),
    }
}

fn in_order(logs: &[InputFile]) -> Vec<InputFile> {
    let mut logs = logs.to_vec();
    logs.sort();
    logs
}

#[cfg(test)]
mod tests {
    use stage::{Options, Run};
    use store::Store;
    use values::{Command, Conditions, Point, Shape, Track};
    use world::World;

    use super::*;

    fn strike(split: Split, stop: Point) -> Strike {
        Strike {
            id: "1f".into(),
            log: "a.mcap".into(),
            index: 0,
            t_start: 0.0,
            initial: Point::new(0.3, 0.0),
            stop,
            command: Command {
                speed: 0.7,
                angle: 0.1,
            },
            track: Track::default(),
            split,
            conditions: Conditions::default(),
            delivered: None,
        }
    }

    fn metrics(mean: f64, failed: usize) -> StopErrors {
        StopErrors {
            mean,
            sd: 0.0,
            median: mean,
            p95: mean,
            n: 10,
            failed,
        }
    }

    fn log(name: &str) -> InputFile {
        InputFile {
            name: name.into(),
            sha256: "00".repeat(32),
            size: 1,
        }
    }

    fn input() -> Input {
        let rig = Rig::demo(Shape::Cylinder);
        Input {
            sysid: Calibrated {
                world: World::nominal(&rig),
                residual: None,
            },
            rig,
            strikes: vec![
                strike(Split::Train, Point::new(0.5, 0.1)),
                strike(Split::Train, Point::new(0.7, -0.2)),
                strike(Split::Test, Point::new(0.9, 0.5)),
            ],
            effect: None,
            metrics: [
                (Model::Nominal, metrics(0.03, 0)),
                (Model::Sysid, metrics(0.01, 0)),
            ]
            .into(),
            noise_floor: None,
            best: Model::Sysid,
            explained: BTreeMap::new(),
            varies: BTreeMap::new(),
            logs: vec![log("b.mcap"), log("a.mcap")],
            stages: vec![StageRecord {
                name: "sysid".into(),
                version: 1,
                settings: serde_json::json!({"b": 1, "a": 0.1}),
            }],
        }
    }

    fn contents(publish: &Publish, input: &Input) -> Result<Contents, PublishError> {
        publish.run(input, &Progress::hidden())
    }

    #[test]
    fn training_strikes_alone_bound_the_region() {
        let region = contents(&Publish::default(), &input())
            .expect("assembles")
            .provenance
            .trained_region;
        assert_eq!((region.stop_x.low, region.stop_x.high), (0.5, 0.7));
        assert_eq!((region.stop_y.low, region.stop_y.high), (-0.2, 0.1));
        assert!((region.distance.low - 0.05_f64.sqrt()).abs() < 1e-12);
        assert!((region.bearing.low + 0.5_f64.atan()).abs() < 1e-12);
        let none = Input {
            strikes: vec![strike(Split::Test, Point::new(0.5, 0.1))],
            ..input()
        };
        assert_eq!(
            contents(&Publish::default(), &none),
            Err(PublishError::NothingLearnt { strikes: 1 })
        );
    }

    #[test]
    fn the_default_is_what_training_strikes_chose_whatever_held_out_strikes_say() {
        let default = |publish: &Publish, input: &Input| {
            contents(publish, input).map(|contents| contents.provenance.default_model)
        };
        let mut lucky = input();
        lucky.metrics.insert(Model::Nominal, metrics(0.001, 0));
        assert_eq!(default(&Publish::default(), &lucky), Ok(Model::Sysid));
        let chosen = Publish {
            default_model: Some(Model::Nominal),
            ..Publish::default()
        };
        assert_eq!(default(&chosen, &input()), Ok(Model::Nominal));
        let absent = Publish {
            default_model: Some(Model::Effect),
            ..Publish::default()
        };
        assert_eq!(
            default(&absent, &input()).expect_err("refused").to_string(),
            "make effect the default model: the version holds [nominal, sysid]"
        );
    }

    #[test]
    fn what_was_cached_publishes_the_same_version_whatever_the_order_of_logs() {
        let dir = tempfile::tempdir().expect("folder");
        let run = Run::open(
            dir.path(),
            Options {
                is_quiet: true,
                ..Options::default()
            },
        )
        .expect("free");
        let store = Store::open(dir.path());
        let publish = |input: &Input| {
            let contents = run.stage(&Publish::default(), input).expect("assembles");
            store.publish(&contents).expect("publishes")
        };
        assert_eq!(publish(&input()), "v0001");
        assert_eq!(publish(&input()), "v0001");
        let mut other = input();
        other.logs.reverse();
        assert_eq!(publish(&other), "v0001");
        assert_eq!(
            store.load(None).expect("whole").manifest.provenance.inputs,
            [log("a.mcap"), log("b.mcap")]
        );
        let records = stage_records(run.records());
        assert_eq!(
            (records[0].name.as_str(), records[0].version),
            ("publish", Publish::VERSION)
        );
    }
}
