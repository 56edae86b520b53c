//! Proposes the object's colour range from one image.
//!
//! The table's colour is the image's median. The object is what stands off it most, or what is at a pixel that a person names;
//! its region is grown from there, and the range is that of its pixels, widened for light of other days.

use values::{Colour, Interval};

use crate::colour::{Contrast, Part, Range, light_of_bytes};
use crate::{Image, TuneError};

/// A colour range, and what it finds in the image that it came from.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuned {
    /// The range.
    pub colour: Colour,
    /// Centroid of the object's region in px.
    pub pixel: [f64; 2],
    /// Pixels of the region.
    pub area: usize,
    /// Pixels in the range that are not of the region or its edge.
    pub elsewhere: usize,
    /// Whether each pixel is in the range, row by row.
    pub found: Vec<bool>,
}

/// Side of the squares over which colours are averaged to find what stands out, in px.
const SQUARE: usize = 8;
/// Light that stands off the table's by less than this, of 1, is noise.
const LEAST_DIFFERENCE: f32 = 0.02;
/// Colours that are tried at the most until one is of something that fits.
const MOST_TRIED: usize = 32;
/// An object takes a quarter of the image at the most, and some pixels at the least.
const LARGEST_SHARE: f64 = 0.25;
const FEWEST_PIXELS: usize = 50;
/// A pixel from which the object's share of its light is at least this is no edge.
const INSIDE: f32 = 0.75;
const EDGE: f32 = 0.5;
/// Share of the region's pixels that may lie outside each end of the range: glints and dust.
const TAIL: f64 = 0.01;
/// The range is wider than the region's colours by so many degrees of hue: what white balance moves.
const HUE_MARGIN: f64 = 10.0;
/// Shade and glare move saturation and value: an object in half the light has 0.73 of its byte (2.4th root), in a quarter 0.56.
const SATURATION_SHARE: f64 = 0.7;
const VALUE_SHARE: f64 = 0.56;

impl Tuned {
    /// Proposes a range for what is at a pixel, or for what stands out most; of what stands out, the first that `fits`, where one does.
    ///
    /// # Errors
    /// Nothing stands out; what is at the pixel is the table, or takes much of the image.
    pub fn propose(
        image: &Image,
        at: Option<[usize; 2]>,
        fits: Option<&dyn Fn(&Self) -> bool>,
    ) -> Result<Self, TuneError> {
        let light = light_of_bytes();
        let mut squares = squares(image, &light);
        let table = median(squares.iter().map(|(_, mean)| *mean).collect());
        if let Some([x, y]) = at {
            if x >= image.width || y >= image.height {
                return Err(TuneError::Outside {
                    x,
                    y,
                    width: image.width,
                    height: image.height,
                });
            }
            return Self::grow(image, &light, table, [x, y]);
        }
        let off = |(_, mean): &([usize; 2], [f32; 3])| difference(*mean, table, image.grey);
        squares.retain(|square| off(square) > LEAST_DIFFERENCE);
        squares.sort_by(|a, b| off(b).total_cmp(&off(a)));
        let mut seeds = squares.into_iter().map(|(seed, _)| seed);
        let first = seeds.next().ok_or(TuneError::Nothing)?;
        let first = Self::grow(image, &light, table, first);
        let Some(fits) = fits else { return first };
        let mut tried: Vec<Self> = Vec::new();
        let mut next = first.clone();
        for _ in 0..MOST_TRIED {
            if let Ok(tuned) = next {
                if fits(&tuned) {
                    return Ok(tuned);
                }
                tried.push(tuned);
            }
            let is_new = |[x, y]: &[usize; 2]| {
                let index = y * image.width + x;
                !tried.iter().any(|tuned| tuned.found[index])
            };
            let Some(seed) = seeds.find(is_new) else {
                break;
            };
            next = Self::grow(image, &light, table, seed);
        }
        first
    }

    /// Proposes a range for what hangs together with a pixel.
    fn grow(
        image: &Image,
        light: &[f32; 256],
        table: [f32; 3],
        seed: [usize; 2],
    ) -> Result<Self, TuneError> {
        let object = around(image, light, seed);
        let contrast = Contrast::between(object, table, image.grey).ok_or(TuneError::Table)?;
        let whole = Part {
            left: 0,
            top: 0,
            width: image.width,
            height: image.height,
        };
        let map = contrast.map(image, light, whole).values;
        let region = grown(&map, image.width, seed);
        let share = region.len() as f64 / map.len() as f64;
        if region.len() < FEWEST_PIXELS || share > LARGEST_SHARE {
            return Err(TuneError::Size {
                share: 100.0 * share,
            });
        }
        let inside = region.iter().filter(|index| map[**index] > INSIDE);
        let colours: Vec<[f64; 3]> = inside.map(|index| hsv(pixel(image, *index))).collect();
        let colour = range(&colours, image.grey);
        let tested = Range::of(&colour);
        let found: Vec<bool> = (0..map.len())
            .map(|index| tested.contains(pixel(image, index), image.grey))
            .collect();
        let mut is_near = vec![false; map.len()];
        for index in &region {
            let (x, y) = (index % image.width, index / image.width);
            for row in y.saturating_sub(2)..(y + 3).min(image.height) {
                let from = row * image.width;
                is_near[from + x.saturating_sub(2)..from + (x + 3).min(image.width)].fill(true);
            }
        }
        let elsewhere = found.iter().zip(&is_near);
        let elsewhere = elsewhere.filter(|(found, near)| **found && !**near).count();
        let sum = |part: &dyn Fn(usize) -> usize| {
            region.iter().map(|index| part(*index) as f64).sum::<f64>() / region.len() as f64
        };
        Ok(Self {
            colour,
            pixel: [
                sum(&|index| index % image.width),
                sum(&|index| index / image.width),
            ],
            area: region.len(),
            elsewhere,
            found,
        })
    }
}

