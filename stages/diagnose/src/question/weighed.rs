//! Values over their own scatter and error, clipped.

use nalgebra::DVector;
use values::median;

use super::table::Cell;

/// Robust standard deviations at which a strike is clipped.
const CLIPPED: f64 = 4.0;
/// Median absolute deviation to standard deviation, of a normal distribution.
const NORMAL: f64 = 1.4826;

/// A column with its weights.
pub(super) struct Weighed {
    /// Value over standard deviation, clipped.
    pub(super) values: DVector<f64>,
    /// One over the standard deviation.
    pub(super) weights: DVector<f64>,
    /// Of strikes, robust, in the column's unit.
    pub(super) scatter: f64,
}

/// Values over their own scatter and error, about their median or about none.
pub(super) fn weighed(cells: &[Cell], is_centred: bool) -> Weighed {
    let of = |pick: &dyn Fn(&Cell) -> f64| median(cells.iter().map(pick).collect()).unwrap_or(0.0);
    let middle = of(&|cell| cell.value);
    let total = NORMAL * of(&|cell| (cell.value - middle).abs());
    let error = of(&|cell| cell.error);
    let scatter = (total * total - error * error).max(0.0);
    let weights = DVector::from_iterator(
        cells.len(),
        cells.iter().map(|cell| {
            (scatter + cell.error * cell.error)
                .max(1e-24)
                .sqrt()
                .recip()
        }),
    );
    let from = if is_centred { middle } else { 0.0 };
    let raw: Vec<f64> = cells
        .iter()
        .zip(&weights)
        .map(|(cell, w)| (cell.value - from) * w)
        .collect();
    let middle = median(raw.clone()).unwrap_or(0.0);
    let spread = NORMAL * median(raw.iter().map(|v| (v - middle).abs()).collect()).unwrap_or(0.0);
    let most = CLIPPED * spread.max(1e-12);
    Weighed {
        values: DVector::from_iterator(
            raw.len(),
            raw.iter().map(|v| v.clamp(middle - most, middle + most)),
        ),
        weights,
        scatter: total.max(error),
    }
}
