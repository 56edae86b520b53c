//! The table as a log shows it without the object: the median of some of its images, and whether the camera still sees it where it was.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use crate::Image;
use crate::colour::{Contrast, Map, Range};

/// What is always there.
#[derive(Clone, Debug)]
pub(crate) struct Background {
    image: Image,
    /// Whether each pixel was seen without the object.
    is_known: Vec<bool>,
    /// Whether each pixel has the object's colour in nearly all images: what is always there is not the object.
    is_coloured: Vec<bool>,
    /// Where its brightness shows a movement.
    spots: Vec<Spot>,
    /// Its brightness, 0 to 255, a little smoothed.
    luma: Vec<f32>,
    /// What its brightness scatters by from image to image, of 255.
    noise: f32,
}

/// A pixel at which brightness is compared.
#[derive(Clone, Copy, Debug)]
struct Spot {
    column: usize,
    row: usize,
    /// Its brightness in the background, of 255, and how that changes with a px.
    luma: f32,
    slope: [f32; 2],
}

/// How a background lies in an image.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Alignment {
    /// How far it has moved, in px.
    pub(crate) shift: [f64; 2],
    /// How bright it is, of its own light.
    pub(crate) light: f32,
}

/// An image, and the part of it (`[[x, y], [x, y]]`, px) where the object is.
pub(crate) type Pilot = (Image, [[f64; 2]; 2]);

/// Images from which a background is taken, at the least.
pub(crate) const FEWEST_PILOTS: usize = 5;
/// A pixel that has the object's colour in this share of the images has always had it.
const ALWAYS: f64 = 0.8;
/// What has always had it reaches so many px farther: an edge is blurred, and a camera trembles.
const REACH: usize = 3;
/// Spots across an image, one in each square at the most, and the fewest that show a movement.
const ACROSS: usize = 50;
const FEWEST_SPOTS: usize = 60;
/// Least change of brightness from one pixel to the next at a spot, of 255.
const LEAST_SLOPE: f32 = 0.3;
/// Px from the border at which no movement is looked for.
const MARGIN: usize = 12;
/// A table that has more of the object's colour than this cannot be told from it.
const MOST_OWN: f32 = 0.6;
/// Steps of a fit, and the movements (px) from which it begins.
const STEPS: usize = 8;
const STARTS: [f64; 5] = [0.0, -3.0, 3.0, -6.0, 6.0];
/// The step (px) at which a fit ends; the movement up to which a spot's slope holds; the least scatter, of 255.
const DONE: f32 = 0.03;
const NEAR: f32 = 0.25;
const LEAST_SCATTER: f32 = 0.3;
/// Tukey's constant; a deviation of a normal distribution, of the median of its absolute values.
const TUKEY: f32 = 4.7;
const DEVIATION: f32 = 1.4826;
/// A movement that is known to this (px) is known; one of less than the least, or of less than so many deviations, is none.
const KNOWN: f64 = 0.12;
const LEAST_SHIFT: f64 = 0.5;
const SURE: f64 = 8.0;
/// Where the background scatters by so many times its noise, and this much of 255, it is not where it was.
const ELSEWHERE: f32 = 3.0;
const LEAST_ELSEWHERE: f32 = 5.0;

impl Background {
    /// The background of some images of one size; none where they are too few. Where the camera was pushed between them, it is that of the
    /// images before: what is known of the camera is of then.
    pub(crate) fn of(pilots: &[Pilot], range: &Range) -> Option<Self> {
        let all = Self::of_all(pilots, range)?;
        let shifts = pilots.iter().map(|(image, _)| {
            let fit = all.fitted(image, [0.0; 2])?;
            (fit.deviation < KNOWN).then_some(fit.shift)
        });
        let shifts: Vec<Option<[f64; 2]>> = shifts.collect();
        let Some(&Some(first)) = shifts.first() else {
            return Some(all);
        };
        let far = |shift: &Option<[f64; 2]>| {
            shift.map_or(f64::INFINITY, |[x, y]| (x - first[0]).hypot(y - first[1]))
        };
        let farthest = shifts.iter().map(far).filter(|far| far.is_finite());
        let farthest = farthest.fold(0.0, f64::max);
        if farthest < LEAST_SHIFT {
            return Some(all);
        }
        let near = pilots.iter().zip(&shifts);
        let near = near.filter(|(_, shift)| far(shift) < 0.5 * farthest);
        let near: Vec<Pilot> = near.map(|(pilot, _)| pilot.clone()).collect();
        Self::of_all(&near, range).or(Some(all))
    }

