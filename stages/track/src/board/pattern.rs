//! A marker's pattern, and how white it is seen at a place where the image is blurred.

use statrs::function::erf::erf;

use super::dictionary::Dictionary;

/// The pattern of one marker, its black border among it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pattern {
    pub(crate) across: usize,
    /// Whether each cell is black, row by row.
    black: Vec<bool>,
}

/// How white a place is seen: 0 black to 1 white.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct White {
    pub(crate) value: f64,
    /// How that changes with a cell to the right and downwards, and with the blur's logarithm.
    pub(crate) slope: [f64; 2],
    pub(crate) by_blur: f64,
}

/// A blur reaches so many of its standard deviations.
const REACH: f64 = 3.0;

impl Pattern {
    /// The marker of this number; none where the dictionary has no such.
    pub(crate) fn of(dictionary: &Dictionary, id: usize) -> Option<Self> {
        let (across, code) = (dictionary.across, dictionary.code(id)?);
        let cells = across + 2;
        let is_black = |k: usize| {
            let (row, column) = (k / cells, k % cells);
            let is_border = row == 0 || column == 0 || row + 1 == cells || column + 1 == cells;
            is_border || code >> (across * across - 1 - ((row - 1) * across + column - 1)) & 1 == 0
        };
        Some(Self {
            across: cells,
            black: (0..cells * cells).map(is_black).collect(),
        })
    }

    pub(crate) fn is_black(&self, column: usize, row: usize) -> bool {
        self.black[row * self.across + column]
    }

    /// How white it is seen at a place (in cells, right and down from its upper left corner) under a Gaussian blur (standard deviation in
    /// cells). Around it all is white.
    pub(crate) fn white(&self, [right, down]: [f64; 2], blur: f64) -> White {
        let columns = self.shares(right, blur);
        let rows = self.shares(down, blur);
        let mut white = White {
            value: 1.0,
            ..White::default()
        };
        for &(row, [b, b_moved, b_blurred]) in &rows.parts[..rows.count] {
            for &(column, [a, a_moved, a_blurred]) in &columns.parts[..columns.count] {
                if self.is_black(column, row) {
                    white.value -= a * b;
                    white.slope[0] -= a_moved * b;
                    white.slope[1] -= a * b_moved;
                    white.by_blur -= a_blurred * b + a * b_blurred;
                }
            }
        }
        white
    }

    /// The share of a place's blur that each cell of a row takes.
    pub(crate) fn shares(&self, at: f64, blur: f64) -> Shares {
        let limit = |cell: f64| cell.clamp(0.0, self.across as f64) as usize;
        let first = limit((at - REACH * blur).floor());
        let last = limit((at + REACH * blur).ceil()).min(first + MOST);
        let mut shares = Shares {
            parts: [(0, [0.0; 3]); MOST],
            count: 0,
        };
        let mut before = edge(at - first as f64, blur);
        for cell in first..last {
            let behind = edge(at - (cell + 1) as f64, blur);
            shares.parts[shares.count] = (cell, [0, 1, 2].map(|i| before[i] - behind[i]));
            shares.count += 1;
            before = behind;
        }
        shares
    }
}

/// Cells that a blur reaches at the most, in a row.
const MOST: usize = 9;

/// Shares of the cells of a row, each with its slopes along the row and by the logarithm of the blur.
pub(crate) struct Shares {
    pub(crate) parts: [(usize, [f64; 3]); MOST],
    pub(crate) count: usize,
}

/// A blurred edge at 0 seen from a place: its value, 0 to 1, its slope, and how it changes with the blur's logarithm.
fn edge(at: f64, blur: f64) -> [f64; 3] {
    let z = at / blur;
    let density = (-0.5 * z * z).exp() / (std::f64::consts::TAU.sqrt() * blur);
    let value = 0.5 * (1.0 + erf(z * std::f64::consts::FRAC_1_SQRT_2));
    [value, density, -density * at]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_blurred_pattern_has_the_slopes_that_it_says() {
        let dictionary = Dictionary::named("DICT_4X4_50").expect("known");
        let pattern = Pattern::of(&dictionary, 7).expect("there");
        assert_eq!(Pattern::of(&dictionary, 50), None);
        assert!((pattern.white([-4.0, 3.0], 0.4).value - 1.0).abs() < 1e-9);
        assert!(
            pattern.white([0.5, 0.5], 0.1).value < 1e-3,
            "the border is black"
        );
        for at in [[1.3, 2.6], [0.1, 5.9], [3.0, 3.2]] {
            let white = |right: f64, down: f64, blur: f64| {
                pattern.white([at[0] + right, at[1] + down], 0.5 * blur.exp())
            };
            let step = 1e-4;
            let slope = |a: White, b: White| (a.value - b.value) / (2.0 * step);
            let seen = white(0.0, 0.0, 0.0);
            let right = slope(white(step, 0.0, 0.0), white(-step, 0.0, 0.0));
            let down = slope(white(0.0, step, 0.0), white(0.0, -step, 0.0));
            let blurred = slope(white(0.0, 0.0, step), white(0.0, 0.0, -step));
            // Cells beyond the blur's reach are left out.
            assert!((seen.slope[0] - right).abs() < 2e-2, "{seen:?} {right}");
            assert!((seen.slope[1] - down).abs() < 2e-2, "{seen:?} {down}");
            assert!((seen.by_blur - blurred).abs() < 2e-2, "{seen:?} {blurred}");
        }
    }
}
