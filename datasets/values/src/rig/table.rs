//! Where the object slides.

use serde::{Deserialize, Serialize};

use crate::{Interval, Point};

/// The table's bounds in frame `table`, in m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Bounds along x.
    pub x: Interval,
    /// Bounds along y.
    pub y: Interval,
}

impl Table {
    /// Whether a point lies on the table; NaN never does.
    pub fn contains(&self, point: Point) -> bool {
        self.x.contains(point.x) && self.y.contains(point.y)
    }
}
