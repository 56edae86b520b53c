//! Which embedded rig is meant: `sim`, or `sim:FOLDER` with the folder of its `truth.json`.

use std::path::{Path, PathBuf};
use std::str::FromStr;

const TRUTH: &str = "truth.json";

/// An embedded rig by its name on a command line.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SimChoice {
    /// The folder that is named; none for the rig of the run's own folder.
    pub folder: Option<PathBuf>,
}

/// A name that is no embedded rig's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum NotSim {
    #[error("the embedded rig is `sim`, or `sim:FOLDER` with the folder of a truth.json")]
    Name,
    #[error("`sim:` needs a folder with a truth.json after the colon; or leave the colon out")]
    NoFolder,
}

impl FromStr for SimChoice {
    type Err = NotSim;

    fn from_str(text: &str) -> Result<Self, NotSim> {
        match text.split_once(':') {
            None if text == "sim" => Ok(Self::default()),
            Some(("sim", "")) => Err(NotSim::NoFolder),
            Some(("sim", folder)) => Ok(Self {
                folder: Some(folder.into()),
            }),
            _ => Err(NotSim::Name),
        }
    }
}

impl SimChoice {
    /// The `truth.json` of the folder that is named, whether it is there or not; else the one in a run's folder, or in its
    /// `rig/`, where `carom demo` writes it; none where there is none.
    pub fn truth(&self, run: &Path) -> Option<PathBuf> {
        match &self.folder {
            Some(folder) => Some(folder.join(TRUTH)),
            None => [run.join(TRUTH), run.join("rig").join(TRUTH)]
                .into_iter()
                .find(|path| path.is_file()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rig_is_known_by_its_name_and_its_folder() {
        assert_eq!("sim".parse(), Ok(SimChoice::default()));
        let named = "sim:a/b:c".parse::<SimChoice>().expect("a rig");
        assert_eq!(
            named.truth(Path::new("run")),
            Some("a/b:c/truth.json".into())
        );
        assert_eq!("sim:".parse::<SimChoice>(), Err(NotSim::NoFolder));
        for other in ["", "simulator", "dry-run", "xarm:sim"] {
            assert_eq!(other.parse::<SimChoice>(), Err(NotSim::Name), "{other}");
        }
    }

    #[test]
    fn without_a_folder_it_is_the_runs_own() {
        let run = tempfile::tempdir().expect("folder");
        let found = || SimChoice::default().truth(run.path());
        assert_eq!(found(), None);
        std::fs::create_dir(run.path().join("rig")).expect("folder");
        std::fs::write(run.path().join("rig/truth.json"), "{}").expect("writes");
        assert_eq!(found(), Some(run.path().join("rig/truth.json")));
        std::fs::write(run.path().join("truth.json"), "{}").expect("writes");
        assert_eq!(found(), Some(run.path().join("truth.json")));
    }
}
