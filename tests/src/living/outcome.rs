//! What a strike at a target came to.

use serde::{Deserialize, Serialize};

use super::drawn::Case;

/// Recent strikes after which the targets are struck.
pub const RECENT: [usize; 6] = [0, 1, 2, 3, 5, 10];

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    pub rig: u64,
    pub case: Case,
    pub method: Method,
    /// After so many recent strikes.
    pub recent: usize,
    /// Distance from target to stop, in m.
    pub miss: f64,
    /// What the plan expected it to be (root mean square), in m; of the peers none.
    pub promise: Option<f64>,
    /// Mean distance of repeats of one command from their mean, on the same table, in m.
    pub floor: f64,
    /// Whether the version says, after the recent strikes, that the table has changed beyond belief; of the peers never.
    pub says_changed: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    None,
    /// With the recent strikes, by carom's filter.
    Filter,
    /// The last miss taken off the target.
    LastError,
    /// A Newton step of a fixed Jacobian (distance as speed squared, bearing as angle) by the last strike's error.
    NewtonLast,
    /// Newton's step by the mean of the recent strikes' errors.
    NewtonMean,
}

impl Method {
    /// In the page's order.
    pub const ALL: [Self; 5] = [
        Self::Filter,
        Self::None,
        Self::LastError,
        Self::NewtonLast,
        Self::NewtonMean,
    ];
}
