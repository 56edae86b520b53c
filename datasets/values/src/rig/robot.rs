//! What the arm may do, where it stands and what it must not touch.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::{Interval, Point, exact};

/// Limits of the arm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Robot {
    /// Striking speeds that it may be commanded, in m/s.
    pub speed: Interval,
    /// Striking angles that it may be commanded, in rad.
    pub angle: Interval,
    /// Acceleration of the trapezoidal profile, in m/s².
    pub acceleration: f64,
    /// Where the axis of its base stands, in m; the origin unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base: Option<Point>,
    /// By how much the arm's own x axis is turned from the table's, in rad; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base_yaw: Option<f64>,
    /// Height of the arm's own origin above the table, in m; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base_height: Option<f64>,
    /// Radius in m about the base's axis that the tip keeps clear of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keep_out: Option<f64>,
    /// Distances in m from the base's axis that the tip's centre may have.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reach: Option<Interval>,
    /// Jerk of the ramps, in m/s³; none for an arm that changes its acceleration at once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub jerk: Option<f64>,
    /// Height of the tip's centre above the table when it strikes, in m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strike_height: Option<f64>,
    /// Height of the tip's centre above the table on its way, clear of the object, in m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub travel_height: Option<f64>,
    /// Roll, pitch and yaw of the tool while it strikes, in rad.
    #[serde(default, with = "exact", skip_serializing_if = "Option::is_none")]
    pub tool_orientation: Option<[f64; 3]>,
    /// The tip's centre in the flange's frame: x, y, z in m, roll, pitch, yaw in rad.
    #[serde(default, with = "exact", skip_serializing_if = "Option::is_none")]
    pub tool_offset: Option<[f64; 6]>,
    /// Mass of the tool, in kg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub payload: Option<f64>,
    /// The arm's serial number; any arm's unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub serial: Option<String>,
    /// What it must not touch.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<Obstacle>,
}

impl Robot {
    /// An arm of which only its striking limits are known: speeds in m/s, angles in rad, acceleration in m/s².
    pub fn limits(speed: Interval, angle: Interval, acceleration: f64) -> Self {
        Self {
            speed,
            angle,
            acceleration,
            base: None,
            base_yaw: None,
            base_height: None,
            keep_out: None,
            reach: None,
            jerk: None,
            strike_height: None,
            travel_height: None,
            tool_orientation: None,
            tool_offset: None,
            payload: None,
            serial: None,
            obstacles: Vec::new(),
        }
    }

    /// Whether the file says where the arm stands or reaches.
    pub fn is_placed(&self) -> bool {
        self.base.is_some() || self.keep_out.is_some() || self.reach.is_some()
    }
}

/// What the arm must not touch, seen from above; it counts at every height.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "lowercase", deny_unknown_fields)]
pub enum Obstacle {
    /// A box with sides along the table's axes.
    Box {
        /// Extent along x, in m.
        x: Interval,
        /// Extent along y, in m.
        y: Interval,
    },
    /// A disc.
    Disc {
        /// Its centre, in m.
        centre: Point,
        /// Its radius in m.
        radius: f64,
    },
}

impl fmt::Display for Obstacle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Box { x, y } => write!(
                f,
                "a box, x in [{}, {}] and y in [{}, {}] m",
                x.low, x.high, y.low, y.high
            ),
            Self::Disc { centre, radius } => write!(
                f,
                "a disc of radius {radius} m about ({}, {}) m",
                centre.x, centre.y
            ),
        }
    }
}
