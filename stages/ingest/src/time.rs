//! Stamps, in nanoseconds of a log's clock.

/// Nanoseconds in seconds.
pub(crate) fn seconds(nanoseconds: i64) -> f64 {
    nanoseconds as f64 * 1e-9
}

/// Seconds from one stamp to another.
pub(crate) fn since(from: i64, to: i64) -> f64 {
    seconds(to.saturating_sub(from))
}
