//! Dark quads before something bright: what may be a marker.

use crate::Image;

/// An image's brightness.
#[derive(Clone, Debug)]
pub(crate) struct Grey {
    pub(crate) width: usize,
    pub(crate) height: usize,
    values: Vec<u8>,
}

/// Four corners in px, clockwise as they are seen.
pub(crate) type Quad = [[f64; 2]; 4];

impl Grey {
    pub(crate) fn of(image: &Image) -> Self {
        // Weights of ITU-R BT.601 in parts of 256.
        let grey = |rgb: &[u8]| {
            let [r, g, b] = [rgb[0], rgb[1], rgb[2]].map(u32::from);
            ((77 * r + 150 * g + 29 * b) >> 8) as u8
        };
        Self {
            width: image.width,
            height: image.height,
            values: image.rgb.chunks_exact(3).map(grey).collect(),
        }
    }

    /// The brightness between pixels, bilinear; none outside.
    pub(crate) fn at(&self, [x, y]: [f64; 2]) -> Option<f64> {
        let (column, row) = (x.floor(), y.floor());
        let is_in = column >= 0.0
            && row >= 0.0
            && column + 1.0 < self.width as f64
            && row + 1.0 < self.height as f64;
        if !is_in {
            return None;
        }
        let (a, b) = (x - column, y - row);
        let at = row as usize * self.width + column as usize;
        let value = |at: usize| f64::from(self.values[at]);
        let upper = value(at) * (1.0 - a) + value(at + 1) * a;
        let lower = value(at + self.width) * (1.0 - a) + value(at + self.width + 1) * a;
        Some(upper * (1.0 - b) + lower * b)
    }

    /// Pixels that are darker by `DARKER` than the mean of a square of `2 × reach + 1` about them.
    fn dark(&self, reach: usize) -> Vec<bool> {
        let (width, height) = (self.width, self.height);
        let mut sums = vec![0u64; (width + 1) * (height + 1)];
        for row in 0..height {
            let mut line = 0;
            for column in 0..width {
                line += u64::from(self.values[row * width + column]);
                sums[(row + 1) * (width + 1) + column + 1] =
                    sums[row * (width + 1) + column + 1] + line;
            }
        }
        let mut dark = Vec::with_capacity(width * height);
        for row in 0..height {
            let (top, bottom) = (row.saturating_sub(reach), (row + reach + 1).min(height));
            for column in 0..width {
                let (left, right) = (
                    column.saturating_sub(reach),
                    (column + reach + 1).min(width),
                );
                let at = |row: usize, column: usize| sums[row * (width + 1) + column];
                let sum = at(bottom, right) + at(top, left) - at(top, right) - at(bottom, left);
                let area = ((bottom - top) * (right - left)) as u64;
                let value = u64::from(self.values[row * width + column]) + DARKER;
                dark.push(value * area < sum);
            }
        }
        dark
    }
}

/// What is dark is darker than around by this much, of 255.
const DARKER: u64 = 7;
/// Reaches of the squares, as shares of the image's longer side: small and large markers.
const REACHES: [f64; 2] = [0.05, 0.015];
/// Least length of a side, in px.
const LEAST_SIDE: f64 = 10.0;
/// Least share of its hull that a quad fills.
const FILLS: f64 = 0.88;

/// The dark quads of an image, some of them twice.
pub(crate) fn dark_quads(grey: &Grey) -> Vec<Quad> {
    let longer = grey.width.max(grey.height) as f64;
    let mut quads = Vec::new();
    for reach in REACHES {
        let dark = grey.dark((reach * longer).ceil() as usize);
        let found = hulls(dark, grey.width).into_iter();
        quads.extend(found.filter_map(|hull| quad(&hull)));
    }
    quads
}

/// The convex hulls of what is dark and touches, without what lies at the border.
fn hulls(mut dark: Vec<bool>, width: usize) -> Vec<Vec<[f64; 2]>> {
    let height = dark.len() / width;
    let (mut hulls, mut open, mut pixels) = (Vec::new(), Vec::new(), Vec::new());
    for start in 0..dark.len() {
        if !dark[start] {
            continue;
        }
        let mut is_at_border = false;
        pixels.clear();
        open.push(start);
        dark[start] = false;
        while let Some(at) = open.pop() {
            let (column, row) = (at % width, at / width);
            pixels.push((row, column));
            if column == 0 || row == 0 || column + 1 == width || row + 1 == height {
                is_at_border = true;
                continue;
            }
            for next in [at - 1, at + 1, at - width, at + width] {
                if dark[next] {
                    dark[next] = false;
                    open.push(next);
                }
            }
        }
        let is_large = pixels.len() as f64 > LEAST_SIDE * LEAST_SIDE / 2.0;
        if is_large && !is_at_border {
            pixels.sort_unstable();
            hulls.push(hull(&pixels));
        }
    }
    hulls
}

/// The convex hull of pixels in order (Andrew's monotone chain), counter-clockwise in rows and columns.
fn hull(pixels: &[(usize, usize)]) -> Vec<[f64; 2]> {
    let mut hull: Vec<[f64; 2]> = Vec::new();
    let points = |(row, column): &(usize, usize)| [*column as f64, *row as f64];
    let forth = pixels.iter().map(points);
    let back = pixels.iter().rev().map(points);
    let mut kept = 0;
    for (is_back, at) in forth.map(|at| (false, at)).chain(back.map(|at| (true, at))) {
        if is_back && kept == 0 {
            kept = hull.len() - 1;
        }
        while hull.len() >= kept + 2 && turn(hull[hull.len() - 2], hull[hull.len() - 1], at) <= 0.0
        {
            hull.pop();
        }
        hull.push(at);
    }
    hull.pop();
    hull
}

/// Twice the area of a triangle, with a sign.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn area(polygon: &[[f64; 2]]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    let cross = polygon.iter().zip(next);
    0.5 * cross.map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
}

/// The quad that fills a hull, if one does: two opposite corners are farthest apart, the others farthest from the line between.
fn quad(hull: &[[f64; 2]]) -> Option<Quad> {
    let count = hull.len() as f64;
    let middle = [0, 1].map(|i| hull.iter().map(|at| at[i]).sum::<f64>() / count);
    let far = |from: [f64; 2]| {
        let distance = move |at: &[f64; 2]| (at[0] - from[0]).hypot(at[1] - from[1]);
        let points = hull.iter().copied();
        points.max_by(|a, b| distance(a).total_cmp(&distance(b)))
    };
    let first = far(middle)?;
    let third = far(first)?;
    let off = |at: &[f64; 2]| turn(first, third, *at);
    let second = hull
        .iter()
        .copied()
        .min_by(|a, b| off(a).total_cmp(&off(b)))?;
    let fourth = hull
        .iter()
        .copied()
        .max_by(|a, b| off(a).total_cmp(&off(b)))?;
    // Clockwise where rows run down.
    let quad = [first, second, third, fourth];
    let next = quad.iter().cycle().skip(1);
    let mut sides = quad.iter().zip(next);
    let is_large = sides.all(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]) >= LEAST_SIDE);
    let fills = area(&quad).abs() >= FILLS * area(hull).abs();
    (is_large && fills).then_some(quad)
}
