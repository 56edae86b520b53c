//! What came of a pipeline's steps.

use diagnose::{Diagnosed, Note, Verdict};
use judge::{Evaluation, ResidualTable, Solved, residuals};
use store::{Contents, Model, ResidualModel};
use sysid::Fit;
use train::{Example, Learned, examples};
use values::{Rig, Sentence, Strike};
use world::World;

use crate::error::Outcome;
use crate::first_version::FirstVersion;
use crate::reading::Read;

/// What came of the steps that were gone.
pub struct Results {
    /// What the logs held.
    pub read: Read,
    /// The strikes kept, in order of time; none where reading was all that was asked for. From solving on those that came to rest.
    pub strikes: Vec<Strike>,
    /// Strikes kept whose track ends before rest, and that `strikes` no longer holds.
    pub without_stop: usize,
    /// What the strikes say; none where reading was all that was asked for, or where a model of the logs would be meaningless.
    pub worlds: Option<Worlds>,
}

/// What strikes say of the world that they were made in.
pub struct Worlds {
    pub fit: Fit,
    pub sysid: WorldResults,
    /// What simulation and strikes disagree in, or why there is no diagnosis; none where none was asked for.
    pub diagnosis: Option<Result<Diagnosed, String>>,
    /// The identified world with the effects named; none where none is named, or they are to be left out.
    pub effect: Option<WorldResults>,
    /// Stop errors on held-out strikes; none where they were not asked for.
    pub evaluation: Option<Evaluation>,
    /// How the error falls with the strikes learnt from, in the world that will be used; empty where nothing was evaluated.
    pub curve: Vec<CurvePoint>,
    /// What is to be published; none where that was not asked for.
    pub version: Option<NewVersion>,
}

/// A world, and what was learnt on top of it.
#[derive(Clone, Debug)]
pub struct WorldResults {
    pub world: World,
    /// What each strike's path needs in it; none where nothing was solved.
    pub solved: Option<SolvedWorld>,
    /// What is added to its commands; none where nothing was learnt.
    pub learned: Option<Learned>,
}

/// Every path solved backwards in a world.
#[derive(Clone, Debug)]
pub struct SolvedWorld {
    /// A strike's place among all, and what it needs; in their order. Of very many strikes these are some (`growth::learnt`).
    pub paths: Vec<(usize, Solved)>,
    /// What the world still gets wrong.
    pub residuals: ResidualTable,
}

/// What was learnt from the earliest strikes.
#[derive(Clone, Debug)]
pub struct CurvePoint {
    /// Number of strikes made, of all splits.
    pub strikes: usize,
    /// What came of them.
    pub learned: Learned,
    /// Mean stop error in m on held-out strikes; none where none is predicted.
    pub error: Option<f64>,
}

impl CurvePoint {
    /// Mean distance in m by which what was learnt misses stops of commands that it did not learn from.
    pub fn held_out_commands(&self) -> Option<f64> {
        let mut scores = self.learned.scores.iter();
        let chosen = scores.find(|score| score.kind == self.learned.kind)?;
        Some(chosen.by_setting)
    }
}

pub struct NewVersion {
    pub contents: Contents,
    /// The gate that it passes where no version is in use.
    pub gate: FirstVersion,
}

impl SolvedWorld {
    /// From what the paths of strikes at these places need.
    pub fn of(strikes: &[Strike], paths: Vec<(usize, Solved)>) -> Self {
        let solutions = paths.iter();
        Self {
            residuals: residuals(
                solutions.map(|(place, solved)| (&strikes[*place], &solved.solution)),
            ),
            paths,
        }
    }
}

impl WorldResults {
    /// A world on top of which nothing is learnt yet.
    pub fn new(world: World) -> Self {
        Self {
            world,
            solved: None,
            learned: None,
        }
    }

    /// What can be learnt from these strikes, the first of all.
    pub fn examples(&self, strikes: &[Strike]) -> Vec<Example> {
        let solved = self.solved.as_ref();
        solved.map_or_else(Vec::new, |solved| {
            let paths = solved.paths.iter();
            let launches =
                paths.filter_map(|(place, path)| Some((strikes.get(*place)?, path.launch)));
            examples(launches, &solved.residuals.rows)
        })
    }

    /// The world, and what is added to it.
    pub fn model(&self, rig: &Rig, residual: Option<&ResidualModel>) -> judge::Model {
        judge::Model {
            residual: residual.cloned(),
            ..judge::Model::of_world(rig, &self.world)
        }
    }

    /// What was learnt to add, where anything is added.
    pub fn residual(&self) -> Option<&ResidualModel> {
        self.learned.as_ref()?.model.as_ref()
    }
}

impl Worlds {
    /// Results of an identified world, and nothing more.
    pub fn new(fit: Fit) -> Self {
        Self {
            sysid: WorldResults::new(fit.world.clone()),
            fit,
            diagnosis: None,
            effect: None,
            evaluation: None,
            curve: Vec::new(),
            version: None,
        }
    }

    /// The worlds with the names of their models, the plainer first.
    pub fn each(&self) -> impl Iterator<Item = (Model, &WorldResults)> {
        let effect = self.effect.iter().map(|effect| (Model::Effect, effect));
        std::iter::once((Model::Sysid, &self.sysid)).chain(effect)
    }

    /// The worlds, the plainer first, to be changed.
    pub fn each_mut(&mut self) -> impl Iterator<Item = &mut WorldResults> {
        std::iter::once(&mut self.sysid).chain(&mut self.effect)
    }

    /// The world that will be used, with the name of its model: the one with effects where they are named.
    pub fn used(&self) -> (Model, &WorldResults) {
        let effect = self.effect.as_ref().map(|effect| (Model::Effect, effect));
        effect.unwrap_or((Model::Sysid, &self.sysid))
    }