    fn of_all(pilots: &[Pilot], range: &Range) -> Option<Self> {
        let (first, _) = pilots.first()?;
        let (width, height) = (first.width, first.height);
        let is_alike = |(image, _): &Pilot| image.width == width && image.height == height;
        if pilots.len() < FEWEST_PILOTS || !pilots.iter().all(is_alike) {
            return None;
        }
        let mut image = Image::default();
        image.resize(width as u64, height as u64).ok()?;
        image.grey = first.grey;
        let mut is_known = vec![false; width * height];
        let mut is_always = vec![false; width * height];
        let rows = image.rgb.par_chunks_exact_mut(3 * width);
        let rows = rows.zip(is_known.par_chunks_exact_mut(width));
        let rows = rows.zip(is_always.par_chunks_exact_mut(width));
        rows.enumerate().for_each(|(row, ((rgb, known), always))| {
            let mut seen: Vec<[u8; 3]> = Vec::with_capacity(pilots.len());
            for column in 0..width {
                seen.clear();
                let mut coloured = 0;
                for (image, [low, high]) in pilots {
                    let (x, y) = (column as f64, row as f64);
                    let pixel = image.pixel(column, row);
                    if !(low[0]..high[0]).contains(&x) || !(low[1]..high[1]).contains(&y) {
                        seen.push(pixel);
                        coloured += usize::from(range.contains(pixel, image.grey));
                    }
                }
                known[column] = seen.len() >= FEWEST_PILOTS.min(pilots.len() / 2);
                always[column] = known[column] && coloured as f64 >= ALWAYS * seen.len() as f64;
                let middle = seen.len() / 2;
                for i in 0..3 {
                    if !seen.is_empty() {
                        let (_, median, _) = seen.select_nth_unstable_by_key(middle, |rgb| rgb[i]);
                        rgb[3 * column + i] = median[i];
                    }
                }
            }
        });
        let is_coloured = grown(&is_always, width, height);
        let mut background = Self {
            luma: smoothed(&image),
            image,
            is_known,
            is_coloured,
            spots: Vec::new(),
            noise: 0.0,
        };
        background.spots = background.find_spots(range);
        let scatters = pilots
            .iter()
            .filter_map(|(image, _)| Some(background.fitted(image, [0.0; 2])?.scatter));
        let mut scatters: Vec<f32> = scatters.collect();
        scatters.sort_by(f32::total_cmp);
        background.noise = scatters.get(scatters.len() / 2).copied().unwrap_or(0.0);
        Some(background)
    }

    /// A pixel; none where it is not known.
    pub(crate) fn pixel(&self, x: f64, y: f64) -> Option<[u8; 3]> {
        let (x, y) = (x.round(), y.round());
        let is_in =
            x >= 0.0 && y >= 0.0 && x < self.image.width as f64 && y < self.image.height as f64;
        let (column, row) = (x as usize, y as usize);
        (is_in && self.is_known[row * self.image.width + column])
            .then(|| self.image.pixel(column, row))
    }

    /// Makes values of a map the share of a pixel that is object: what the table has of the object's colour is taken off, where it is known.
    pub(crate) fn take_from(
        &self,
        map: &mut Map,
        contrast: &Contrast,
        light: &[f32; 256],
        alignment: &Alignment,
    ) {
        let part = map.part;
        let [x, y] = alignment.shift;
        for (at, value) in map.values.iter_mut().enumerate() {
            let column = (part.left + at % part.width) as f64 - x;
            let row = (part.top + at / part.width) as f64 - y;
            if let Some(rgb) = self.pixel(column, row) {
                let own = contrast.of(rgb.map(|byte| alignment.light * light[usize::from(byte)]));
                if own.abs() < MOST_OWN {
                    *value = (*value - own) / (1.0 - own);
                }
            }
        }
    }

