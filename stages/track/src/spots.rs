//! Spots of a table whose brightness shows how far the table has moved, and what is bright in an image is of what was.

use nalgebra::{SMatrix, SVector};

use crate::Image;
use crate::flow::{Flow, PARTS};

#[derive(Clone, Debug)]
pub(crate) struct Spots {
    all: Vec<Spot>,
    /// Its brightness, 0 to 255, a little smoothed.
    luma: Vec<f32>,
    pub(crate) size: [usize; 2],
    /// What its brightness scatters by from image to image, of 255.
    pub(crate) noise: f32,
    /// How much its brightness changes with a px, of 255: root of the mean square.
    pub(crate) steepness: f32,
}

/// A pixel at which brightness is compared.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot {
    pub(crate) column: usize,
    pub(crate) row: usize,
    /// Its brightness in the background, of 255, and how that changes with a px.
    luma: f32,
    slope: [f32; 2],
}

/// Spots across an image, one in each square at the most, and the fewest that show a movement.
const ACROSS: usize = 50;
const FEWEST_SPOTS: usize = 60;
const FEWEST_IN_QUARTER: usize = 10;
/// Least change of brightness from one pixel to the next at a spot, of 255.
const LEAST_SLOPE: f32 = 0.3;
/// Px from the border at which no movement is looked for.
const MARGIN: usize = 12;
const STEPS: usize = 8;
/// The step (px) at which a fit ends; the movement up to which a spot's slope holds; the least scatter, of 255.
const DONE: f64 = 0.03;
const NEAR: f32 = 0.25;
const LEAST_SCATTER: f32 = 0.3;
/// Where spots scatter by so much (of 255) from image to image, a lamp flickers in bands, and nothing shows a movement.
const MOST_NOISE: f32 = 8.0;
/// What scatter is at the most where a fit begins, of that which is seen there.
const FIRST_SCALE: f32 = 2.0;
/// Tukey's constant; a deviation of a normal distribution, of the median of its absolute values.
const TUKEY: f32 = 4.7;
const DEVIATION: f32 = 1.4826;
/// The farthest movement that is followed, in px.
pub(crate) const FARTHEST: f64 = 48.0;

