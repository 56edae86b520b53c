//! Why nothing could be planned at all, as opposed to a plan that is refused.

use store::Model;
use world::WorldError;

/// Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum PlannerError {
    /// The artifact has no such model.
    #[error("plan with model `{model}`: version {version} does not hold it; it has {has}")]
    NoModel {
        /// The model requested.
        model: Model,
        /// The artifact.
        version: String,
        /// The models that it holds.
        has: String,
    },
    /// A session that the version does not know.
    #[error("plan for session `{session}`: version {version} does not know it; it knows {}", if known.is_empty() { "none: nothing that it named differs by session" } else { known })]
    NoSession {
        /// The session requested.
        session: String,
        /// The artifact.
        version: String,
        /// The sessions that it knows.
        known: String,
    },
    /// The world of the artifact cannot be simulated.
    #[error("compile the world of version {version}: {source}; publish the version again")]
    World {
        /// The artifact.
        version: String,
        /// Why.
        source: WorldError,
    },
}
