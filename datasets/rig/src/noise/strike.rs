//! Noise that differs from strike to strike.

use super::levels::{Disturbs, Levels};
use crate::declare::declare;

declare! {
    /// Friction scatters from strike to strike.
    FrictionScatter = "friction_scatter" {
        /// Standard deviation, as a share of friction.
        sd: 0.02, "1", Some(0.0);
    }
}

impl Disturbs for FrictionScatter {
    fn add_to(&self, levels: &mut Levels) {
        levels.friction_scatter = levels.friction_scatter.hypot(self.sd);
    }
}

declare! {
    /// Two objects were mixed up: some strikes are of another one, with another base.
    TwoObjects = "two_objects" {
        /// Relative change of its friction.
        change: 0.15, "1", Some(0.0);
        /// Share of the strikes.
        share: 0.4, "1", None;
    }
}

impl Disturbs for TwoObjects {
    fn add_to(&self, levels: &mut Levels) {
        levels.other_change += self.change;
        levels.other_share = self.share;
    }
}

declare! {
    /// The object is put down turned, otherwise before each strike: a box's faces then do not lie along the table's axes.
    YawScatter = "yaw_scatter" {
        /// Standard deviation, in rad: four degrees, as a person puts a box down by eye.
        sd: 0.07, "rad", Some(0.0);
    }
}

impl Disturbs for YawScatter {
    fn add_to(&self, levels: &mut Levels) {
        levels.yaw_scatter = levels.yaw_scatter.hypot(self.sd);
    }
}

declare! {
    /// Friction wanders: a random walk with a step for each strike.
    FrictionWander = "friction_wander" {
        /// Standard deviation of a step, as a share of friction.
        step: 0.005, "1", Some(0.0);
    }
}

impl Disturbs for FrictionWander {
    fn add_to(&self, levels: &mut Levels) {
        levels.friction_wander = levels.friction_wander.hypot(self.step);
    }
}

declare! {
    /// Launches have heavy tails: a t distribution of three degrees of freedom with the same standard deviation.
    LaunchTails = "launch_tails" {
        /// Above 0: on.
        on: 1.0, "1", Some(0.0);
    }
}

impl Disturbs for LaunchTails {
    fn add_to(&self, levels: &mut Levels) {
        levels.launch_tails |= self.on > 0.0;
    }
}

declare! {
    /// Launches scatter more at high speed.
    LaunchScatterBySpeed = "launch_scatter_by_speed" {
        /// Factor at the robot's highest speed; 1 at its lowest.
        factor: 4.0, "1", Some(1.0);
    }
}

impl Disturbs for LaunchScatterBySpeed {
    fn add_to(&self, levels: &mut Levels) {
        levels.launch_growth_by_speed += self.factor - 1.0;
    }
}

declare! {
    /// Launches scatter more at wide angles.
    LaunchScatterByAngle = "launch_scatter_by_angle" {
        /// Factor at the robot's widest angle; 1 straight ahead.
        factor: 3.0, "1", Some(1.0);
    }
}

impl Disturbs for LaunchScatterByAngle {
    fn add_to(&self, levels: &mut Levels) {
        levels.launch_growth_by_angle += self.factor - 1.0;
    }
}

declare! {
    /// The camera's noise differs from strike to strike, as light does.
    CameraNoiseByStrike = "camera_noise_by_strike" {
        /// Standard deviation of the logarithm of the noise.
        spread: 0.5, "1", Some(0.0);
    }
}

impl Disturbs for CameraNoiseByStrike {
    fn add_to(&self, levels: &mut Levels) {
        levels.camera_spread = levels.camera_spread.hypot(self.spread);
    }
}
