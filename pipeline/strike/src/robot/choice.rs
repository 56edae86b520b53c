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
    /// `xarm:HOST`: an arm for which there is no driver yet.
    XArm(String),
}

/// A robot that is not there.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnknownRobot {
    /// No robot has the name.
    #[error("there is no robot `{0}`; robots are {KNOWN}")]
    Name(String),
    /// `xarm` without its host.
    #[error("`xarm:` needs the arm's host after the colon, such as `xarm:192.168.1.10`")]
    NoHost,
    /// `sim:` without its folder.
    #[error("`sim:` needs a folder with a truth.json after the colon; or leave the colon out")]
    NoFolder,
}

/// What can be struck with.
pub(crate) const KNOWN: &str = "`dry-run`, `sim` and `sim:FOLDER`";

impl Choice {
    /// Whether it can move something in this world. One that can needs an artifact that somebody vouches for.
    pub fn moves(&self) -> bool {
        match self {
            Self::DryRun | Self::Sim(_) => false,
            Self::XArm(_) => true,
        }
    }
}

impl Choice {
    /// Why nothing can strike with it: this version has no driver for it.
    pub fn lacks_driver(&self) -> Option<String> {
        let Self::XArm(host) = self else { return None };
        Some(format!(
            "there is no driver for the xArm at {host} in this version, and nothing was sent to it; plan with `dry-run` and hand \
             the plan (--json) to the arm's own program; robots are {KNOWN}"
        ))
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
            Some(("xarm", "")) => Err(UnknownRobot::NoHost),
            Some(("xarm", host)) => Ok(Self::XArm(host.into())),
            None if text == "xarm" => Err(UnknownRobot::NoHost),
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
        assert_eq!("xarm:10.0.0.2".parse(), Ok(Choice::XArm("10.0.0.2".into())));
        for text in ["xarm", "xarm:"] {
            assert_eq!(text.parse::<Choice>(), Err(UnknownRobot::NoHost));
        }
        for text in ["kuka", ""] {
            let error = text.parse::<Choice>().expect_err(text).to_string();
            assert!(
                error.contains(text) && error.contains("`sim:FOLDER`"),
                "{error}"
            );
        }
        assert_eq!("sim:".parse::<Choice>(), Err(UnknownRobot::NoFolder));
    }
}
