//! Diagnosis: where the calibrated world and the measured strikes disagree, which physical effect is missing, and how far
//! the gap shrinks with it.
//!
//! The strike is the unit of evidence: its launch scatters, so a whole track is worth far less than its frames ([`mixed`]).
//! What else a table and a camera scatter by is estimated first ([`noise`], [`null`]).
//! Worlds are tried in planar form ([`world::planar`]), which follows MuJoCo's to a twentieth of a millimetre, a hundred times as
//! fast. Whether: score tests of every candidate, against residuals drawn from the fitted world and its noise, confirmed by
//! flipped signs of whole strikes ([`evidence`]). Which: fits of the best candidates, forward, replaced and dropped again
//! ([`search`]); what they name must predict strikes that took no part ([`heldout`]). None of these: what smooth dependences
//! still find beside the best model ([`smooth`], [`maps`]). The gap is judged in MuJoCo ([`gap`]).

mod arm;
mod candidates;
mod conclude;
mod diagnosis;
mod evidence;
mod fit;
mod fitted_world;
mod gap;
mod heldout;
mod linearisation;
mod maps;
mod mixed;
mod model;
mod next;
mod noise;
mod notes;
mod null;
mod score;
mod screen;
mod search;
mod sessions;
mod smooth;
mod strikes;
mod words;

pub use diagnosis::{
    Detectable, Diagnosis, Gap, Look, MapPoint, Named, NextStrike, Noise, Parameter, Ranked,
    SmoothMap, Verdict, Where,
};

use serde::{Deserialize, Serialize};
use stage::{Progress, Stage};
use values::{Command, Rig, Shape, Split, Strike};
use world::{World, WorldError, launch::launches};

use crate::{
    arm::Arm,
    candidates::{Candidate, candidates},
    conclude::{Case, Left},
    evidence::{Alarm, Statistic, replicates},
    fit::ITERATIONS,
    heldout::Gains,
    score::ScoreTest,
    screen::{Chance, screen_by},
    search::{Limits, Selection, search, without},
    smooth::{Dependence, covariate::family, dependences, dependences_of},
    strikes::PreparedStrikes,
};

/// How to diagnose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Diagnose {
    /// Strikes that fit and choose, at most this many.
    pub most_strikes: usize,
    /// Effects that may be added.
    pub most_effects: usize,
    /// Strikes proposed at the most.
    pub next_strikes: usize,
    /// Seeds the bootstrap.
    pub seed: u64,
}

impl Default for Diagnose {
    fn default() -> Self {
        Self {
            most_strikes: 120,
            most_effects: 5,
            next_strikes: 12,
            seed: 0,
        }
    }
}

impl Diagnose {
    /// The strikes that it looks at, in their order: a sample over all sessions that fits and chooses, and all that judge. The
    /// sample is those of the smallest ids, which are hashes: as data grows, few strikes enter it.
    pub fn sample(&self, strikes: &[Strike]) -> Vec<Strike> {
        let is_judge = |strike: &Strike| strike.split == Split::Test;
        let mut ids: Vec<&str> = strikes
            .iter()
            .filter(|strike| !is_judge(strike))
            .map(|strike| strike.id.as_str())
            .collect();
        ids.sort_unstable();
        let last = ids.get(self.most_strikes).copied();
        strikes
            .iter()
            .filter(|strike| is_judge(strike) || last.is_none_or(|last| strike.id.as_str() < last))
            .cloned()
            .collect()
    }
}

/// What to look at.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Input {
    /// The rig.
    pub rig: Rig,
    /// The identified world, without effects.
    pub world: World,
    /// Strikes in order of time; those of [`Split::Test`] judge the gap and take no other part.
    pub strikes: Vec<Strike>,
}

/// What was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// For people and files.
    pub diagnosis: Diagnosis,
    /// The identified world with the effects named, its parameters fitted again; none where nothing was named.
    pub world: Option<World>,
    /// Each strike's residual, before and after.
    pub looks: Vec<Look>,
}

