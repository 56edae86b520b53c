//! Diagnosis: where the calibrated world and the measured strikes disagree, which physical effect is missing, and how far
//! the gap shrinks with it.
//!
//! The strike is the unit of evidence: its launch scatters, so a whole track is worth far less than its frames ([`mixed`]).
//! Worlds are tried in planar form ([`world::planar`]), which follows MuJoCo's to a twentieth of a millimetre, a hundred times as
//! fast. Whether: score tests of every candidate, against residuals drawn from the fitted world ([`evidence`]). Which: fits of
//! the best candidates, forward, replaced and dropped again ([`search`]). None of these: what smooth dependences still find
//! beside the best model ([`smooth`]). The gap is judged in MuJoCo, on strikes that took no part ([`gap`]).

mod candidates;
mod conclude;
mod diagnosis;
mod evidence;
mod fit;
mod gap;
mod mixed;
mod model;
mod next;
mod score;
mod screen;
mod search;
mod smooth;
mod words;

pub use diagnosis::{
    Detectable, Diagnosis, Gap, Look, Named, NextStrike, Parameter, Ranked, Verdict, Where,
};

use nalgebra::SVector;
use serde::{Deserialize, Serialize};
use stage::{Progress, Stage};
use values::{Command, Rig, Shape, Split, Strike};
use world::{World, WorldError, launch::launches};

use crate::{
    fit::{Field, Fitted},
    mixed::Spread,
    model::{Model, RESTITUTION},
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

/// Change of restitution from which launches are taken again about the fit, and how often at the most.
const FAR: f64 = 0.1;
const REBASED: usize = 4;

fn diverges() -> DiagnoseError {
    DiagnoseError::NoFit {
        why: "its fit diverges".into(),
    }
}

impl Stage for Diagnose {
    const NAME: &'static str = "diagnose";
    const VERSION: u32 = 9;
    type Input = Input;
    type Output = Found;
    type Error = DiagnoseError;

    fn run(&self, input: &Input, progress: &Progress) -> Result<Found, DiagnoseError> {
        let rig = &input.rig;
        if rig.object.shape == Shape::Sphere {
            return Err(DiagnoseError::Rolls);
        }
        let frame = 1.0 / rig.camera.rate;
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
        progress.set_message("how the object leaves the tip");
        let commands: Vec<Command> = usable.iter().map(|strike| strike.command).collect();
        let (strikes, launches): (Vec<&Strike>, Vec<_>) = usable
            .iter()
            .zip(launches(rig, &input.world, &commands)?)
            .filter_map(|(strike, launch)| Some((strike, launch?)))
            .unzip();
        let mut field = Field::new(rig, strikes, launches);
        let pushed = usable.len() - field.strikes.len();
        if field.strikes.len() < FEWEST {
            return Err(DiagnoseError::NoFit {
                why: format!("in {pushed} strikes the object does not leave the tip"),
            });
        }

        progress.set_message("the world without effects");
        let plain = Model::plain(
            input.world.value("friction")?,
            input.world.value("restitution")?,
            frame,
        );
        let kicks = vec![SVector::zeros(); field.strikes.len()];
        let spread = Spread::initial(rig.camera.noise, frame);
        let mut null = field
            .fit(&plain, &spread, &kicks, fit::ITERATIONS)?
            .ok_or_else(diverges)?;
        let mut about = input.world.value("restitution")?;
        for _ in 0..REBASED {
            let Fitted {
                model,
                estimated,
                kicks,
                ..
            } = &null;
            if (model.values[RESTITUTION] - about).abs() < FAR {
                break;
            }
            // Far from the blows that launches were taken about, they are taken again.
            about = model.values[RESTITUTION];
            field = field.about(&input.world, &null)?;
            null = field
                .fit(model, &estimated.spread, kicks, fit::ITERATIONS)?
                .ok_or_else(diverges)?;
        }

        progress.set_message("every candidate at a glance");
        let candidates = candidates::candidates(rig, &field.strikes);
        let screened = screen::screen(&field, &null, &candidates, evidence::REPLICATES, self.seed)?;
        let chance = evidence::chance(&screened);
        let before = smooth::dependences(&field, &null, self.seed)?;
        let p_value = evidence::p_value(&screened, &chance).min(evidence::least(&before));

        let most = if p_value < evidence::REAL {
            self.most_effects
        } else {
            0
        };
        progress.set_message("which effects");
        let mut searched = search::search(&field, &null, &screened, &candidates, &chance, most)?;
        let mut after = Vec::new();
        while !searched.standing.is_empty() {
            after = smooth::dependences(&field, &searched.fitted, self.seed)?;
            // An effect weaker than what no candidate explains is no finding.
            // Nor is one that may as well be none.
            let weak = searched.weaker_than(evidence::left(&after));
            let Some(weak) = weak.or_else(|| searched.fitted.unsure()) else {
                break;
            };
            searched = search::without(&field, &searched, weak, &candidates, &chance)?;
        }

        progress.set_message("how far the gap shrinks");
        let about = field.about(&input.world, &searched.fitted)?;
        if !searched.standing.is_empty() {
            let Fitted {
                model,
                estimated,
                kicks,
                ..
            } = &searched.fitted;
            if let Some(fitted) = about.fit(model, &estimated.spread, kicks, fit::ITERATIONS)? {
                searched.fitted = fitted;
            }
        }
        conclude::Case {
            stage: self,
            input,
            field: &about,
            null: &null,
            screened: &screened,
            chance: &chance,
            searched: &searched,
            before: &before,
            after: &after,
            p_value,
            pushed,
            again,
        }
        .conclude()
    }
}
