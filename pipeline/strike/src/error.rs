//! Why nothing could be planned at all, as opposed to a plan that is refused.

use store::Model;
use world::WorldError;

/// Why nothing could be planned at all. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum PlannerError {
    #[error("plan with model `{model}`: version {version} does not hold it; it has {has}")]
    NoModel {
        model: Model,
        version: String,
        has: String,
    },
    #[error("plan for session `{session}`: version {version} does not know it; it knows {}", if known.is_empty() { "none: nothing that it named differs by session" } else { known })]
    NoSession {
        session: String,
        version: String,
        known: String,
    },
    #[error(
        "plan for this table: {strikes} recent strikes show {shown}, more than version {version} believes possible: the table has \
         changed; look at object, surface and tip, then collect some strikes with `carom collect` and run `carom nightly`"
    )]
    TableChanged {
        version: String,
        strikes: usize,
        shown: String,
    },
    #[error("compile the world of version {version}: {source}; publish the version again")]
    World { version: String, source: WorldError },
}