/// Why there is no diagnosis. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum DiagnoseError {
    /// Too few to fit anything.
    #[error(
        "diagnose {strikes} strikes that may be used for it: at least {needed} are needed; log more strikes"
    )]
    TooFewStrikes {
        /// Strikes that may be used.
        strikes: usize,
        /// Strikes needed.
        needed: usize,
    },
    /// A ball rolls: no slide to look at.
    #[error("diagnose a ball: effects are told from slides, and a ball rolls")]
    Rolls,
    /// The world without effects cannot be fitted to these strikes.
    #[error(
        "diagnose: the world without effects fits none of it ({why}); look at the logs and the rig file"
    )]
    NoFit {
        /// What went wrong.
        why: String,
    },
    /// The world could not be simulated.
    #[error(transparent)]
    World(#[from] WorldError),
}

/// Strikes below which friction, launch and their scatter leave nothing to tell effects by.
const FEWEST: usize = 8;
/// Frames that a track must have.
const FRAMES: usize = 6;

impl Stage for Diagnose {
    const NAME: &'static str = "diagnose";
    const VERSION: u32 = 12;
    type Input = Input;
    type Output = Found;
    type Error = DiagnoseError;

    fn run(&self, input: &Input, progress: &Progress) -> Result<Found, DiagnoseError> {
        if input.rig.object.shape == Shape::Sphere {
            return Err(DiagnoseError::Rolls);
        }
        match Arm::of(input)? {
            Some(arm) => {
                let found = self.diagnose(&arm.input, true, progress)?;
                arm.complete(found, input)
            }
            None => self.diagnose(input, false, progress),
        }
    }
}

impl Diagnose {
    /// The diagnosis of strikes as they were commanded, or as they were delivered, which no effect of the arm explains.
    fn diagnose(
        &self,
        input: &Input,
        is_delivered: bool,
        progress: &Progress,
    ) -> Result<Found, DiagnoseError> {
        let rig = &input.rig;
        progress.set_message("how the object leaves the tip");
        let (usable, pushed_again) = self.usable(input)?;
        let (field, pushed) = prepared(rig, &input.world, &usable)?;

        progress.set_message("the world without effects, and the noise about it");
        let (field, null) = null::fit_null(field, &input.world)?;

        progress.set_message("every candidate by its score");
        let mut candidates = candidates(rig, &field.strikes);
        candidates.retain(|candidate| !(is_delivered && arm::is_the_arms(candidate.name)));
        let replicates = replicates(self.seed);
        let test =
            ScoreTest::new(&field, &null, &[], replicates).ok_or_else(|| DiagnoseError::NoFit {
                why: "friction and restitution cannot be told apart".into(),
            })?;
        let screened = screen_by(&field, &null, &test, &candidates, replicates)?;
        let before = dependences_of(&field, &null, &test)?;
        drop(test);
        let chance = evidence::chance(&screened);
        let p_value = Alarm::new(&Statistic::all(&screened, &before)).p_value();

        progress.set_message("which effects");
        let limits = Limits {
            effects: if p_value.is_real() {
                self.most_effects
            } else {
                0
            },
            replicates,
        };
        let selection = search(&field, &null, &screened, &candidates, &chance, &limits)?;
        let (selection, left) = self.pruned(selection, &candidates, &chance)?;
        let (selection, gains, mut notes) = paying(selection)?;
        notes.extend(notes::left_out(pushed_again, pushed));

        progress.set_message("how far the gap shrinks");
        let maps = if p_value.is_real() {
            maps::maps(&selection.field, &selection.null)?
        } else {
            Vec::new()
        };
        let selection = about_itself(selection, &input.world)?;
        Case {
            stage: self,
            input,
            selection: &selection,
            screened: &screened,
            chance: &chance,
            before: &before,
            left,
            gains,
            p_value,
            maps,
            notes,
        }
        .conclude()
    }
}

