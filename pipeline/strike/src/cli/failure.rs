//! How the program ends where it does not do what was requested.

use std::fmt::Display;
use std::process::ExitCode;

use serde_json::json;
use store::{ArtifactError, Fault};
use strike::{LiveError, LogError, Reason, Refusal, TrustError};

/// What went wrong; it chooses the exit code.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    #[error("failed to {0}")]
    Failed(String),
    #[error("{0}; see --help")]
    Usage(String),
    #[error("failed to {0}")]
    Input(String),
    /// Another program holds what is needed.
    #[error("failed to {0}")]
    Busy(String),
    /// A limit or a check refuses.
    #[error("refused: {0}")]
    Refused(Refusal),
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

    /// A refusal of what does not depend on object and target.
    pub fn refused(refused: Reason, detail: impl Display) -> Self {
        Self::Refused(Refusal {
            from: None,
            to: None,
            refused,
            detail: detail.to_string(),
        })
    }

    /// The contract's exit code.
    pub fn code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Failed(_) => 1,
            Self::Usage(_) | Self::Input(_) => 2,
            Self::Refused(_) => 4,
            Self::Busy(_) => 75,
        })
    }

    /// What a machine reads: the contract's refusal, or `{"failed": "text"}`.
    pub fn to_json(&self) -> String {
        match self {
            Self::Refused(refusal) => serde_json::to_string(refusal).unwrap_or_default(),
            _ => json!({ "failed": self.to_string() }).to_string(),
        }
    }
}

impl From<TrustError> for Failure {
    fn from(error: TrustError) -> Self {
        use Fault::{BadSignature, NotSigned};
        use durable::LockError;
        match error {
            TrustError::Artifact(ArtifactError::Unsound {
                fault: NotSigned | BadSignature(_),
                ..
            })
            | TrustError::Older { .. }
            | TrustError::Twice { .. }
            | TrustError::NoKey
            | TrustError::NoRig => Self::refused(Reason::NotTrusted, format!("failed to {error}")),
            TrustError::Locked(LockError::Busy { .. }) => Self::Busy(error.to_string()),
            TrustError::Unkept(_) | TrustError::Locked(_) => Self::failed(error),
            TrustError::Artifact(_) | TrustError::BadKey { .. } | TrustError::BadSeen { .. } => {
                Self::input(error)
            }
        }
    }
}

impl From<LiveError> for Failure {
    fn from(error: LiveError) -> Self {
        match error {
            LiveError::Address(_) | LiveError::NoTopic { .. } => Self::input(error),
            LiveError::Connection { .. } | LiveError::Protocol { .. } => Self::failed(error),
            LiveError::NotAtRest(_) | LiveError::Frames(..) => {
                Self::refused(Reason::NotReady, format!("failed to {error}"))
            }
        }
    }
}

impl From<LogError> for Failure {
    fn from(error: LogError) -> Self {
        match error {
            LogError::Exists(_) => Self::input(error),
            LogError::File(_)
            | LogError::Again
            | LogError::Content(_)
            | LogError::CutOff { .. } => Self::failed(error),
        }
    }
}
