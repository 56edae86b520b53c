//! Kinds of noise, from strike to strike, of the camera and its stamps, and of the rig file, each with what it adds to the [`Levels`].

use values::Point;

use crate::declare::declare;

/// Declares kinds of noise: their parameters, and what each adds.
macro_rules! noise {
    ($(
        $(#[$doc:meta])* $kind:ident = $name:literal { $($parameters:tt)* }
        |$noise:ident, $levels:ident| $adds:expr;
    )*) => {$(
        declare! { $(#[$doc])* $kind = $name { $($parameters)* } }

        impl Disturbs for $kind {
            fn add_to(&self, $levels: &mut Levels) {
                let $noise = self;
                $adds;
            }
        }
    )*};
}

noise! {
    /// Friction scatters from strike to strike.
    FrictionScatter = "friction_scatter" {
        /// Standard deviation, as a share of friction.
        sd: 0.02, "1", Some(0.0);
    }
    |noise, levels| levels.friction_scatter = levels.friction_scatter.hypot(noise.sd);

    /// Two objects were mixed up: some strikes are of another one, with another base.
    TwoObjects = "two_objects" {
        /// Relative change of its friction.
        change: 0.15, "1", Some(0.0);
        share: 0.4, "1", None;
    }
    |noise, levels| {
        levels.other_change += noise.change;
        levels.other_share = noise.share;
    };

    /// The object is put down turned, otherwise before each strike: a box's faces then do not lie along the table's axes.
    YawScatter = "yaw_scatter" {
        /// Standard deviation, in rad: four degrees, as a person puts a box down by eye.
        sd: 0.07, "rad", Some(0.0);
    }
    |noise, levels| levels.yaw_scatter = levels.yaw_scatter.hypot(noise.sd);

    /// Friction wanders: a random walk with a step for each strike.
    FrictionWander = "friction_wander" {
        /// Standard deviation of a step, as a share of friction.
        step: 0.005, "1", Some(0.0);
    }
    |noise, levels| levels.friction_wander = levels.friction_wander.hypot(noise.step);

    /// Launches have heavy tails: a t distribution of three degrees of freedom with the same standard deviation.
    LaunchTails = "launch_tails" {
        on: 1.0, "1", Some(0.0);
    }
    |noise, levels| levels.launch_tails |= noise.on > 0.0;

    /// Launches scatter more at high speed.
    LaunchScatterBySpeed = "launch_scatter_by_speed" {
        /// Factor at the robot's highest speed; 1 at its lowest.
        factor: 4.0, "1", Some(1.0);
    }
    |noise, levels| levels.launch_growth_by_speed += noise.factor - 1.0;

    /// Launches scatter more at wide angles.
    LaunchScatterByAngle = "launch_scatter_by_angle" {
        /// Factor at the robot's widest angle; 1 straight ahead.
        factor: 3.0, "1", Some(1.0);
    }
    |noise, levels| levels.launch_growth_by_angle += noise.factor - 1.0;

    /// The camera's noise differs from strike to strike, as light does.
    CameraNoiseByStrike = "camera_noise_by_strike" {
        /// Standard deviation of the logarithm of the noise.
        spread: 0.5, "1", Some(0.0);
    }
    |noise, levels| levels.camera_spread = levels.camera_spread.hypot(noise.spread);

    /// Camera noise is correlated from frame to frame (autoregressive of first order, the same standard deviation).
    CameraCorrelation = "camera_correlation" {
        /// Autocorrelation of neighbouring frames.
        rho: 0.6, "1", Some(0.0);
    }
    |noise, levels| levels.camera_correlation = noise.rho.clamp(0.0, 0.99);

    /// Camera noise has heavy tails: a t distribution of three degrees of freedom with the same standard deviation.
    CameraTails = "camera_tails" {
        on: 1.0, "1", Some(0.0);
    }
    |noise, levels| levels.camera_tails |= noise.on > 0.0;

    /// Stamps are late by an exponential delay, as those that a driver gives on arrival.
    LateStamps = "late_stamps" {
        mean: 0.003, "s", Some(0.0);
    }
    |noise, levels| levels.stamp_delay += noise.mean;

    /// Stamps scatter about the time of exposure.
    JitteringStamps = "jittering_stamps" {
        /// Standard deviation, in s.
        sd: 0.003, "s", Some(0.0);
    }
    |noise, levels| levels.stamp_jitter = levels.stamp_jitter.hypot(noise.sd);

    /// In some frames something else is taken for the object.
    StrayFrames = "stray_frames" {
        share: 0.01, "1", Some(0.0);
        /// How far from the object at the most, in m.
        distance: 0.10, "m", None;
    }
    |noise, levels| {
        levels.stray_share += noise.share;
        levels.stray_distance = levels.stray_distance.max(noise.distance);
    };

    /// Places are reported on a grid, as whole pixels are.
    QuantisedPlaces = "quantised_places" {
        step: 0.002, "m", Some(0.0);
    }
    |noise, levels| levels.place_step = levels.place_step.max(noise.step);

    /// Stamps are whole ticks of a coarse clock.
    QuantisedStamps = "quantised_stamps" {
        step: 0.004, "s", Some(0.0);
    }
    |noise, levels| levels.stamp_step = levels.stamp_step.max(noise.step);

    /// In some strikes all frames of a while are lost.
    LostBursts = "lost_bursts" {
        share: 0.3, "1", Some(0.0);
        /// How long at the most, in s.
        longest: 0.3, "s", None;
    }
    |noise, levels| {
        levels.burst_share += noise.share;
        levels.burst_longest = levels.burst_longest.max(noise.longest);
    };

    /// The camera's view ends: what lies beyond is in no frame.
    NarrowView = "narrow_view" {
        /// One over the largest x that is seen, in 1/m.
        narrowness: 1.4, "1/m", Some(0.0);
    }
    |noise, levels| levels.view_narrowness = levels.view_narrowness.max(noise.narrowness);

    /// A rolling shutter: rows of the picture are exposed one after another, so that a place is seen later the farther it lies.
    RollingShutter = "rolling_shutter" {
        /// Time from one place to another that lies 1 m farther, in s.
        readout: 0.015, "s", Some(0.0);
        /// Direction in which rows follow each other, in rad.
        bearing: 0.0, "rad", None;
    }
    |noise, levels| levels.readout = values::Point::polar(noise.readout, noise.bearing);

    /// The camera's mount vibrates, in a direction and with a phase of its own in each strike.
    MountVibration = "mount_vibration" {
        amplitude: 0.0007, "m", Some(0.0);
        frequency: 7.0, "Hz", None;
    }
    |noise, levels| {
        levels.mount_amplitude = noise.amplitude;
        levels.mount_frequency = noise.frequency;
    };

    /// Numbers of the rig file are off by a share of themselves.
    WrongRigFile = "wrong_rig_file" {
        object: 0.1, "1", Some(0.0);
        mass: 0.0, "1", Some(0.0);
        tip: 0.0, "1", Some(0.0);
        noise: 0.0, "1", Some(0.0);
    }
    |noise, levels| {
        levels.object_error += noise.object;
        levels.mass_error += noise.mass;
        levels.tip_error += noise.tip;
        levels.camera_noise_error += noise.noise;
    };
}

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
