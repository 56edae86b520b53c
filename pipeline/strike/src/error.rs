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
    /// Recent strikes show another table than the version believes possible.
    #[error(
        "plan for this table: {strikes} recent strikes show {shown}, more than version {version} believes possible: the table has \
         changed; look at object, surface and tip, then collect some strikes with `carom collect` and run `carom nightly`"
    )]
    TableChanged {
        /// The artifact.
        version: String,
        /// Strikes that say so.
        strikes: usize,
        /// What they show.
        shown: String,
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
