//! Diagnosis: where the calibrated world and the measured strikes disagree, which physical effect is missing, and how far
//! the gap shrinks with it.

mod diagnosis;

pub use diagnosis::{
    Detectable, Diagnosis, Gap, Look, Named, NextStrike, Parameter, Ranked, Verdict, Where,
};

use serde::{Deserialize, Serialize};
use stage::{Progress, Stage};
use values::{Rig, Strike};
use world::{World, WorldError};

/// How to diagnose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Diagnose {
    /// The earliest strikes that fit and choose, at most this many.
    pub most_strikes: usize,
    /// Effects that may be added.
    pub most_effects: usize,
    /// Seeds the bootstrap.
    pub seed: u64,
}

impl Default for Diagnose {
    fn default() -> Self {
        Self {
            most_strikes: 120,
            most_effects: 3,
            seed: 0,
        }
    }
}

/// What to look at.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Input {
    /// The rig.
    pub rig: Rig,
    /// The identified world, without effects.
    pub world: World,
    /// Strikes in order of time; those of [`values::Split::Test`] judge the gap and take no other part.
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
    #[error("diagnose {strikes} strikes: at least {needed} are needed; log more strikes")]
    TooFewStrikes {
        /// Strikes that may be used.
        strikes: usize,
        /// Strikes needed.
        needed: usize,
    },
    /// The world could not be simulated.
    #[error(transparent)]
    World(#[from] WorldError),
}

impl Stage for Diagnose {
    const NAME: &'static str = "diagnose";
    const VERSION: u32 = 1;
    type Input = Input;
    type Output = Found;
    type Error = DiagnoseError;

    fn run(&self, _input: &Input, _progress: &Progress) -> Result<Found, DiagnoseError> {
        todo!("the search")
    }
}
