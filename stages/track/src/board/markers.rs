//! Markers of a dictionary in an image.

use std::collections::BTreeMap;

use super::dictionary::Dictionary;
use super::plane::Homography;
use super::quads::{Grey, Quad, dark_quads};

/// Black and white of a marker differ by this much at the least, of 255.
const LEAST_CONTRAST: f64 = 30.0;
/// Most cells of a marker's black border that may be seen white.
const MOST_WHITE: usize = 1;
/// The corners of a square, clockwise from the upper left.
pub(crate) const SQUARE: Quad = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

/// The markers that are seen, by number: their corners in px, clockwise from what is printed as the upper left.
pub(crate) fn markers(grey: &Grey, dictionary: &Dictionary) -> BTreeMap<usize, Quad> {
    let mut markers = BTreeMap::new();
    for quad in dark_quads(grey) {
        if let Some((id, quad)) = marker(grey, dictionary, quad) {
            markers.entry(id).or_insert(quad);
        }
    }
    markers
}

/// The brightness of each of a marker's cells, its border among them, row by row; none where it is cut by the image's border.
pub(crate) fn cell_lights(grey: &Grey, quad: &Quad, cells: usize) -> Option<Vec<f64>> {
    let pairs: Vec<_> = SQUARE.into_iter().zip(*quad).collect();
    let plane = Homography::between(&pairs)?;
    let mut light = Vec::with_capacity(cells * cells);
    for row in 0..cells {
        for column in 0..cells {
            // Five places of the cell, away from its edges.
            let spots = [[0.5, 0.5], [0.3, 0.3], [0.7, 0.3], [0.3, 0.7], [0.7, 0.7]];
            let mut sum = 0.0;
            for [x, y] in spots {
                let at = [column as f64 + x, row as f64 + y].map(|part| part / cells as f64);
                sum += grey.at(plane.seen(at))?;
            }
            light.push(sum / spots.len() as f64);
        }
    }
    Some(light)
}

fn marker(grey: &Grey, dictionary: &Dictionary, quad: Quad) -> Option<(usize, Quad)> {
    let cells = dictionary.across + 2;
    let light = cell_lights(grey, &quad, cells)?;
    let least = light.iter().copied().fold(f64::INFINITY, f64::min);
    let most = light.iter().copied().fold(0.0, f64::max);
    if most - least < LEAST_CONTRAST {
        return None;
    }
    let (mut bits, mut white) = (0u64, 0);
    for (index, light) in light.into_iter().enumerate() {
        let is_white = light > 0.5 * (least + most);
        let (row, column) = (index / cells, index % cells);
        let is_border = row == 0 || column == 0 || row + 1 == cells || column + 1 == cells;
        if is_border {
            white += usize::from(is_white);
        } else {
            bits = (bits << 1) | u64::from(is_white);
        }
    }
    if white > MOST_WHITE {
        return None;
    }
    let (id, quarters) = dictionary.find(bits)?;
    // What is seen as the first corner is, when turned clockwise, so many corners further.
    let upright = std::array::from_fn(|corner| quad[(corner + 4 - quarters) % 4]);
    Some((id, upright))
}