    /// Whether a pixel has had the object's colour in nearly all images, the object elsewhere.
    pub(crate) fn is_coloured(&self, column: usize, row: usize) -> bool {
        self.is_coloured[row * self.image.width + column]
    }

    /// How it lies in an image; none where it is not what is seen there.
    pub(crate) fn align(&self, image: &Image) -> Option<Alignment> {
        if image.width != self.image.width || image.height != self.image.height {
            return None;
        }
        let still = Alignment {
            shift: [0.0; 2],
            light: 1.0,
        };
        if self.spots.len() < FEWEST_SPOTS {
            return Some(still);
        }
        let most = LEAST_ELSEWHERE.max(ELSEWHERE * self.noise);
        let mut best = self.fitted(image, [0.0; 2]);
        if best.as_ref().is_none_or(|fit| fit.scatter > most) {
            for (x, y) in STARTS.iter().flat_map(|x| STARTS.map(|y| (*x, y))) {
                let other = self.fitted(image, [x, y]);
                let is_better = match (&other, &best) {
                    (Some(other), Some(best)) => other.scatter < best.scatter,
                    (other, None) => other.is_some(),
                    _ => false,
                };
                if is_better {
                    best = other;
                }
            }
        }
        let fit = best.filter(|fit| fit.scatter <= most)?;
        let far = fit.shift[0].hypot(fit.shift[1]);
        let is_moved = fit.deviation < KNOWN && far > LEAST_SHIFT.max(SURE * fit.deviation);
        Some(Alignment {
            shift: if is_moved { fit.shift } else { [0.0; 2] },
            // Of light, from bytes.
            light: fit.gain.max(0.1).powf(2.2),
        })
    }

    /// The steepest pixel of each square.
    fn find_spots(&self, range: &Range) -> Vec<Spot> {
        let Image { width, height, .. } = self.image;
        let side = (width / ACROSS).max(4);
        let mut spots = Vec::new();
        for top in (MARGIN..height.saturating_sub(MARGIN)).step_by(side) {
            for left in (MARGIN..width.saturating_sub(MARGIN)).step_by(side) {
                let mut best = (LEAST_SLOPE, None);
                for row in top..(top + side).min(height - MARGIN) {
                    for column in left..(left + side).min(width - MARGIN) {
                        let at = row * width + column;
                        let slope = self.slope(column as f32, row as f32);
                        let steep = slope.map_or(0.0, |[x, y]| x.hypot(y));
                        let is_table = self.is_known[at]
                            && !range.contains(self.image.pixel(column, row), self.image.grey);
                        if steep > best.0 && is_table {
                            best = (steep, Some((column, row)));
                        }
                    }
                }
                spots.extend(best.1.and_then(|(column, row)| {
                    let (x, y) = (column as f32, row as f32);
                    Some(Spot {
                        column,
                        row,
                        luma: self.luma_at(x, y)?,
                        slope: self.slope(x, y)?,
                    })
                }));
            }
        }
        spots
    }

    fn slope(&self, x: f32, y: f32) -> Option<[f32; 2]> {
        let at = |dx: f32, dy: f32| self.luma_at(x + dx, y + dy);
        Some([
            0.5 * (at(1.0, 0.0)? - at(-1.0, 0.0)?),
            0.5 * (at(0.0, 1.0)? - at(0.0, -1.0)?),
        ])
    }

    fn luma_at(&self, x: f32, y: f32) -> Option<f32> {
        if x < 0.0 || y < 0.0 {
            return None;
        }
        let (column, row, width) = (x as usize, y as usize, self.image.width);
        if column + 1 >= width || row + 1 >= self.image.height {
            return None;
        }
        let (a, b) = (x - column as f32, y - row as f32);
        let at = row * width + column;
        let upper = self.luma[at] * (1.0 - a) + self.luma[at + 1] * a;
        let lower = self.luma[at + width] * (1.0 - a) + self.luma[at + width + 1] * a;
        Some(upper * (1.0 - b) + lower * b)
    }