impl Spots {
    /// The spots of a table's image where it `is_table`, of which these are images.
    pub(crate) fn find<'a>(
        image: &Image,
        is_table: &dyn Fn(usize, usize) -> bool,
        images: impl Iterator<Item = &'a Image>,
    ) -> Self {
        let mut spots = Self {
            all: Vec::new(),
            luma: smoothed(image),
            size: [image.width, image.height],
            noise: 0.0,
            steepness: 0.0,
        };
        spots.all = spots.steepest(is_table);
        let squares = spots
            .all
            .iter()
            .map(|spot| spot.slope[0].powi(2) + spot.slope[1].powi(2));
        spots.steepness = (squares.sum::<f32>() / spots.all.len().max(1) as f32).sqrt();
        let scatters = images.filter_map(|image| {
            let fit = spots.fitted::<SHIFT>(&spots.seen(image), spots.still())?;
            Some(fit.scatter)
        });
        let mut scatters: Vec<f32> = scatters.collect();
        scatters.sort_by(f32::total_cmp);
        spots.noise = scatters.get(scatters.len() / 2).copied().unwrap_or(0.0);
        spots
    }

    /// Whether a movement would be seen: the light is steady, and there are enough spots, in three quarters of the image at the least. Those of an arm lie in two.
    pub(crate) fn shows_movement(&self) -> bool {
        let mut quarters = [0; 4];
        for spot in &self.all {
            let right = usize::from(2 * spot.column > self.size[0]);
            quarters[right + 2 * usize::from(2 * spot.row > self.size[1])] += 1;
        }
        quarters.sort_unstable();
        let is_steady = self.noise < MOST_NOISE;
        is_steady && self.all.len() >= FEWEST_SPOTS && quarters[1] >= FEWEST_IN_QUARTER
    }

    /// Shows no movement any more.
    pub(crate) fn forget(&mut self) {
        self.all.clear();
    }

    pub(crate) fn still(&self) -> Flow {
        Flow::still(self.size)
    }

    /// The steepest pixel of each square.
    fn steepest(&self, is_table: &dyn Fn(usize, usize) -> bool) -> Vec<Spot> {
        let [width, height] = self.size;
        let side = (width / ACROSS).max(4);
        let mut spots = Vec::new();
        for top in (MARGIN..height.saturating_sub(MARGIN)).step_by(side) {
            for left in (MARGIN..width.saturating_sub(MARGIN)).step_by(side) {
                let mut best = (LEAST_SLOPE, None);
                for row in (top..(top + side).min(height - MARGIN)).filter(is_within_block) {
                    for column in (left..(left + side).min(width - MARGIN)).filter(is_within_block)
                    {
                        let slope = self.slope(column as f32, row as f32);
                        let steep = slope.map_or(0.0, |[x, y]| x.hypot(y));
                        if steep > best.0 && is_table(column, row) {
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

    /// Brightness between pixels, bilinear; none outside.
    pub(crate) fn luma_at(&self, x: f32, y: f32) -> Option<f32> {
        if x < 0.0 || y < 0.0 {
            return None;
        }
        let (column, row, width) = (x as usize, y as usize, self.size[0]);
        if column + 1 >= width || row + 1 >= self.size[1] {
            return None;
        }
        let (a, b) = (x - column as f32, y - row as f32);
        let at = row * width + column;
        let upper = self.luma[at] * (1.0 - a) + self.luma[at + 1] * a;
        let lower = self.luma[at + width] * (1.0 - a) + self.luma[at + width + 1] * a;
        Some(upper * (1.0 - b) + lower * b)
    }

    /// The spots, each with its brightness in an image.
    pub(crate) fn seen(&self, image: &Image) -> Vec<(Spot, f32)> {
        let spots = self.all.iter();
        spots
            .map(|spot| (*spot, luma(image, spot.column, spot.row)))
            .collect()
    }

    /// The spots, each with the median of its brightness in some images: what hides it in few of them does not count.
    pub(crate) fn medians(images: &[&[(Spot, f32)]]) -> Vec<(Spot, f32)> {
        let first = images.first().copied().unwrap_or_default();
        let all = first.iter().enumerate().map(|(k, (spot, _))| {
            let mut values: Vec<f32> = images.iter().map(|seen| seen[k].1).collect();
            values.sort_by(f32::total_cmp);
            let middle = values.len() / 2;
            let low = values[(values.len() - 1) / 2];
            (*spot, 0.5 * (low + values[middle]))
        });
        all.collect()
    }

    /// How bright spots are, of what they were, and what they scatter by: medians, whatever some of them show.
    pub(crate) fn brightness(&self, seen: &[(Spot, f32)], flow: &Flow) -> Option<(f32, f32)> {
        let is_still = flow.is_still();
        let known = |spot: &Spot| {
            if is_still {
                return Some(spot.luma);
            }
            let at = [spot.column as f64, spot.row as f64];
            let [dx, dy] = flow.at(at);
            self.luma_at((at[0] - dx) as f32, (at[1] - dy) as f32)
        };
        let pairs = seen.iter();
        let pairs = pairs.filter_map(|(spot, value)| Some((known(spot)?.max(1.0), *value)));
        let pairs: Vec<(f32, f32)> = pairs.collect();
        let median = |values: &mut dyn Iterator<Item = f32>| {
            let mut values: Vec<f32> = values.collect();
            let middle = values.len() / 2;
            let (_, median, _) = values.select_nth_unstable_by(middle, f32::total_cmp);
            *median
        };
        if pairs.len() < FEWEST_SPOTS {
            return None;
        }
        let gain = median(&mut pairs.iter().map(|(known, value)| value / known));
        let off = &mut pairs
            .iter()
            .map(|(known, value)| (value - gain * known).abs());
        Some((gain, (DEVIATION * median(off)).max(LEAST_SCATTER)))
    }

    /// The movement and the brightness that an image's spots show, from a first guess on: of the movement the first `N - GAIN` parts.
    pub(crate) fn fitted<const N: usize>(
        &self,
        seen: &[(Spot, f32)],
        start: Flow,
    ) -> Option<Fitted> {
        self.fitted_from::<N>(seen, start, self.brightness(seen, &start)?)
    }

    /// The same from a brightness on that is known, and what spots scatter by.
    pub(crate) fn fitted_from<const N: usize>(
        &self,
        seen: &[(Spot, f32)],
        start: Flow,
        (gain, mut scale): (f32, f32),
    ) -> Option<Fitted> {
        let mut flow = start;
        // Brightness, and how it grows to the right and down: a lens is darker at its border, wherever the table lies.
        let mut light = SVector::<f32, GAIN>::from([gain, 0.0, 0.0]);
        // The start may be off by much of a slope.
        scale *= FIRST_SCALE;
        let mut deviation = f64::INFINITY;
        let mut count = 0;
        for step_number in 0..STEPS {
            let mut normal = SMatrix::<f32, N, N>::zeros();
            let mut right = SVector::<f32, N>::zeros();
            let mut left = Vec::with_capacity(seen.len());
            let is_still = flow.is_still();
            for (spot, value) in seen {
                let at = [spot.column as f64, spot.row as f64];
                let far = if is_still { [0.0; 2] } else { flow.at(at) };
                let [dx, dy] = far.map(|part| part as f32);
                // Near to where it was, its slope tells; farther, it is looked up.
                let (known, [sx, sy]) = if dx.abs().max(dy.abs()) < NEAR {
                    let [sx, sy] = spot.slope;
                    (spot.luma - sx * dx - sy * dy, [sx, sy])
                } else {
                    let (x, y) = (spot.column as f32 - dx, spot.row as f32 - dy);
                    match (self.luma_at(x, y), self.slope(x, y)) {
                        (Some(luma), Some(slope)) => (luma, slope),
                        _ => continue,
                    }
                };
                let [right_of, below] = flow.place(at).map(|part| part as f32);
                let lit = SVector::<f32, GAIN>::from([known, known * right_of, known * below]);
                let gain = light[0] + light[1] * right_of + light[2] * below;
                let off = value - gain * known;
                left.push(off.abs());
                let share = off / (TUKEY * scale);
                let weight = if share.abs() < 1.0 {
                    (1.0 - share * share).powi(2)
                } else {
                    0.0
                };
                // Brighter where it is steeper: a step (sx, sy) of the background takes its value from there.
                let parts = flow.parts(at);
                let row = SVector::<f32, N>::from_fn(|part, _| match part.checked_sub(GAIN) {
                    None => lit[part],
                    Some(part) => {
                        let [x, y] = parts[part].map(|part| part as f32);
                        -gain * (sx * x + sy * y)
                    }
                });
                normal += weight * row * row.transpose();
                right += weight * off * row;
            }
            if left.len() < FEWEST_SPOTS {
                return None;
            }
            count = left.len();
            let inverse = normal.cholesky()?.inverse();
            let step = inverse * right;
            let brighter = step.fixed_rows::<GAIN>(0);
            light += brighter;
            let moves = step.iter().skip(GAIN).map(|part| f64::from(*part));
            let most = flow.step(moves).max(100.0 * f64::from(brighter.amax()));
            let middle = left.len() / 2;
            let (_, median, _) = left.select_nth_unstable_by(middle, f32::total_cmp);
            let is_done = step_number > 0 && most < DONE;
            scale = (DEVIATION * *median).max(LEAST_SCATTER);
            deviation = f64::from(scale)
                * flow.uncertainty(|part, other| {
                    let is_fitted = part.max(other) + GAIN < N;
                    if is_fitted {
                        f64::from(inverse[(part + GAIN, other + GAIN)])
                    } else {
                        0.0
                    }
                });
            if flow.farthest() >= FARTHEST {
                return None;
            }
            if is_done {
                break;
            }
        }
        Some(Fitted {
            flow,
            gain: f64::from(light[0]),
            scatter: scale,
            deviation,
            count,
        })
    }
}

/// Parts that are fitted: brightness alone, with a shift, with roll and zoom, and with all else that turns or moves a camera.
pub(crate) const GAIN: usize = 3;
pub(crate) const SHIFT: usize = GAIN + 2;
pub(crate) const TURNED: usize = SHIFT + 2;
pub(crate) const ALL: usize = GAIN + PARTS;

#[derive(Clone, Copy)]
pub(crate) struct Fitted {
    pub(crate) flow: Flow,
    /// How bright the table is, of what it was.
    pub(crate) gain: f64,
    /// Scatter of brightness, of 255.
    pub(crate) scatter: f32,
    /// Standard deviation of the movement where it is known least, in px.
    pub(crate) deviation: f64,
    count: usize,
}

impl Fitted {
    /// Whether the squares of what is left fall by more than chance makes of them. Many false minima look sure by themselves.
    pub(crate) fn is_better(&self, simpler: &Self, sure: f64) -> bool {
        let squares = |scatter: f32| f64::from(scatter).powi(2);
        let fall = squares(simpler.scatter) / squares(self.scatter) - 1.0;
        fall * self.count as f64 > sure * sure
    }

    pub(crate) fn least(self, other: Self) -> Self {
        if other.scatter < self.scatter {
            other
        } else {
            self
        }
    }
}

/// The mean brightness of a pixel and those within two px of it, which noise and compression hardly move; it must lie two px from the border.
fn luma(image: &Image, column: usize, row: usize) -> f32 {
    let rows = row - 2..=row + 2;
    let rows = rows.map(|row| &image.rgb[3 * (row * image.width + column - 2)..][..3 * 5]);
    rows.map(|row| row.as_chunks().0.iter().map(weighed).sum::<u32>())
        .sum::<u32>() as f32
        / 100.0
}

/// Four times a pixel's brightness.
fn weighed([r, g, b]: &[u8; 3]) -> u32 {
    u32::from(*r) + 2 * u32::from(*g) + u32::from(*b)
}

/// Whether a column or row lies in the middle of JPEG's blocks of 8 px: the edges between them stay where the table moves.
fn is_within_block(at: &usize) -> bool {
    matches!(at % 8, 3 | 4)
}

/// [`luma`] of all pixels; nothing within two px of the border.
fn smoothed(image: &Image) -> Vec<f32> {
    let Image { width, height, .. } = *image;
    let mut values = vec![0.0; width * height];
    let all: Vec<u32> = image.rgb.as_chunks().0.iter().map(weighed).collect();
    let mut sums = vec![0; width];
    for row in 2..height.saturating_sub(2) {
        for (column, sum) in sums.iter_mut().enumerate() {
            let row_of = |row: usize| all[row * width + column];
            *sum = (row - 2..=row + 2).map(row_of).sum();
        }
        let across = sums.windows(5).map(|five| five.iter().sum::<u32>());
        for (value, sum) in values[row * width + 2..].iter_mut().zip(across) {
            *value = sum as f32 / 100.0;
        }
    }
    values
}
