//! Closed intervals.

use serde::{Deserialize, Serialize};

use crate::exact::Exact;

/// A closed interval, in files an array `[low, high]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Exact<f64, 2>", into = "[f64; 2]")]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// From the lower end to the upper one.
    pub const fn new(low: f64, high: f64) -> Self {
        Self { low, high }
    }

    /// Whether the value lies inside, ends included; NaN never does.
    pub fn contains(self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    /// The value, moved to the nearer end where it lies outside.
    pub fn clamp(self, value: f64) -> f64 {
        value.clamp(self.low, self.high)
    }
}

impl From<Exact<f64, 2>> for Interval {
    fn from(Exact(numbers): Exact<f64, 2>) -> Self {
        numbers.into()
    }
}

impl From<[f64; 2]> for Interval {
    fn from([low, high]: [f64; 2]) -> Self {
        Self { low, high }
    }
}

impl From<Interval> for [f64; 2] {
    fn from(interval: Interval) -> Self {
        [interval.low, interval.high]
    }
}
