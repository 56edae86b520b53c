//! What came of a pipeline's steps.

use check::Check;
use diagnose::Diagnosed;
use evaluate::Evaluation;
use ingest::{LogFile, Strikes};
use residual::{LaunchResidual, ResidualTable};
use store::{Contents, Model};
use sysid::Fit;
use train::{CurvePoint, Learned};
use values::{Reject, Rig, Strike};
use world::{Solution, World};

use crate::error::Outcome;
use crate::first_version::FirstVersion;
use crate::left_out::LeftOut;

/// What came of the steps that were gone.
#[derive(Clone, Debug, Default)]
pub struct Results {
    /// Strikes kept, in order of time, as they lie in the cache.
    pub kept: Strikes,
    /// The same, read; from sysid on.
    pub strikes: Vec<Strike>,
    /// Strikes kept whose track ends before rest; from solving on `strikes` holds the others.
    pub without_stop: usize,
    /// Strikes seen and not kept.
    pub rejects: Vec<Reject>,
    /// The logs that were read, by name and hash.
    pub logs: Vec<LogFile>,
    /// Logs that could not be read.
    pub left_out: Vec<LeftOut>,
    /// Names of logs that are cut off or damaged.
    pub damaged: Vec<String>,
    /// Warnings about the logs.
    pub log_notes: Vec<String>,
    /// Whether the logs mean what the rig file says; where a model of them would be meaningless, no further step was gone.
    pub check: Check,
    /// The rig file, with the fences that were found.
    pub rig: Option<Rig>,
    /// From [`Step::Sysid`](crate::pipeline::Step) on.
    pub fit: Option<Fit>,
    /// The identified world; from sysid on.
    pub sysid: Option<WorldResults>,
    /// What simulation and strikes disagree in; from diagnosis on.
    pub found: Option<Diagnosed>,
    /// Why there is no diagnosis, where one was tried.
    pub no_diagnosis: Option<String>,
    /// The identified world with the effects named; none where none is named, or they are to be left out.
    pub effect: Option<WorldResults>,
    /// Networks by the number of strikes learnt from, in the world that will be used; from training on.
    pub curve: Vec<CurvePoint>,
    /// From evaluation on.
    pub evaluation: Option<Evaluation>,
    /// Mean stop error in m by the number of strikes learnt from; from evaluation on.
    pub curve_errors: Vec<(usize, f64)>,
    /// The gate of a version where none is in use; from publishing on.
    pub first_version: Option<FirstVersion>,
    /// What is to be published; from publishing on.
    pub contents: Option<Contents>,
    /// The version published, which is in use unless a rollback took it out; once it is published.
    pub version: Option<String>,
}

/// A world, and what was learnt on top of it.
#[derive(Clone, Debug)]
pub struct WorldResults {
    /// The world.
    pub world: World,
    /// Every path solved backwards in it, one a strike; from solving on.
    pub solutions: Vec<Solution>,
    /// What it still gets wrong; from the residual on.
    pub residuals: ResidualTable,
    /// The launch that each strike shows beside that world's, one a strike; from the residual on.
    pub launches: Vec<Option<LaunchResidual>>,
    /// What is added to its commands; from training on.
    pub learned: Option<Learned>,
}

impl WorldResults {
    /// A world on top of which nothing is learnt yet.
    pub fn new(world: World) -> Self {
        Self {
            world,
            solutions: Vec::new(),
            residuals: ResidualTable::default(),
            launches: Vec::new(),
            learned: None,
        }
    }
}

impl Results {
    /// How the program ends, by what was read.
    pub fn outcome(&self) -> Outcome {
        if self.check.is_meaningless() || self.has_no_stop() {
            Outcome::Refused
        } else if self.rejects.is_empty() && self.damaged.is_empty() && self.left_out.is_empty() {
            Outcome::Done
        } else {
            Outcome::Rejected
        }
    }

    /// Whether no strike came to rest: what was identified then is judged by no stop, and not published.
    fn has_no_stop(&self) -> bool {
        self.without_stop > 0 && self.strikes.is_empty()
    }

    /// What to look at on the rig before these results are used.
    pub fn warnings(&self) -> Vec<String> {
        let of_fit = self.fit.iter().flat_map(|fit| fit.warnings.clone());
        let worse = self.evaluation.as_ref().and_then(worse_than_nominal);
        let unjudged = self.evaluation.as_ref().and_then(unjudged);
        let cause = self
            .found
            .as_ref()
            .and_then(|found| found.diagnosis.cause.clone());
        let without_stop = without_stop(self.without_stop, self.strikes.len());
        of_fit
            .chain(without_stop)
            .chain(cause)
            .chain(worse)
            .chain(unjudged)
            .collect()
    }

    /// The world that will be used, with the name of its model: the one with effects where they are named.
    pub fn used(&self) -> Option<(&'static str, &WorldResults)> {
        let effect = self.effect.as_ref().map(|of_world| ("effect", of_world));
        effect.or_else(|| self.sysid.as_ref().map(|of_world| ("sysid", of_world)))
    }
}

/// What to say of tracks that end before rest.
fn without_stop(without: usize, with: usize) -> Option<String> {
    let rest = match with {
        0 => {
            "no strike comes to rest by itself: errors are those of the place at the track's end, stops can be neither learnt nor aimed at, and nothing is published"
        }
        _ => "the others alone are learnt from and judge stops",
    };
    (without > 0).then(|| {
        format!("{without} of {} tracks end at a contact, or leave the table: they identify and diagnose up to there; {rest}", without + with)
    })
}

/// What to say where no strike was left to judge the models.
fn unjudged(evaluation: &Evaluation) -> Option<String> {
    evaluation.models.values().all(|errors| errors.n == 0).then(|| {
        "no strike was left that took no part in learning: how far these models miss is not known; record more strikes".into()
    })
}

/// What to say of an identified world that misses farther than the nominal one on strikes that took no part; none where it does not.
pub fn worse_than_nominal(evaluation: &Evaluation) -> Option<String> {
    let of = |model: Model| evaluation.models.get(model.name());
    let (nominal, identified) = (of(Model::Nominal)?, of(Model::Sysid)?);
    (identified.mean > nominal.mean).then(|| {
        format!(
            "the identified world misses farther than the nominal one, {:.2} against {:.2} cm on average of {} strikes that took no part",
            identified.mean * 100.0,
            nominal.mean * 100.0,
            identified.n
        )
    })
}

#[cfg(test)]
mod tests {
    use values::StopErrors;

    use super::*;

    #[test]
    fn a_world_that_is_worse_than_the_nominal_one_or_that_nothing_judged_gives_a_warning() {
        let errors = |mean: f64| StopErrors {
            mean,
            ..StopErrors::of([0.1; 4].into_iter()).expect("errors")
        };
        let with = |nominal: f64, identified: f64| Evaluation {
            models: [("nominal", nominal), ("sysid", identified)]
                .map(|(name, mean)| (name.to_owned(), errors(mean)))
                .into(),
            noise_floor: None,
            new_sessions: None,
            predictions: Vec::new(),
        };
        assert!(worse_than_nominal(&with(0.1, 0.2)).is_some());
        assert!(worse_than_nominal(&with(0.2, 0.1)).is_none());
        assert!(unjudged(&with(0.2, 0.1)).is_none());
        let none = Evaluation {
            models: Default::default(),
            ..with(0.2, 0.1)
        };
        assert!(unjudged(&none).is_some());
    }
}
