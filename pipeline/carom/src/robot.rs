//! What `--robot` names: which embedded rig strikes.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use rig::{Sim, Truth};
use values::Rig;

use crate::Error;

/// The robot that was asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RobotChoice {
    /// `sim`: the embedded rig, with the truth found in the run's folder or the demo's mixture.
    Sim,
    /// `sim:FOLDER`: the embedded rig with the truth in that folder.
    SimOf(PathBuf),
}

impl FromStr for RobotChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == "sim" => Ok(Self::Sim),
            Some(("sim", folder)) if !folder.is_empty() => Ok(Self::SimOf(folder.into())),
            _ => Err(
                "a trial strikes the embedded rig: `sim`, or `sim:FOLDER` with the folder of a truth.json"
                    .into(),
            ),
        }
    }
}

/// An embedded rig and where its truth comes from, for a person.
pub struct Embedded {
    /// The rig.
    pub sim: Sim,
    /// Its truth, such as `artifacts/demo/rig/truth.json`; none for the demo's own mixture.
    pub truth: Option<PathBuf>,
}

impl Embedded {
    /// Which rig it is.
    pub fn origin(&self) -> String {
        self.truth
            .as_ref()
            .map_or("the demo's mixture".into(), |path| {
                path.display().to_string()
            })
    }
}

impl RobotChoice {
    /// The embedded rig for an artifact's rig. It goes on where the demo's strikes ended, so that no launch repeats
    /// one that was learnt from.
    pub fn open(&self, artifacts: &Path, rig: &Rig, seed: u64) -> Result<Embedded, Error> {
        let truth = match self {
            Self::SimOf(folder) => Some(folder.join("truth.json")),
            Self::Sim => [
                artifacts.join("truth.json"),
                artifacts.join("rig/truth.json"),
            ]
            .into_iter()
            .find(|path| path.is_file()),
        };
        let Some(path) = truth else {
            return Ok(Embedded {
                sim: Sim::default_for(rig, seed).map_err(Error::input)?,
                truth: None,
            });
        };
        let truth = Truth::load(&path).map_err(Error::input)?;
        if truth.rig != *rig {
            return Err(Error::input(format!(
                "strike in the rig of {}: it is another rig than the artifact's; name the folder of the right one, such as \
                 `--robot sim:FOLDER`",
                path.display()
            )));
        }
        let strikes = truth.strikes.len();
        let sim = Sim::from(Truth { seed, ..truth }).map_err(Error::input)?;
        Ok(Embedded {
            sim: sim.after(strikes),
            truth: Some(path),
        })
    }
}
