//! How the program ends where it does not do what was asked.

use std::fmt::{self, Display};
use std::process::ExitCode;

use store::ArtifactError;
use strike::{LogError, RobotError, TrustError};

/// What went wrong; it chooses the exit code.
#[derive(Debug)]
pub enum Failure {
    /// Something failed.
    Failed(String),
    /// Wrong usage.
    Usage(String),
    /// Bad input.
    Input(String),
    /// A limit or a check refuses.
    Refused(String),
}

impl Failure {
    pub fn failed(why: impl Display) -> Self {
        Self::Failed(why.to_string())
    }

    pub fn usage(why: impl Display) -> Self {
        Self::Usage(why.to_string())
    }

    pub fn input(why: impl Display) -> Self {
        Self::Input(why.to_string())
    }

    pub fn refused(why: impl Display) -> Self {
        Self::Refused(why.to_string())
    }

    /// The contract's exit code.
    pub fn code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Failed(_) => 1,
            Self::Usage(_) | Self::Input(_) => 2,
            Self::Refused(_) => 4,
        })
    }
}

impl Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Failed(why) | Self::Input(why) => write!(f, "failed to {why}"),
            Self::Usage(why) => write!(f, "{why}; see --help"),
            Self::Refused(why) => write!(f, "refused: {why}"),
        }
    }
}

impl From<RobotError> for Failure {
    fn from(error: RobotError) -> Self {
        match error {
            RobotError::NotReady { .. } => Self::refused(format!("not_ready: failed to {error}")),
            _ => Self::failed(error),
        }
    }
}

impl From<TrustError> for Failure {
    fn from(error: TrustError) -> Self {
        use ArtifactError::{BadSignature, NotSigned};
        match error {
            TrustError::Artifact(NotSigned { .. } | BadSignature { .. })
            | TrustError::Older { .. }
            | TrustError::Twice { .. }
            | TrustError::NoKey => Self::refused(format!("not_trusted: failed to {error}")),
            TrustError::Unkept(_) => Self::failed(error),
            TrustError::Artifact(_) | TrustError::BadKey { .. } | TrustError::BadSeen { .. } => {
                Self::input(error)
            }
        }
    }
}

impl From<LogError> for Failure {
    fn from(error: LogError) -> Self {
        match error {
            LogError::Exists(_) => Self::input(error),
            LogError::File { .. } | LogError::Content(_) => Self::failed(error),
        }
    }
}
