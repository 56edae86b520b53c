//! How logs are ingested.

use serde::{Deserialize, Serialize};

/// The stage and its settings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Ingest {
    /// Deals strikes into training, validation and test ([`values::split_of`]).
    pub seed: u64,
}
