//! Numbers and directions as words.

/// A share in per cent: whole from 10 % on, with one decimal below.
pub(super) fn percent(share: f64) -> String {
    let percent = 100.0 * share.abs();
    if percent < 9.95 {
        format!("{percent:.1} %")
    } else {
        format!("{percent:.0} %")
    }
}

/// A relative change: "32 % higher" or "32 % lower".
pub(super) fn higher(change: f64) -> String {
    let side = if change < 0.0 { "lower" } else { "higher" };
    format!("{} {side}", percent(change))
}

/// The side of a value that counts to the left.
pub(super) fn side(left: f64) -> &'static str {
    if left < 0.0 { "right" } else { "left" }
}

/// A direction in whole degrees, such as `-12°`.
pub(super) fn degrees(direction: f64) -> String {
    // No "-0": adding 0 takes the sign of a negative zero away.
    format!("{:.0}°", direction.to_degrees().round() + 0.0)
}
