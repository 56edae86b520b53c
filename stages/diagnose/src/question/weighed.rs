//! Values over their own scatter and error, clipped.

use nalgebra::DVector;
use values::median;

use super::table::Cell;

/// Robust standard deviations at which a strike is clipped.
const CLIPPED: f64 = 4.0;
/// Median absolute deviation to standard deviation, of a normal distribution.
const NORMAL: f64 = 1.4826;

/// Strikes of all sessions that count beside those of one in its scatter: so many have a robust standard deviation that is known to a third.
const BESIDE: f64 = 12.0;

/// For each value, the ratio of its session's scatter to that of all within sessions.
fn by_session(values: &[f64], sessions: &[usize]) -> DVector<f64> {
    let count = sessions.iter().max().map_or(0, |last| last + 1);
    let own = |s: usize| values.iter().zip(sessions).filter(move |(_, of)| **of == s);
    let middles: Vec<f64> = (0..count)
        .map(|s| median(own(s).map(|(v, _)| *v).collect()).unwrap_or(0.0))
        .collect();
    let away = values
        .iter()
        .zip(sessions)
        .map(|(v, s)| (v - middles[*s]).abs());
    let of_all = median(away.collect()).unwrap_or(0.0).max(1e-12);
    let factors: Vec<f64> = (0..count)
        .map(|s| {
            let away: Vec<f64> = own(s).map(|(v, _)| (v - middles[s]).abs()).collect();
            let n = away.len() as f64;
            let ratio = median(away).unwrap_or(of_all) / of_all;
            ((n * ratio * ratio + BESIDE) / (n + BESIDE)).sqrt()
        })
        .collect();
    DVector::from_iterator(values.len(), sessions.iter().map(|s| factors[*s]))
}

/// A column with its weights.
pub(super) struct Weighed {
    /// Value over standard deviation, clipped.
    pub(super) values: DVector<f64>,
    /// What clipping took of each.
    pub(super) clipped: DVector<f64>,
    /// One over the standard deviation.
    pub(super) weights: DVector<f64>,
    /// Robust standard deviation of the strikes, in the column's unit.
    pub(super) scatter: f64,
}

/// Values over their own scatter and error, about their median or about none. Strikes are exchanged for one another, so that those of
/// each session, by its number, are over that session's own scatter: some scatter by twice what others do.
pub(super) fn weighed(cells: &[Cell], sessions: &[usize], is_centred: bool) -> Weighed {
    let of = |pick: &dyn Fn(&Cell) -> f64| median(cells.iter().map(pick).collect()).unwrap_or(0.0);
    let middle = of(&|cell| cell.value);
    let total = NORMAL * of(&|cell| (cell.value - middle).abs());
    let error = of(&|cell| cell.error);
    let scatter = (total * total - error * error).max(0.0);
    let alike: Vec<f64> = cells
        .iter()
        .map(|cell| {
            (scatter + cell.error * cell.error)
                .max(1e-24)
                .sqrt()
                .recip()
        })
        .collect();
    let whole: Vec<f64> = cells.iter().zip(&alike).map(|(c, w)| c.value * w).collect();
    let weights = DVector::from_vec(alike).component_div(&by_session(&whole, sessions));
    let from = if is_centred { middle } else { 0.0 };
    let raw: Vec<f64> = cells
        .iter()
        .zip(&weights)
        .map(|(cell, w)| (cell.value - from) * w)
        .collect();
    let middle = median(raw.clone()).unwrap_or(0.0);
    let spread = NORMAL * median(raw.iter().map(|v| (v - middle).abs()).collect()).unwrap_or(0.0);
    let most = CLIPPED * spread.max(1e-12);
    let raw = DVector::from_vec(raw);
    let values = raw.map(|v| v.clamp(middle - most, middle + most));
    Weighed {
        clipped: raw - &values,
        values,
        weights,
        scatter: total.max(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strikes_of_a_session_are_over_its_own_scatter() {
        let n = 120;
        // Steps of the golden ratio cover (-1, 1) evenly.
        let even = |i: usize| 2.0 * (i as f64 * 0.618_033_988_75).fract() - 1.0;
        let cell = |value| Cell { value, error: 0.0 };
        let cells: Vec<Cell> = (0..n)
            .map(|i| cell(even(i) * if i < n / 2 { 1.0 } else { 3.0 }))
            .collect();
        let of = |sessions: &[usize]| weighed(&cells, sessions, true).weights;
        let together = of(&vec![0; n]);
        assert!(together.iter().all(|w| *w == together[0]));
        let apart = of(&(0..n).map(|i| i / (n / 2)).collect::<Vec<_>>());
        let ratio = apart[0] / apart[n - 1];
        assert!((2.0..3.0).contains(&ratio), "{ratio}");
    }
}
