//! Tolerances by which the parts of a slide are distinguished, shared by its files.

/// Number of frames of rest at the end of a track.
pub(super) const FRAMES_AFTER: usize = 5;
/// Distance at which an object is surely away from rest, in m and in noise deviations.
pub(super) const SURELY_AWAY: f64 = 0.005;
pub(super) const SURELY_AWAY_NOISE: f64 = 8.0;
/// Distance within which an object is surely at a place, in noise deviations.
pub(super) const AT_PLACE_NOISE: f64 = 4.0;
/// Most that may be missing between two frames, in periods: at the impact, whose moment lies between two frames, and later.
pub(super) const GAP_AT_IMPACT: f64 = 3.5;
pub(super) const GAP_LATER: f64 = 15.5;
/// Time, in s, before the command rises in which the rest before is looked for.
pub(super) const REST_BEFORE: f64 = 0.5;
