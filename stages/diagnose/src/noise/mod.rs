//! The noise of a table, beside the scatter of strikes ([`crate::mixed`]): camera errors that are correlated from frame to
//! frame, stamps that jitter, and frames that are no measurement at all.
//!
//! Along and across a strike's heading, in units of the camera's variance σ²: R_along = ρ^|k−l| + κ²·v_k²·δ_kl and
//! R_across = ρ^|k−l|, with k the number of the frame, lost frames counted, v_k its speed and κ the jitter of a stamp over σ.
//! ρ and κ are estimated once on the world without effects, and again after an effect was added; they are then the same for
//! every candidate.

mod estimate;
mod outliers;
mod whitening;

pub(crate) use estimate::{FIRST_SEARCH, REFINEMENT, Search, estimate};
pub(crate) use outliers::{Rule, kept_frames};
pub(crate) use whitening::Whitening;

use values::{Point, Strike};

/// Correlation and jitter, common to all strikes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrameNoise {
    /// ρ: correlation of a centroid's error with that of the frame before.
    pub(crate) correlation: f64,
    /// κ: standard deviation of a stamp over that of a centroid's coordinate, in s/m.
    pub(crate) jitter: f64,
}

impl FrameNoise {
    /// Independent errors, exact stamps.
    pub(crate) const WHITE: Self = Self {
        correlation: 0.0,
        jitter: 0.0,
    };
}

/// Number of frames whose mean is a resting place.
const RESTING_FRAMES: f64 = 10.0;

/// Standard deviation of a resting place over that of a centroid's coordinate: correlated errors average out less.
pub(crate) fn resting(noise: FrameNoise) -> f64 {
    let correlation = noise.correlation;
    ((1.0 + correlation) / (1.0 - correlation) / RESTING_FRAMES)
        .min(1.0)
        .sqrt()
}

/// What whitening needs of one strike.
#[derive(Clone, Debug)]
pub(crate) struct Frames {
    /// Unit vector from rest to rest.
    pub(crate) heading: Point,
    /// Frames since the frame before, 1 where none was lost.
    pub(crate) gaps: Vec<f64>,
    /// Speed at each frame, in m/s.
    pub(crate) speeds: Vec<f64>,
    /// Whether each frame is used.
    pub(crate) kept: Vec<bool>,
}

impl Frames {
    /// All frames of a strike, speeds at zero, of a camera that takes one every `frame` s.
    pub(crate) fn new(strike: &Strike, frame: f64) -> Self {
        let path = strike.path();
        let heading = if path.norm() > 1e-6 {
            path * path.norm().recip()
        } else {
            Point::polar(1.0, strike.command.angle)
        };
        let t = &strike.track.t;
        let gap = |k: usize| ((t[k] - t[k - 1]) / frame).round().max(1.0);
        Self {
            heading,
            gaps: (0..t.len())
                .map(|k| if k == 0 { 1.0 } else { gap(k) })
                .collect(),
            speeds: vec![0.0; t.len()],
            kept: vec![true; t.len()],
        }
    }
}