fn pixel(image: &Image, index: usize) -> [u8; 3] {
    image.pixel(index % image.width, index / image.width)
}

/// The mean light of squares of pixels, each with its middle.
fn squares(image: &Image, light: &[f32; 256]) -> Vec<([usize; 2], [f32; 3])> {
    let side = SQUARE.min(image.width).min(image.height);
    let mut squares = Vec::new();
    for top in (0..=image.height - side).step_by(side) {
        for left in (0..=image.width - side).step_by(side) {
            let mut sum = [0.0; 3];
            for row in top..top + side {
                for column in left..left + side {
                    let rgb = image.pixel(column, row);
                    sum = [0, 1, 2].map(|i| sum[i] + light[usize::from(rgb[i])]);
                }
            }
            let count = (side * side) as f32;
            squares.push((
                [left + side / 2, top + side / 2],
                sum.map(|sum| sum / count),
            ));
        }
    }
    squares
}

fn around(image: &Image, light: &[f32; 256], [x, y]: [usize; 2]) -> [f32; 3] {
    let mut colours = Vec::new();
    for row in y.saturating_sub(2)..(y + 3).min(image.height) {
        for column in x.saturating_sub(2)..(x + 3).min(image.width) {
            let rgb = image.pixel(column, row);
            colours.push(rgb.map(|byte| light[usize::from(byte)]));
        }
    }
    median(colours)
}

fn median(mut colours: Vec<[f32; 3]>) -> [f32; 3] {
    let middle = colours.len() / 2;
    [0, 1, 2].map(|i| {
        colours.sort_by(|a, b| a[i].total_cmp(&b[i]));
        colours.get(middle).map_or(0.0, |colour| colour[i])
    })
}

/// How far light stands off the table's: of colours what no shade of the table has, of grey the difference.
fn difference(light: [f32; 3], table: [f32; 3], grey: bool) -> f32 {
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let along = if grey {
        1.0
    } else {
        dot(light, table) / dot(table, table).max(1e-9)
    };
    let off = [0, 1, 2].map(|i| light[i] - along * table[i]);
    dot(off, off).sqrt()
}

/// The indices of the pixels that hang together with a seed and are object.
fn grown(map: &[f32], width: usize, seed: [usize; 2]) -> Vec<usize> {
    let first = seed[1] * width + seed[0];
    let mut is_seen = vec![false; map.len()];
    let (mut open, mut region) = (vec![first], Vec::new());
    while let Some(index) = open.pop() {
        if is_seen[index] || map[index] < EDGE {
            continue;
        }
        is_seen[index] = true;
        region.push(index);
        let column = index % width;
        let neighbours = [
            (column > 0).then(|| index - 1),
            (column + 1 < width).then_some(index + 1),
            index.checked_sub(width),
            Some(index + width).filter(|below| *below < map.len()),
        ];
        open.extend(neighbours.into_iter().flatten());
    }
    region
}

/// Hue in degrees, saturation and value.
fn hsv([r, g, b]: [u8; 3]) -> [f64; 3] {
    let [r, g, b] = [r, g, b].map(|byte| f64::from(byte) / 255.0);
    let (high, low) = (r.max(g).max(b), r.min(g).min(b));
    let chroma = high - low;
    let sixth = if chroma == 0.0 {
        0.0
    } else if high == r {
        (g - b) / chroma
    } else if high == g {
        2.0 + (b - r) / chroma
    } else {
        4.0 + (r - g) / chroma
    };
    let saturation = if high > 0.0 { chroma / high } else { 0.0 };
    [(60.0 * sixth).rem_euclid(360.0), saturation, high]
}

fn range(colours: &[[f64; 3]], grey: bool) -> Colour {
    let ends = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        let tail = (TAIL * values.len() as f64) as usize;
        let last = values.len() - 1;
        [values[tail], values[last - tail]]
    };
    let [low_value, high_value] = ends(colours.iter().map(|colour| colour[2]).collect());
    let rounded = |at: f64| (100.0 * at).round() / 100.0;
    if grey {
        // Without colour the table's value bounds the object's from one side: half way is left to either.
        let margin = 0.5 * (1.0 - VALUE_SHARE) * low_value;
        let value = [low_value - margin, (high_value + margin).min(1.0)];
        return Colour {
            hue: [0.0, 360.0].into(),
            saturation: [0.0, 1.0].into(),
            value: value.map(rounded).into(),
        };
    }
    // Hues are averaged as directions, for they wrap.
    let sum = colours.iter().fold([0.0, 0.0], |sum, colour| {
        let (sin, cos) = colour[0].to_radians().sin_cos();
        [sum[0] + cos, sum[1] + sin]
    });
    let mean = sum[1].atan2(sum[0]).to_degrees();
    let off = colours.iter().map(|colour| {
        let off = (colour[0] - mean).rem_euclid(360.0);
        if off > 180.0 { off - 360.0 } else { off }
    });
    let [least, most] = ends(off.collect());
    let [low_saturation, _] = ends(colours.iter().map(|colour| colour[1]).collect());
    let hue = |off: f64| (mean + off).rem_euclid(360.0).round();
    let interval = |low: f64| Interval::new(rounded(low), 1.0);
    Colour {
        hue: [hue(least - HUE_MARGIN), hue(most + HUE_MARGIN)].into(),
        saturation: interval(SATURATION_SHARE * low_saturation),
        value: interval(VALUE_SHARE * low_value),
    }
}
