//! What differs from strike to strike, and by how much.

use nalgebra::SMatrix;

use crate::noise::{self, FrameNoise};

/// Speed (logarithm), angle, clock, resting x, resting y, friction (logarithm).
pub(crate) const NUISANCES: usize = 6;
/// Places among them whose standard deviations are estimated.
pub(crate) const ESTIMATED: [usize; 3] = [SPEED, ANGLE, FRICTION];
/// Places of speed, angle and friction.
pub(crate) const SPEED: usize = 0;
pub(crate) const ANGLE: usize = 1;
pub(crate) const FRICTION: usize = 5;

pub(super) type Small = SMatrix<f64, NUISANCES, NUISANCES>;

/// Standard deviations of a strike's nuisances and of the camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VarianceComponents {
    /// Relative speed, angle (rad), clock (s), resting x and y (m), relative friction.
    pub(crate) nuisance: [f64; NUISANCES],
    /// Standard deviation of a centroid's coordinate, in m.
    pub(crate) camera: f64,
    /// Standard deviation of the wander of friction from the first strike to the last, relative.
    pub(crate) wander: f64,
    /// Upper bound of `wander`.
    pub(super) greatest_wander: f64,
    /// Standard deviation of a resting place over that of a centroid's coordinate.
    pub(super) resting: f64,
}

/// Prior standard deviation of a strike's clock, in frames: all but free. First motion is seen later where the object is slow, the camera noisy or a
/// frame lost, and a prior that pulled clocks together would turn that into speeds that depend on speed.
const CLOCK_FRAMES: f64 = 2.0;
/// Scatter of speed, angle and friction from which the estimate starts, and the greatest that a robot and a table have: what
/// differs more from strike to strike is no scatter but something that is missing, and must not be weighed down as if it were.
const START: f64 = 0.01;
pub(crate) const GREATEST: f64 = 0.12;
/// Scatter that shows in no track: changes below it are no changes.
pub(super) const NEGLIGIBLE: f64 = 1e-3;
/// Least standard deviation, which keeps variances from zero.
pub(super) const LEAST: f64 = 1e-5;

impl VarianceComponents {
    /// Where estimation starts: camera noise in m, time from frame to frame in s, upper bound of the wander (relative).
    pub(crate) fn initial(camera: f64, frame: f64, greatest_wander: f64) -> Self {
        let mut components = Self {
            nuisance: [START, START, CLOCK_FRAMES * frame, 0.0, 0.0, START],
            camera,
            wander: START.min(greatest_wander),
            greatest_wander,
            resting: 0.0,
        };
        components.set_resting(FrameNoise::WHITE);
        components
    }

    /// These components, the scatter of resting places set for this camera noise.
    pub(crate) fn under(mut self, noise: FrameNoise) -> Self {
        self.set_resting(noise);
        self
    }

    /// These components with this upper bound on the standard deviation of the wander (relative).
    pub(crate) fn with_greatest_wander(mut self, greatest_wander: f64) -> Self {
        self.greatest_wander = greatest_wander;
        self
    }

    fn set_resting(&mut self, noise: FrameNoise) {
        self.resting = noise::resting(noise);
        let rest = self.camera * self.resting;
        (self.nuisance[3], self.nuisance[4]) = (rest, rest);
    }

    /// Whether the standard deviation of this nuisance is at its upper bound.
    pub(crate) fn is_at_bound(&self, place: usize) -> bool {
        ESTIMATED.contains(&place) && self.nuisance[place] > 0.999 * GREATEST
    }
}
