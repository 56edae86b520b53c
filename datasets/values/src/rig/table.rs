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
    /// Where objects bounce.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fences: Vec<Fence>,
}

/// A straight fence on the table; the object's edge meets it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fence {
    /// The fence's one end, in m.
    pub from: Point,
    /// The fence's other end, in m.
    pub to: Point,
}

impl Fence {
    /// How far a point lies from it, in m.
    pub fn distance(&self, point: Point) -> f64 {
        let along = self.to - self.from;
        let part = (point - self.from).dot(along) / along.dot(along);
        point.distance(self.from + along * part.clamp(0.0, 1.0))
    }
}

impl Table {
    /// Whether a point lies on the table; NaN never does.
    pub fn contains(&self, point: Point) -> bool {
        self.x.contains(point.x) && self.y.contains(point.y)
    }
}
