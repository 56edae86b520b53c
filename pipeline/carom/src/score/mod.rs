//! How well a version predicts other strikes than it was fitted to. A rig that has drifted shows here.

mod drift;
mod judge;

pub use drift::Drift;
pub use judge::{drift_unknown, follow_known_strikes, judge};
