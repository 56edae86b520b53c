//! What may be added to a world, and how well it predicts strikes that it did not learn from.

use serde::{Deserialize, Serialize};
use store::ResidualModel;

use crate::miss::Miss;

values::named! {
    /// What may be added to a world, the plainest first.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Kind {
        /// Nothing.
        None = "none",
        /// A smooth map of launches over commands.
        LaunchMap = "launch map",
        /// The paper's networks.
        Networks = "networks",
    }
}

/// How well a candidate predicts stops of strikes that it did not learn from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// The candidate.
    pub kind: Kind,
    /// Mean distance in m, commands that are alike held out together.
    pub by_setting: f64,
    /// Mean distance in m, whole sessions held out together, over commands among those of the other sessions; none where it was not
    /// measured.
    pub by_session: Option<f64>,
    /// Strikes that judged it: all, unless it was given up by then.
    pub strikes: usize,
}

/// A candidate, and what it leaves of each strike that it did not learn from.
pub(crate) struct Candidate {
    pub(crate) kind: Kind,
    pub(crate) model: Option<ResidualModel>,
    pub(crate) misses: Vec<Miss>,
    /// The share of the path that it expected to leave; of a map alone.
    pub(crate) expected: Vec<f64>,
    /// Whether a map that learnt from other parts was fitted to commands around this one.
    pub(crate) is_within: Vec<bool>,
}
