//! What `--robot` names: which embedded rig strikes.

use std::path::{Path, PathBuf};

use rig::{Sim, SimChoice, Truth};
use values::Rig;

use crate::Error;

/// An embedded rig and where its truth comes from, for a person.
pub struct Embedded {
    /// The rig, in the last session that was logged.
    pub sim: Sim,
    /// The name of that session's log; none where no strike of this rig was logged.
    pub session: Option<String>,
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

impl Embedded {
    /// The embedded rig for an artifact's rig. It continues where the demo's strikes ended, so that no launch repeats
    /// one that was learnt from.
    pub fn open(choice: &SimChoice, artifacts: &Path, rig: &Rig, seed: u64) -> Result<Self, Error> {
        let truth = choice.truth(artifacts);
        let Some(path) = truth else {
            return Ok(Embedded {
                sim: Sim::default_for(rig, seed).map_err(Error::input)?,
                session: None,
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
        let last = truth.strikes.last().map(|strike| strike.session);
        let sim = Sim::from(Truth { seed, ..truth }).map_err(Error::input)?;
        Ok(Embedded {
            sim: sim.after(strikes).in_session(last.unwrap_or(0)),
            session: last.map(rig::demo::session_name),
            truth: Some(path),
        })
    }
}
