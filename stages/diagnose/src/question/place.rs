//! Questions about the place on the way: the pushes of a strike's fifths are one vector; vectors are exchanged, places stay.

use values::Point;

use super::{
    families::{PERMUTED, Shuffles, Statistic},
    table::{Cell, HATS, Row},
    weighed::weighed,
};

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
