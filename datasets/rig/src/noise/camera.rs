//! Noise of the camera and of its stamps.

use super::levels::{Disturbs, Levels};
use crate::declare::declare;

declare! {
    /// Camera noise is correlated from frame to frame (autoregressive of first order, the same standard deviation).
    CameraCorrelation = "camera_correlation" {
        /// Autocorrelation of neighbouring frames.
        rho: 0.6, "1", Some(0.0);
    }
}

impl Disturbs for CameraCorrelation {
    fn add_to(&self, levels: &mut Levels) {
        levels.camera_correlation = self.rho.clamp(0.0, 0.99);
    }
}

declare! {
    /// Camera noise has heavy tails: a t distribution of three degrees of freedom with the same standard deviation.
    CameraTails = "camera_tails" {
        /// Above 0: on.
        on: 1.0, "1", Some(0.0);
    }
}

impl Disturbs for CameraTails {
    fn add_to(&self, levels: &mut Levels) {
        levels.camera_tails |= self.on > 0.0;
    }
}

declare! {
    /// Stamps are late by an exponential delay, as those that a driver gives on arrival.
    LateStamps = "late_stamps" {
        /// Mean delay, in s.
        mean: 0.003, "s", Some(0.0);
    }
}

impl Disturbs for LateStamps {
    fn add_to(&self, levels: &mut Levels) {
        levels.stamp_delay += self.mean;
    }
}

declare! {
    /// Stamps scatter about the time of exposure.
    JitteringStamps = "jittering_stamps" {
        /// Standard deviation, in s.
        sd: 0.003, "s", Some(0.0);
    }
}

impl Disturbs for JitteringStamps {
    fn add_to(&self, levels: &mut Levels) {
        levels.stamp_jitter = levels.stamp_jitter.hypot(self.sd);
    }
}

declare! {
    /// In some frames something else is taken for the object.
    StrayFrames = "stray_frames" {
        /// Share of frames.
        share: 0.01, "1", Some(0.0);
        /// How far from the object at the most, in m.
        distance: 0.10, "m", None;
    }
}

impl Disturbs for StrayFrames {
    fn add_to(&self, levels: &mut Levels) {
        levels.stray_share += self.share;
        levels.stray_distance = levels.stray_distance.max(self.distance);
    }
}

declare! {
    /// Places are reported on a grid, as whole pixels are.
    QuantisedPlaces = "quantised_places" {
        /// In m.
        step: 0.002, "m", Some(0.0);
    }
}

impl Disturbs for QuantisedPlaces {
    fn add_to(&self, levels: &mut Levels) {
        levels.place_step = levels.place_step.max(self.step);
    }
}

declare! {
    /// Stamps are whole ticks of a coarse clock.
    QuantisedStamps = "quantised_stamps" {
        /// In s.
        step: 0.004, "s", Some(0.0);
    }
}

impl Disturbs for QuantisedStamps {
    fn add_to(&self, levels: &mut Levels) {
        levels.stamp_step = levels.stamp_step.max(self.step);
    }
}

declare! {
    /// In some strikes all frames of a while are lost.
    LostBursts = "lost_bursts" {
        /// Share of strikes.
        share: 0.3, "1", Some(0.0);
        /// How long at the most, in s.
        longest: 0.3, "s", None;
    }
}

impl Disturbs for LostBursts {
    fn add_to(&self, levels: &mut Levels) {
        levels.burst_share += self.share;
        levels.burst_longest = levels.burst_longest.max(self.longest);
    }
}

declare! {
    /// The camera's view ends: what lies beyond is in no frame.
    NarrowView = "narrow_view" {
        /// One over the largest x that is seen, in 1/m.
        narrowness: 1.4, "1/m", Some(0.0);
    }
}

impl Disturbs for NarrowView {
    fn add_to(&self, levels: &mut Levels) {
        levels.view_narrowness = levels.view_narrowness.max(self.narrowness);
    }
}

declare! {
    /// A rolling shutter: rows of the picture are exposed one after another, so that a place is seen later the farther it lies.
    RollingShutter = "rolling_shutter" {
        /// Time from one place to another that lies 1 m farther, in s.
        readout: 0.015, "s", Some(0.0);
        /// Direction in which rows follow each other, in rad.
        bearing: 0.0, "rad", None;
    }
}

impl Disturbs for RollingShutter {
    fn add_to(&self, levels: &mut Levels) {
        levels.readout = values::Point::polar(self.readout, self.bearing);
    }
}

declare! {
    /// The camera's mount vibrates, in a direction and with a phase of its own in each strike.
    MountVibration = "mount_vibration" {
        /// Amplitude on the table, in m.
        amplitude: 0.0007, "m", Some(0.0);
        /// In Hz.
        frequency: 7.0, "Hz", None;
    }
}

impl Disturbs for MountVibration {
    fn add_to(&self, levels: &mut Levels) {
        levels.mount_amplitude = self.amplitude;
        levels.mount_frequency = self.frequency;
    }
}
