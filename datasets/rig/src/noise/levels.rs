//! All kinds of noise together, as numbers.

use values::Point;

/// What the rig draws from. At the default only launch scatter and independent camera noise are left, and no further random
/// number is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Levels {
    /// Standard deviation of the logarithm of friction from strike to strike.
    pub friction_scatter: f64,
    /// Standard deviation of a step of its random walk, a step for each strike.
    pub friction_wander: f64,
    /// Standard deviation of the object's yaw before a strike, in rad.
    pub yaw_scatter: f64,
    /// Whether launches have a t distribution of three degrees of freedom.
    pub launch_tails: bool,
    /// Factor on the scatter of launches at the robot's highest speed, less 1.
    pub launch_growth_by_speed: f64,
    /// Factor on the scatter of launches at the robot's widest angle, less 1.
    pub launch_growth_by_angle: f64,
    /// Autocorrelation of camera noise from frame to frame.
    pub camera_correlation: f64,
    /// Whether camera noise has a t distribution of three degrees of freedom.
    pub camera_tails: bool,
    /// Standard deviation of the logarithm of the camera's noise from strike to strike.
    pub camera_spread: f64,
    /// Mean delay of stamps, exponential, in s.
    pub stamp_delay: f64,
    /// Standard deviation of stamps, in s.
    pub stamp_jitter: f64,
    /// Share of frames in which something else is taken for the object.
    pub stray_share: f64,
    /// How far off at the most, in m.
    pub stray_distance: f64,
    /// Grids of reported places, in m, and of stamps, in s.
    pub place_step: f64,
    pub stamp_step: f64,
    /// Share of strikes in which frames are lost in a row, and for how long at the most, in s.
    pub burst_share: f64,
    pub burst_longest: f64,
    /// One over the largest x that is seen, in 1/m; 0 where all is.
    pub view_narrowness: f64,
    /// Delay of the exposure for each metre, in s/m, along the direction of the readout.
    pub readout: Point,
    /// Share of strikes of another object, and how much its friction differs.
    pub other_share: f64,
    pub other_change: f64,
    /// Amplitude with which the camera's mount vibrates, in m on the table.
    pub mount_amplitude: f64,
    /// Its frequency, in Hz.
    pub mount_frequency: f64,
    /// Relative errors of the rig file: the object's sizes, its mass, the tip's radius, the camera's noise.
    pub object_error: f64,
    pub mass_error: f64,
    pub tip_error: f64,
    pub camera_noise_error: f64,
}

impl Levels {
    /// Factor on the scatter of launches for this share of the speeds' range and of the widest angle.
    pub(crate) fn launch_growth(&self, speed_share: f64, angle_share: f64) -> f64 {
        (1.0 + self.launch_growth_by_speed * speed_share.clamp(0.0, 2.0))
            * (1.0 + self.launch_growth_by_angle * angle_share.clamp(0.0, 2.0))
    }
}

/// What a kind of noise adds.
pub(crate) trait Disturbs {
    fn add_to(&self, levels: &mut Levels);
}