    /// The movement and the brightness that an image's spots show, from a first guess on.
    fn fitted(&self, image: &Image, start: [f64; 2]) -> Option<Fitted> {
        let seen: Vec<(Spot, f32)> = self
            .spots
            .iter()
            .map(|spot| (*spot, luma(image, spot.column, spot.row)))
            .collect();
        let mut shift = start.map(|part| part as f32);
        let (mut gain, mut scale) = (1.0f32, f32::INFINITY);
        let mut deviation = f64::INFINITY;
        for _ in 0..STEPS {
            let (mut normal, mut right) = (Matrix3::<f32>::zeros(), Vector3::<f32>::zeros());
            let mut left = Vec::with_capacity(seen.len());
            for (spot, value) in &seen {
                // Near to where it was, its slope tells; farther, it is looked up.
                let (known, [sx, sy]) = if shift[0].abs().max(shift[1].abs()) < NEAR {
                    let [sx, sy] = spot.slope;
                    (spot.luma - sx * shift[0] - sy * shift[1], [sx, sy])
                } else {
                    let (x, y) = (spot.column as f32 - shift[0], spot.row as f32 - shift[1]);
                    match (self.luma_at(x, y), self.slope(x, y)) {
                        (Some(luma), Some(slope)) => (luma, slope),
                        _ => continue,
                    }
                };
                let off = value - gain * known;
                left.push(off.abs());
                let share = off / (TUKEY * scale);
                let weight = if share.abs() < 1.0 {
                    (1.0 - share * share).powi(2)
                } else {
                    0.0
                };
                // Brighter where it is steeper: a step (sx, sy) of the background takes its value from there.
                let row = Vector3::new(-gain * sx, -gain * sy, known);
                normal += weight * row * row.transpose();
                right += weight * off * row;
            }
            if left.len() < FEWEST_SPOTS {
                return None;
            }
            let inverse = normal.cholesky()?.inverse();
            let step = inverse * right;
            shift = [shift[0] + step[0], shift[1] + step[1]];
            gain += step[2];
            let middle = left.len() / 2;
            let (_, median, _) = left.select_nth_unstable_by(middle, f32::total_cmp);
            let is_done = scale.is_finite() && step[0].abs().max(step[1].abs()) < DONE;
            scale = (DEVIATION * *median).max(LEAST_SCATTER);
            deviation = f64::from(scale * inverse[(0, 0)].max(inverse[(1, 1)]).sqrt());
            if !(shift[0].abs() < MARGIN as f32 && shift[1].abs() < MARGIN as f32) {
                return None;
            }
            if is_done {
                break;
            }
        }
        Some(Fitted {
            shift: shift.map(f64::from),
            gain,
            scatter: scale,
            deviation,
        })
    }
}

struct Fitted {
    shift: [f64; 2],
    gain: f32,
    /// Of brightness, of 255.
    scatter: f32,
    /// Of the movement, in px.
    deviation: f64,
}

/// The mean brightness of a pixel and those within two px of it, which noise and compression hardly move; it must lie two px from the border.
fn luma(image: &Image, column: usize, row: usize) -> f32 {
    let mut sum = 0u32;
    for y in row - 2..=row + 2 {
        for x in column - 2..=column + 2 {
            let [r, g, b] = image.pixel(x, y).map(u32::from);
            sum += r + 2 * g + b;
        }
    }
    sum as f32 / 100.0
}

fn smoothed(image: &Image) -> Vec<f32> {
    let Image { width, height, .. } = *image;
    let mut values = vec![0.0; width * height];
    for row in 2..height.saturating_sub(2) {
        for column in 2..width.saturating_sub(2) {
            values[row * width + column] = luma(image, column, row);
        }
    }
    values
}

fn grown(is_set: &[bool], width: usize, height: usize) -> Vec<bool> {
    let mut grown = vec![false; is_set.len()];
    for (at, _) in is_set.iter().enumerate().filter(|(_, is_set)| **is_set) {
        let (column, row) = (at % width, at / width);
        for y in row.saturating_sub(REACH)..(row + REACH + 1).min(height) {
            let (from, to) = (
                column.saturating_sub(REACH),
                (column + REACH + 1).min(width),
            );
            grown[y * width + from..y * width + to].fill(true);
        }
    }
    grown
}
