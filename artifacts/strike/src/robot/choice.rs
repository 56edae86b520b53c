//! `--robot`: which robot is meant.

use std::path::PathBuf;
use std::str::FromStr;

/// A robot by its name on the command line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// `dry-run`: nothing moves.
    DryRun,
    /// `sim` or `sim:FOLDER`: the embedded rig, of the folder's `truth.json` where one is given.
    Sim(Option<PathBuf>),
}

/// A robot that is not there.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnknownRobot {
    /// No robot has the name.
    #[error("there is no robot `{0}`; robots are {KNOWN}")]
    Name(String),
    /// A driver that this version lacks.
    #[error("robot `{0}` is not available in this version; robots are {KNOWN}")]
    Unavailable(String),
    /// `sim:` without its folder.
    #[error("`sim:` needs a folder with a truth.json after the colon; or leave the colon out")]
    NoFolder,
}

const KNOWN: &str = "`dry-run`, `sim` and `sim:FOLDER`";

impl Choice {
    /// Whether it can move something in this world. One that can needs an artifact that somebody vouches for.
    pub fn moves(&self) -> bool {
        match self {
            Self::DryRun | Self::Sim(_) => false,
        }
    }
}

impl FromStr for Choice {
    type Err = UnknownRobot;

    fn from_str(text: &str) -> Result<Self, UnknownRobot> {
        match text.split_once(':') {
            None if text == "dry-run" => Ok(Self::DryRun),
            None if text == "sim" => Ok(Self::Sim(None)),
            Some(("sim", "")) => Err(UnknownRobot::NoFolder),
            Some(("sim", folder)) => Ok(Self::Sim(Some(folder.into()))),
            Some(("xarm", _)) => Err(UnknownRobot::Unavailable(text.into())),
            _ if text == "xarm" => Err(UnknownRobot::Unavailable(text.into())),
            _ => Err(UnknownRobot::Name(text.into())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robots_are_known_by_name_and_others_are_told_what_there_is() {
        assert_eq!("dry-run".parse(), Ok(Choice::DryRun));
        assert_eq!("sim".parse(), Ok(Choice::Sim(None)));
        assert_eq!("sim:a/b".parse(), Ok(Choice::Sim(Some("a/b".into()))));
        for text in ["xarm:10.0.0.2", "xarm", "kuka", ""] {
            let error = text.parse::<Choice>().expect_err(text).to_string();
            assert!(
                error.contains(text) && error.contains("`sim:FOLDER`"),
                "{error}"
            );
        }
        assert_eq!("sim:".parse::<Choice>(), Err(UnknownRobot::NoFolder));
    }
}