impl Diagnose {
    /// The strikes that fit and choose, from where their impact is over; and how many were left out, for their object is pushed
    /// a second time.
    fn usable(&self, input: &Input) -> Result<(Vec<Strike>, usize), DiagnoseError> {
        let frame = 1.0 / input.rig.camera.rate;
        let mut usable: Vec<Strike> = self
            .sample(&input.strikes)
            .iter()
            .filter(|strike| strike.split != Split::Test)
            .map(|strike| strike.after_impact(frame))
            .filter(|strike| strike.track.len() >= FRAMES)
            .collect();
        let tracks = usable.len();
        usable.retain(|strike| !strike.is_pushed_again());
        let again = tracks - usable.len();
        if usable.len() < FEWEST {
            return Err(DiagnoseError::TooFewStrikes {
                strikes: usable.len(),
                needed: FEWEST,
            });
        }
        Ok((usable, again))
    }

    /// Without the effects that are weaker than what no candidate explains, and those whose strength may as well be none; and
    /// what smooth dependences gain beside the rest.
    fn pruned<'a>(
        &self,
        mut selection: Selection<'a>,
        candidates: &[Candidate],
        chance: &Chance,
    ) -> Result<(Selection<'a>, Left), DiagnoseError> {
        while !selection.effects.is_empty() {
            let after = dependences(&selection.field, &selection.fitted, replicates(self.seed))?;
            let left = left(&selection, &after);
            let weak = selection.weaker_than(left.beyond_form);
            let Some(weak) = weak.or_else(|| selection.fitted.unsure()) else {
                return Ok((selection, left));
            };
            selection = without(selection, weak, candidates, chance)?;
        }
        Ok((selection, Left::default()))
    }
}

/// Strikes with their launches, and how many were left out, for their object does not leave the tip.
fn prepared<'a>(
    rig: &'a Rig,
    world: &World,
    usable: &'a [Strike],
) -> Result<(PreparedStrikes<'a>, usize), DiagnoseError> {
    let commands: Vec<Command> = usable.iter().map(|strike| strike.command).collect();
    let (strikes, launches): (Vec<&Strike>, Vec<_>) = usable
        .iter()
        .zip(launches(rig, world, &commands)?)
        .filter_map(|(strike, launch)| Some((strike, launch?)))
        .unzip();
    let pushed = usable.len() - strikes.len();
    if strikes.len() < FEWEST {
        return Err(DiagnoseError::NoFit {
            why: format!("in {pushed} strikes the object does not leave the tip"),
        });
    }
    Ok((PreparedStrikes::new(rig, strikes, launches), pushed))
}

/// What smooth dependences gain beside a model.
fn left(selection: &Selection<'_>, after: &[Dependence]) -> Left {
    let held: Vec<_> = selection
        .effects
        .iter()
        .flat_map(|effect| family(effect.name))
        .collect();
    Left {
        all: evidence::left(after, |_| true),
        beyond_form: evidence::left(after, |covariate| !held.contains(&&covariate)),
    }
}

/// The effects, if together they predict strikes that took no part in their fit; none otherwise, with a sentence that says so.
fn paying(selection: Selection<'_>) -> Result<(Selection<'_>, Gains, Vec<String>), DiagnoseError> {
    if selection.effects.is_empty() {
        return Ok((selection, Gains::default(), Vec::new()));
    }
    let gains = heldout::gains(&selection.field, &selection.null, &selection.fitted)?;
    let (sum, error) = heldout::total(&gains.likelihood);
    if sum > 0.0 {
        return Ok((selection, gains, Vec::new()));
    }
    let names: Vec<&str> = selection.effects.iter().map(|effect| effect.name).collect();
    let why = format!(
        "fitted to four fifths of the strikes, it predicts the others no better: {sum:+.1} ± {error:.1} of log-likelihood"
    );
    let note = notes::not_named(&names, &why);
    let none = Selection {
        fitted: selection.null.clone(),
        effects: Vec::new(),
        ..selection
    };
    Ok((none, gains, vec![note]))
}

/// The same, fitted with launches about its own impacts.
fn about_itself<'a>(
    mut selection: Selection<'a>,
    world: &World,
) -> Result<Selection<'a>, DiagnoseError> {
    let field = selection.field.about(world, &selection.fitted.model)?;
    if !selection.effects.is_empty() {
        let from = &selection.fitted;
        let components = &from.estimated.components;
        if let Some(fitted) = field.fit(&from.model, components, &from.nuisances, ITERATIONS)? {
            selection.fitted = fitted;
        }
    }
    selection.field = field;
    Ok(selection)
}
