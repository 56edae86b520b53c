//! Tolerances by which the parts of a slide are distinguished, shared by its files.

/// Frames of rest at the end of a track.
pub(super) const FRAMES_AFTER: usize = 5;
/// Surely away from rest, in m and in noise deviations.
pub(super) const SURELY_AWAY: f64 = 0.005;
pub(super) const SURELY_AWAY_NOISE: f64 = 8.0;
/// Surely at the place, in noise deviations.
pub(super) const AT_PLACE_NOISE: f64 = 4.0;
/// Most that may be missing between two frames, in periods: at the impact, whose moment lies between two frames, and later.
pub(super) const GAP_AT_IMPACT: f64 = 3.5;
pub(super) const GAP_LATER: f64 = 15.5;
/// Rest before is looked for in this time before the command rises, in s.
pub(super) const REST_BEFORE: f64 = 0.5;
