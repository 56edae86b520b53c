//! What a world still gets wrong about one strike: about the command for its path, and about the launch that the arm delivered.

use serde::{Deserialize, Serialize};

use crate::{Point, Split};

/// One row of `residuals.parquet`: what the residual model learns from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Residual {
    /// The strike.
    pub strike_id: String,
    /// Measured displacement from rest to rest, in m.
    pub path: Point,
    /// Speed that the world would strike with for this path, in m/s.
    pub speed_sim: f64,
    /// Angle that the world would strike at, in rad.
    pub angle_sim: f64,
    /// Commanded less simulated speed, in m/s.
    pub d_speed: f64,
    /// Commanded less simulated angle, in rad, in (−π, π].
    pub d_angle: f64,
    /// The part that the strike plays.
    pub split: Split,
}

/// What a strike's path needs of the arm beside what the world says that it delivered.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LaunchResidual {
    /// Logarithm of the factor on the speed.
    pub speed: f64,
    /// Added to the angle, in rad, in (−π, π].
    pub angle: f64,
}
