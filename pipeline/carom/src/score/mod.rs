//! How well a version predicts other strikes than it was fitted to. A table that changed shows here.

mod drift;
mod judge;

pub use self::judge::{drift_unknown, follow_known_strikes, judge};
pub use drift::{Drift, default_model, drift, fitted, moved, step, varies};
