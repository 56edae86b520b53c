//! The corners of a chessboard, known by the markers about them.

use super::dictionary::Dictionary;
use super::markers::{SQUARE, markers};
use super::plane::Homography;
use super::quads::{Grey, Quad};
use crate::Image;

/// A ChArUco board as OpenCV 4.6 and later draw it: the upper left square is black, and the markers lie in the white ones, numbered row by
/// row.
#[derive(Clone, Debug, PartialEq)]
pub struct Board {
    /// Squares in a row.
    pub columns: usize,
    /// Rows of squares.
    pub rows: usize,
    /// Side of a square in m.
    pub square: f64,
    /// Side of a marker in m.
    pub marker: f64,
    /// The dictionary of its markers.
    pub dictionary: Dictionary,
}

/// What is seen of a board in one image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SeenBoard {
    /// Corners where two black squares meet: along the board from its upper left corner (right, down) in m, and the pixel.
    pub corners: Vec<([f64; 2], [f64; 2])>,
}

/// Predictions of one corner by markers that differ by more than this share of a square are of different boards, or wrong.
const MOST_SPREAD: f64 = 0.25;
/// What refinement looks at: so much less than the white about a marker, in px, and within these limits.
const CLEAR: f64 = 1.0;
const LEAST_REACH: f64 = 2.0;
const MOST_REACH: f64 = 8.0;
/// A corner that is off a plane by more than this (px) beside what most are off is none.
const MOST_OFF: f64 = 1.0;
const MOST_TIMES: f64 = 5.0;

impl Board {
    /// Finds the board's corners in an image; few or none where it is not seen.
    pub fn find(&self, image: &Image) -> SeenBoard {
        let grey = Grey::of(image);
        let share = self.marker / self.square;
        let places = self.markers();
        let mut guesses: Vec<Vec<[f64; 2]>> = vec![Vec::new(); self.columns * self.rows];
        let mut sizes = Vec::new();
        for (id, quad) in markers(&grey, &self.dictionary) {
            let Some(&[column, row]) = places.get(id) else {
                continue;
            };
            let on_board = SQUARE.map(|corner| {
                let at = [column as f64, row as f64];
                [0, 1].map(|i| at[i] + 0.5 + share * (corner[i] - 0.5))
            });
            let pairs: Vec<_> = on_board.into_iter().zip(quad).collect();
            let Some(plane) = Homography::between(&pairs) else {
                continue;
            };
            sizes.push(size(&quad) / share);
            for [right, down] in [[0, 0], [1, 0], [1, 1], [0, 1]] {
                let at = [column + right, row + down];
                if (1..self.columns).contains(&at[0]) && (1..self.rows).contains(&at[1]) {
                    let seen = plane.seen(at.map(|part| part as f64));
                    guesses[at[1] * self.columns + at[0]].push(seen);
                }
            }
        }
        if sizes.is_empty() {
            return SeenBoard::default();
        }
        let square = median(&mut sizes);
        let white = 0.5 * (1.0 - share) * square;
        let reach = (white - CLEAR).clamp(LEAST_REACH, MOST_REACH);
        let mut corners = Vec::new();
        for (index, guesses) in guesses.iter().enumerate() {
            let Some(guess) = agreed(guesses, MOST_SPREAD * square) else {
                continue;
            };
            let at = [index % self.columns, index / self.columns].map(|part| part as f64);
            if let Some(seen) = refined(&grey, guess, reach) {
                corners.push((at.map(|part| part * self.square), seen));
            }
        }
        SeenBoard {
            corners: on_a_plane(corners),
        }
    }

    /// Column and row of each marker's square.
    fn markers(&self) -> Vec<[usize; 2]> {
        let squares = (0..self.rows).flat_map(|row| (0..self.columns).map(move |c| [c, row]));
        squares.filter(|[c, row]| (c + row) % 2 == 1).collect()
    }
}

/// Length of a side, in px.
fn size(quad: &Quad) -> f64 {
    let next = quad.iter().cycle().skip(1);
    let sides = quad.iter().zip(next);
    0.25 * sides
        .map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]))
        .sum::<f64>()
}

fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    let (_, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    *median
}

/// The mean of guesses that agree.
fn agreed(guesses: &[[f64; 2]], spread: f64) -> Option<[f64; 2]> {
    let count = guesses.len() as f64;
    let mean = [0, 1].map(|i| guesses.iter().map(|at| at[i]).sum::<f64>() / count);
    let is_near = |at: &[f64; 2]| (at[0] - mean[0]).hypot(at[1] - mean[1]) < spread;
    (!guesses.is_empty() && guesses.iter().all(is_near)).then_some(mean)
}

/// Rounds of refinement, and the move in px at which it ends.
const ROUNDS: usize = 30;
const DONE: f64 = 1e-3;
/// Gradients about a corner are of this strength at the least (of 255 a px), in both directions.
const LEAST_GRADIENT: f64 = 2.0;

/// The point about a guess from which every gradient stands across (Förstner 1987), as OpenCV's `cornerSubPix`; none where it goes away.
fn refined(grey: &Grey, guess: [f64; 2], reach: f64) -> Option<[f64; 2]> {
    let mut at = guess;
    let steps = reach.round() as i32;
    for _ in 0..ROUNDS {
        let (mut xx, mut xy, mut yy, mut x, mut y, mut all) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        for down in -steps..=steps {
            for right in -steps..=steps {
                let [p, q] = [f64::from(right), f64::from(down)];
                let value = |dx: f64, dy: f64| grey.at([at[0] + p + dx, at[1] + q + dy]);
                let gx = 0.5 * (value(1.0, 0.0)? - value(-1.0, 0.0)?);
                let gy = 0.5 * (value(0.0, 1.0)? - value(0.0, -1.0)?);
                let weight = (-(p * p + q * q) / (reach * reach)).exp();
                all += weight;
                xx += weight * gx * gx;
                xy += weight * gx * gy;
                yy += weight * gy * gy;
                x += weight * gx * (gx * p + gy * q);
                y += weight * gy * (gx * p + gy * q);
            }
        }
        let determinant = xx * yy - xy * xy;
        let weaker = 0.5 * (xx + yy) - (0.25 * (xx - yy).powi(2) + xy * xy).sqrt();
        if weaker < all * LEAST_GRADIENT * LEAST_GRADIENT {
            return None;
        }
        let [right, down] = [yy * x - xy * y, xx * y - xy * x].map(|part| part / determinant);
        at = [at[0] + right, at[1] + down];
        if (at[0] - guess[0]).hypot(at[1] - guess[1]) > reach + CLEAR {
            return None;
        }
        if right.hypot(down) < DONE {
            break;
        }
    }
    Some(at)
}

/// Leaves out corners that are far off where the others' plane has them.
fn on_a_plane(mut corners: Vec<([f64; 2], [f64; 2])>) -> Vec<([f64; 2], [f64; 2])> {
    if let Some(plane) = Homography::between(&corners) {
        let off = |(at, seen): &([f64; 2], [f64; 2])| {
            let there = plane.seen(*at);
            (there[0] - seen[0]).hypot(there[1] - seen[1])
        };
        let most = MOST_OFF + MOST_TIMES * median(&mut corners.iter().map(off).collect::<Vec<_>>());
        corners.retain(|corner| off(corner) <= most);
    }
    corners
}
