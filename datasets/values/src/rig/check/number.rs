//! Checks of single numbers.

use super::super::RigError;
use crate::Interval;

pub(super) fn interval(key: &str, interval: Interval) -> Result<(), RigError> {
    finite(key, interval.low)?;
    finite(key, interval.high)?;
    if interval.low < interval.high {
        return Ok(());
    }
    let why = if interval.low > interval.high {
        "is reversed"
    } else {
        "is empty"
    };
    Err(RigError::Value {
        key: key.into(),
        value: format!("[{}, {}]", interval.low, interval.high),
        why: format!("the interval {why}; write [low, high] with low < high"),
    })
}

/// The largest number that makes sense, its unit, and what else it may have been stated in.
pub(super) type Largest = (f64, &'static str, &'static str);

pub(super) fn positive(
    key: &str,
    number: f64,
    (largest, unit, hint): Largest,
) -> Result<(), RigError> {
    finite(key, number)?;
    if number <= 0.0 {
        return Err(value(key, number, &format!("must be above 0 {unit}")));
    }
    if number > largest {
        let why = format!("must be at most {largest} {unit} ({hint})");
        return Err(value(key, number, &why));
    }
    Ok(())
}

pub(super) fn finite(key: &str, number: f64) -> Result<(), RigError> {
    if number.is_finite() {
        Ok(())
    } else {
        Err(value(key, number, "must be a finite number"))
    }
}

pub(super) fn value(key: &str, number: f64, why: &str) -> RigError {
    RigError::Value {
        key: key.into(),
        value: number.to_string(),
        why: why.into(),
    }
}
