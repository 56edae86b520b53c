//! Questions about the place on the way: the pushes of a strike's fifths are one vector; vectors are exchanged, places stay.

use nalgebra::DVector;
use values::{Point, median};

use super::families::{PERMUTED, Shuffles, Statistic};
use super::table::{Cell, HATS, Row};

/// Side of a cell of the table, in m; a wider table has wider cells.
const SIDE: f64 = 0.07;
const MOST_CELLS: f64 = 60.0;
/// Products of powers of x and y up to this degree.
const DEGREE: i32 = 3;

/// The pushes of all strikes along or across their ways, by fifth of a way: weighed, each fifth's median over all strikes taken off.
pub(super) struct Pushes {
    /// A row of fifths for each strike.
    values: Vec<[f64; HATS]>,
    weights: Vec<[f64; HATS]>,
    /// The weighed pushes, each fifth's median over all strikes left in.
    pub(super) whole: Vec<[f64; HATS]>,
    /// Sum of squared weights.
    pub(super) weight: f64,
}

impl Pushes {
    pub(super) fn new(
        rows: &[Row],
        sessions: &[usize],
        of: impl Fn(&Row) -> &[Cell; HATS],
    ) -> Self {
        let mut values = vec![[0.0; HATS]; rows.len()];
        let mut weights = values.clone();
        let mut whole = values.clone();
        let mut weight = 0.0;
        for k in 0..HATS {
            let cells: Vec<Cell> = rows.iter().map(|row| of(row)[k]).collect();
            let centred = weighed(&cells, sessions, true);
            let weighed = weighed(&cells, sessions, false);
            for i in 0..rows.len() {
                values[i][k] = centred.values[i];
                weights[i][k] = centred.weights[i];
                whole[i][k] = weighed.values[i];
                weight += centred.weights[i].powi(2);
            }
        }
        Self {
            values,
            weights,
            whole,
            weight,
        }
    }

    /// How smooth functions of the place, and its cells, show.
    pub(super) fn asked(&self, places: &[[Point; HATS]], shuffles: &Shuffles) -> [Statistic; 2] {
        let smooth = self.smooth(places);
        let cells = cells(places);
        let count = cells.iter().flatten().max().map_or(0, |last| last + 1);
        let mut seen = vec![1e-12; count];
        for (cells, weights) in cells.iter().zip(&self.weights) {
            for (cell, weight) in cells.iter().zip(weights) {
                seen[*cell] += weight * weight;
            }
        }
        let functions = smooth.len();
        // By strike and fifth, all functions together.
        let turned: Vec<Vec<f64>> = (0..places.len() * HATS)
            .map(|at| smooth.iter().map(|f| f[at]).collect())
            .collect();
        let ask = |from: &dyn Fn(usize) -> usize| {
            let (mut sums, mut by_cell) = (vec![0.0; functions], vec![0.0; count]);
            for i in 0..places.len() {
                let values = &self.values[from(i)];
                for k in 0..HATS {
                    for (sum, f) in sums.iter_mut().zip(&turned[i * HATS + k]) {
                        *sum += f * values[k];
                    }
                    by_cell[cells[i][k]] += self.weights[i][k] * values[k];
                }
            }
            let by_cell = by_cell.iter().zip(&seen).map(|(s, seen)| s * s / seen);
            (
                sums.iter().map(|s| s * s).sum::<f64>(),
                by_cell.sum::<f64>(),
            )
        };
        let mut asked = [
            Vec::with_capacity(1 + PERMUTED),
            Vec::with_capacity(1 + PERMUTED),
        ];
        let mut push = |(smooth, cells): (f64, f64)| {
            asked[0].push(smooth);
            asked[1].push(cells);
        };
        push(ask(&|i| i));
        for order in &shuffles.orders {
            push(ask(&|i| order[i] as usize));
        }
        asked
    }

    /// Orthonormal weighed functions of the place, without what they show of each fifth of all strikes.
    fn smooth(&self, places: &[[Point; HATS]]) -> Vec<nalgebra::DVector<f64>> {
        let all: Vec<Point> = places.iter().flatten().copied().collect();
        let (middle, half) = extent(&all);
        let n = all.len();
        let weight = |at: usize| self.weights[at / HATS][at % HATS];
        let of_fifth = |k: usize| {
            nalgebra::DVector::from_fn(n, |at, _| if at % HATS == k { weight(at) } else { 0.0 })
        };
        let basis = super::projection::Basis::new((0..HATS).map(of_fifth));
        let powers = (0..=DEGREE).flat_map(|a| (0..=DEGREE - a).map(move |b| (a, b)));
        let functions = powers.filter(|(a, b)| a + b > 0).map(|(a, b)| {
            nalgebra::DVector::from_fn(n, |at, _| {
                let place = all[at] - middle;
                weight(at) * (place.x / half.x).powi(a) * (place.y / half.y).powi(b)
            })
        });
        basis.beside(functions)
    }
}

fn extent(all: &[Point]) -> (Point, Point) {
    let range = |of: fn(&Point) -> f64| {
        let each = all.iter().map(of);
        each.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(v), h.max(v))
        })
    };
    let ((left, right), (near, far)) = (range(|p| p.x), range(|p| p.y));
    let half = |low: f64, high: f64| (0.5 * (high - low)).max(1e-6);
    (
        Point::new(0.5 * (left + right), 0.5 * (near + far)),
        Point::new(half(left, right), half(near, far)),
    )
}

/// The cell of each place.
fn cells(places: &[[Point; HATS]]) -> Vec<[usize; HATS]> {
    let all: Vec<Point> = places.iter().flatten().copied().collect();
    let (middle, half) = extent(&all);
    let side = SIDE.max((4.0 * half.x * half.y / MOST_CELLS).sqrt());
    let wide = (2.0 * half.x / side).ceil().max(1.0) as usize;
    let cell = |at: &Point| {
        let place = *at - middle + half;
        let along = |v: f64| (v / side).max(0.0) as usize;
        along(place.x).min(wide) + (wide + 1) * along(place.y)
    };
    places
        .iter()
        .map(|each| std::array::from_fn(|k| cell(&each[k])))
        .collect()
}

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
