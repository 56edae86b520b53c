//! `--robot`: which robot is meant.

use std::str::FromStr;

#[cfg(feature = "sim")]
use rig::{NotSim, SimChoice};

/// A robot by its name on the command line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// `dry-run`: nothing moves.
    DryRun,
    /// `sim` or `sim:FOLDER`: the embedded rig.
    #[cfg(feature = "sim")]
    Sim(SimChoice),
    /// `xarm:HOST`: an arm of UFACTORY.
    XArm(String),
    /// `ur:HOST`: Universal Robots' e-Series.
    Ur(String),
}

#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum UnknownRobot {
    #[error("there is no robot `{0}`; robots are {KNOWN}")]
    Name(String),
    #[error("`{0}:` needs the arm's host after the colon, such as `{0}:192.168.1.10`")]
    NoHost(String),
    #[cfg(feature = "sim")]
    #[error(transparent)]
    Sim(NotSim),
}

/// What can be struck with.
#[cfg(not(feature = "sim"))]
pub(crate) const KNOWN: &str = "`dry-run`, `xarm:HOST` and `ur:HOST`; the embedded rig is not in this build of strike: `carom trial --robot sim` strikes it";
/// What can be struck with.
#[cfg(feature = "sim")]
pub(crate) const KNOWN: &str = "`dry-run`, `sim`, `sim:FOLDER`, `xarm:HOST` and `ur:HOST`";

impl Choice {
    /// Whether it can move something in this world. One that can needs an artifact that somebody vouches for, and a rig file of
    /// its own.
    pub fn moves(&self) -> bool {
        match self {
            Self::DryRun => false,
            #[cfg(feature = "sim")]
            Self::Sim(_) => false,
            Self::XArm(_) | Self::Ur(_) => true,
        }
    }
}

impl FromStr for Choice {
    type Err = UnknownRobot;

    fn from_str(text: &str) -> Result<Self, UnknownRobot> {
        match text.split_once(':') {
            None if text == "dry-run" => return Ok(Self::DryRun),
            None if matches!(text, "xarm" | "ur") => {
                return Err(UnknownRobot::NoHost(text.into()));
            }
            Some((maker @ ("xarm" | "ur"), "")) => return Err(UnknownRobot::NoHost(maker.into())),
            Some(("xarm", host)) => return Ok(Self::XArm(host.into())),
            Some(("ur", host)) => return Ok(Self::Ur(host.into())),
            _ => {}
        }
        #[cfg(not(feature = "sim"))]
        return Err(UnknownRobot::Name(text.into()));
        #[cfg(feature = "sim")]
        match text.parse() {
            Ok(sim) => Ok(Self::Sim(sim)),
            Err(NotSim::Name) => Err(UnknownRobot::Name(text.into())),
            Err(error) => Err(UnknownRobot::Sim(error)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(not(feature = "sim"))]
    #[test]
    fn a_build_without_the_embedded_rig_says_who_strikes_it() {
        let error = "sim".parse::<Choice>().expect_err("not in this build");
        assert!(error.to_string().contains("carom trial"), "{error}");
    }

    #[cfg(feature = "sim")]
    #[test]
    fn robots_are_known_by_name_and_an_unknown_one_lists_them() {
        assert_eq!("dry-run".parse(), Ok(Choice::DryRun));
        assert_eq!("sim".parse(), Ok(Choice::Sim(SimChoice::default())));
        let folder = Some("a/b".into());
        assert_eq!("sim:a/b".parse(), Ok(Choice::Sim(SimChoice { folder })));
        assert_eq!("xarm:10.0.0.2".parse(), Ok(Choice::XArm("10.0.0.2".into())));
        assert_eq!("ur:ur5e".parse(), Ok(Choice::Ur("ur5e".into())));
        for (text, maker) in [
            ("xarm", "xarm"),
            ("xarm:", "xarm"),
            ("ur", "ur"),
            ("ur:", "ur"),
        ] {
            let missing = UnknownRobot::NoHost(maker.into());
            assert_eq!(text.parse::<Choice>(), Err(missing));
        }
        for text in ["kuka", ""] {
            let error = text.parse::<Choice>().expect_err(text).to_string();
            assert!(
                error.contains(text) && error.contains("`sim:FOLDER`"),
                "{error}"
            );
        }
        let error = "sim:".parse::<Choice>().expect_err("no folder");
        assert_eq!(error, UnknownRobot::Sim(NotSim::NoFolder));
    }
}