    pub fn found(&self) -> Option<&Diagnosed> {
        self.diagnosis.as_ref()?.as_ref().ok()
    }

    /// Why there is no diagnosis, where one was tried.
    pub fn no_diagnosis(&self) -> Option<&str> {
        self.diagnosis.as_ref()?.as_ref().err().map(String::as_str)
    }
}

impl Results {
    /// How the program ends, by what was read.
    pub fn outcome(&self) -> Outcome {
        let read = &self.read;
        let has_no_strike = self.worlds.is_some() && read.strikes.is_empty();
        if read.check.is_meaningless() || self.has_no_stop() || has_no_strike {
            Outcome::Refused
        } else {
            read.outcome()
        }
    }

    /// Whether no strike came to rest: what was identified then is judged by no stop, and not published.
    fn has_no_stop(&self) -> bool {
        self.without_stop > 0 && self.strikes.is_empty()
    }

    /// What to look at on the rig before these results are used.
    pub fn warnings(&self) -> Vec<String> {
        let of_fit = self.worlds.iter().flat_map(|worlds| &worlds.fit.warnings);
        let found = self.found().map(|found| &found.diagnosis);
        let cause = found.and_then(|diagnosis| Some(diagnosis.cause.as_ref()?.to_string()));
        let strays = found.and_then(|diagnosis| Some(diagnosis.strays.as_ref()?.to_string()));
        let strays = strays.filter(|strays| cause.as_ref() != Some(strays));
        let fit = self.worlds.as_ref().map(|worlds| &worlds.fit);
        let is_told_already = fit.is_some_and(|fit| {
            let mut warnings = fit.warnings.iter().map(Sentence::finding);
            warnings.any(|warning| matches!(warning, Some(sysid::Note::StateNotFollowed)))
        });
        let told = found.into_iter().flat_map(|diagnosis| {
            let is_at_rest = diagnosis.verdict == Verdict::Consistent;
            let is_told = move |note: &&Sentence<Note>| match note.finding() {
                Some(Note::AsCommanded) => !is_told_already,
                Some(Note::ValuesHoldTheGap) => is_at_rest,
                _ => false,
            };
            diagnosis.notes.iter().filter(is_told)
        });
        let evaluation = self.evaluation();
        of_fit
            .map(ToString::to_string)
            .chain(without_stop(
                self.without_stop,
                self.strikes.len(),
                self.read.strikes.len(),
            ))
            .chain(cause)
            .chain(strays)
            .chain(told.map(ToString::to_string))
            .chain(evaluation.and_then(worse_than_nominal))
            .chain(evaluation.and_then(unjudged))
            .collect()
    }

    pub fn found(&self) -> Option<&Diagnosed> {
        self.worlds.as_ref()?.found()
    }

    /// Stop errors on held-out strikes, where there are any.
    pub fn evaluation(&self) -> Option<&Evaluation> {
        self.worlds.as_ref()?.evaluation.as_ref()
    }

    /// What is to be published, where there is anything.
    pub fn version(&self) -> Option<&NewVersion> {
        self.worlds.as_ref()?.version.as_ref()
    }
}

/// What to say of tracks that end before rest.
fn without_stop(without: usize, learnt: usize, all: usize) -> Option<String> {
    let rest = match (learnt, all - without) {
        (0, resting) => {
            let who = match resting {
                0 => "no strike comes to rest by itself".into(),
                few => format!("only {few} come to rest by themselves"),
            };
            format!(
                "{who}: errors are those of the place at the track's end, stops can be neither learnt nor aimed at, and nothing is published"
            )
        }
        _ => "the others alone are learnt from and judge stops".into(),
    };
    (without > 0).then(|| {
        format!("{without} of {all} tracks end at a contact, or leave the table: they identify and diagnose up to there; {rest}")
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

/// Results made by hand.
#[cfg(test)]
pub mod testing {
    use values::Shape;

    use super::*;

    /// Results of no strikes, with a diagnosis that names the effects of its world.
    pub fn diagnosed(found: Option<Diagnosed>) -> Results {
        let rig = Rig::demo(Shape::Cylinder);
        let fit = Fit {
            world: World::nominal(),
            freed: Vec::new(),
            strikes: 0,
            rms_before: 0.0,
            rms_after: 0.0,
            iterations: 0,
            simulations: 0,
            warnings: Vec::new(),
            notes: Vec::new(),
        };
        let effect = found.as_ref().and_then(|found| found.used().cloned());
        Results {
            read: Read {
                strikes: Default::default(),
                slides: Vec::new(),
                rejects: Vec::new(),
                logs: Vec::new(),
                images: Default::default(),
                left_out: Vec::new(),
                damaged: Vec::new(),
                notes: Vec::new(),
                check: Default::default(),
                rig,
            },
            strikes: Vec::new(),
            without_stop: 0,
            worlds: Some(Worlds {
                effect: effect.map(WorldResults::new),
                diagnosis: found.map(Ok),
                ..Worlds::new(fit)
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use values::StopErrors;

    use super::*;

    #[test]
    fn tracks_without_a_stop_are_told_as_many_as_they_are() {
        assert_eq!(without_stop(0, 40, 40), None);
        let said = |without, learnt| without_stop(without, learnt, 100).expect("a warning");
        assert!(
            said(30, 70).contains("the others alone"),
            "{}",
            said(30, 70)
        );
        assert!(
            said(90, 0).contains("only 10 come to rest"),
            "{}",
            said(90, 0)
        );
        assert!(
            said(100, 0).contains("no strike comes to rest"),
            "{}",
            said(100, 0)
        );
    }

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
