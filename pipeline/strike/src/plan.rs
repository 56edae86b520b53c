//! What is to be done: a command, and the motion of the tip that strikes it.

use serde::Serialize;
use store::Model;
use values::{Command, Point};
use world::Profile;

/// A mean of fewer strikes than this says little: at ten it is known to a fifth or so.
pub const FEW: usize = 10;

/// One strike, planned and within every limit. Serialised it is the contract's plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// Version of the artifact that planned it, such as `v0003`.
    pub artifact: String,
    /// Model that planned it.
    pub model: Model,
    /// Where the object rests, in m.
    pub from: Point,
    /// Where it shall come to rest, in m.
    pub to: Point,
    /// Displacement, in m.
    pub path: Point,
    /// Speed that the world alone would strike with, in m/s.
    pub speed_sim: f64,
    /// Angle that the world alone would strike at, in rad.
    pub angle_sim: f64,
    /// What the residual adds to the speed, in m/s; 0 for a model without one.
    pub d_speed: f64,
    /// What the residual adds to the angle, in rad; 0 for a model without one.
    pub d_angle: f64,
    /// Speed of the command, in m/s.
    pub speed: f64,
    /// Angle of the command, in rad.
    pub angle: f64,
    /// Tip's centre at rest before, in m.
    pub start: Point,
    /// Tip's centre when it has reached the striking speed, 10 mm before it strikes, in m.
    pub pre_strike: Point,
    /// Tip's centre when it touches the object, in m.
    pub strike: Point,
    /// Tip's centre at rest after, in m.
    pub stop: Point,
    /// Acceleration of the ramps, in m/s².
    pub acceleration: f64,
    /// Mean stop error of this model on the strikes held out when the artifact was made, in m; none where it was not
    /// evaluated.
    pub expected_miss: Option<f64>,
    /// On how many strikes that mean stands: below [`FEW`] the miss is hardly known.
    pub expected_miss_strikes: Option<usize>,
}

impl Plan {
    /// What the robot is told.
    pub fn command(&self) -> Command {
        Command {
            speed: self.speed,
            angle: self.angle,
        }
    }

    /// The motion of the tip with its times.
    pub fn profile(&self) -> Profile {
        let standoff = self.strike.distance(self.from);
        Profile::plan(self.from, self.command(), self.acceleration, standoff)
    }
}
