//! Whether a value lies in its range.

use crate::WorldError;

/// A finite value within its range, or an error that says so.
pub(crate) fn in_range(
    name: &str,
    value: f64,
    low: f64,
    high: f64,
    unit: &'static str,
) -> Result<(), WorldError> {
    if low <= value && value <= high {
        Ok(())
    } else {
        Err(WorldError::OutOfRange {
            name: name.into(),
            value,
            low,
            high,
            unit,
        })
    }
}
