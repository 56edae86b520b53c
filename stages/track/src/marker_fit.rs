//! A marker's place and yaw: its pattern, blurred as it is seen, laid onto the image.
//!
//! All of its edges tell where it is, not its corners alone. Place, yaw, size and blur are found with the light on it, by Gauss–Newton with
//! Tukey's weights; each pixel's point of the marker's plane is known beforehand, so that nothing but a turn and a move is left of the camera.

use nalgebra::{SMatrix, SVector};

use crate::board::Pattern;

/// Where a marker lies: its centre on its plane (m), its yaw (rad), and how large it is seen of what it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placed {
    pub(crate) at: [f64; 2],
    pub(crate) yaw: f64,
    pub(crate) scale: f64,
}

/// A pixel: the point of the marker's plane that is seen in it (m), and its light, 0 to 1.
pub(crate) type Lit = ([f64; 2], f64);

/// A marker that was laid onto an image.
#[derive(Clone, Debug)]
pub(crate) struct MarkerFit {
    pub(crate) placed: Placed,
    /// Standard deviations of a coordinate (m) and of the yaw (rad), as the pixels scatter.
    pub(crate) deviation: [f64; 2],
    /// Share of the pixels' variance that is explained.
    pub(crate) explained: f64,
    /// Cells that are seen otherwise than the pattern has them.
    pub(crate) wrong: usize,
    pub(crate) contrast: f64,
}

/// Unknowns: light of black, of white beyond it and its slopes, place (sides), yaw, logarithms of blur and size.
const UNKNOWNS: usize = 9;
const ROUNDS: usize = 14;
/// Rounds before single pixels are weighed.
const EVEN: usize = 3;
/// The step, in sides and radians, that is the last.
const DONE: f64 = 2e-5;
/// The farthest step of place (sides) and yaw, and of the logarithms.
const FAR: f64 = 0.1;
const FAR_LOGARITHM: f64 = 0.3;
/// Blur (standard deviation, cells) to begin with and its limits.
const BLUR: f64 = 0.35;
const LEAST_BLUR: f64 = 0.03;
const MOST_BLUR: f64 = 1.2;
/// What holds the unknowns where pixels do not.
const DAMPING: f64 = 1e-6;
/// Tukey's constant; a deviation of a normal distribution, of the median of its absolute values; the least scatter, of the contrast.
const TUKEY: f64 = 4.7;
const DEVIATION: f64 = 1.4826;
const LEAST_SCATTER: f64 = 0.01;
/// A cell that is off by more than this share of the contrast is seen otherwise.
const OTHERWISE: f64 = 0.5;
/// Neighbouring pixels share what noise and compression do to them: so many say what one would say alone.
const ALIKE: f64 = 1.4;
const FEWEST: usize = 60;

/// A pixel under the fit: how white, the light that falls there, and where it is from the middle, in sides.
struct Modelled {
    row: SVector<f64, UNKNOWNS>,
    left: f64,
    cell: [f64; 2],
}

/// Lays a pattern of this side (m) onto pixels, from a start on; none where they do not determine it.
pub(crate) fn fit_marker(
    pattern: &Pattern,
    side: f64,
    pixels: &[Lit],
    start: Placed,
) -> Option<MarkerFit> {
    if pixels.len() < FEWEST {
        return None;
    }
    let (mut placed, mut blur) = (start, BLUR);
    let mut light = [0.0; 4];
    let mut scatter = f64::INFINITY;
    let mut inverse = None;
    for round in 0..ROUNDS {
        if round == 0 {
            light = lit(pattern, side, pixels, &placed, blur)?;
        }
        let modelled = pixels
            .iter()
            .map(|pixel| model(pattern, side, pixel, &placed, blur, &light));
        let modelled: Vec<Modelled> = modelled.collect();
        if round >= EVEN {
            let mut off: Vec<f64> = modelled.iter().map(|one| one.left.abs()).collect();
            let middle = off.len() / 2;
            let (_, median, _) = off.select_nth_unstable_by(middle, f64::total_cmp);
            scatter = DEVIATION * median.max(LEAST_SCATTER / DEVIATION * light[1].abs());
        }
        let (mut normal, mut toward) = (
            SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros(),
            SVector::<f64, UNKNOWNS>::zeros(),
        );
        for one in &modelled {
            let far = (one.left / (TUKEY * scatter)).powi(2);
            let weight = if far < 1.0 { (1.0 - far).powi(2) } else { 0.0 };
            normal += weight * one.row * one.row.transpose();
            toward += weight * one.left * one.row;
        }
        for k in 0..UNKNOWNS {
            normal[(k, k)] *= 1.0 + DAMPING;
        }
        let factor = normal.cholesky()?;
        let step = factor.solve(&toward);
        inverse = Some(factor.inverse());
        for k in 0..4 {
            light[k] += step[k];
        }
        let limited = |k: usize, most: f64| step[k].clamp(-most, most);
        let moved = [4, 5, 6].map(|k| limited(k, FAR));
        placed.at = [0, 1].map(|i| placed.at[i] + side * moved[i]);
        placed.yaw += moved[2];
        blur = (blur * limited(7, FAR_LOGARITHM).exp()).clamp(LEAST_BLUR, MOST_BLUR);
        placed.scale *= limited(8, FAR_LOGARITHM).exp();
        if !step.iter().all(|part| part.is_finite()) || light[1] <= 0.0 {
            return None;
        }
        if round > EVEN && [4, 5, 6].iter().all(|k| step[*k].abs() < DONE) {
            break;
        }
    }
    let inverse = inverse?;
    let modelled = pixels
        .iter()
        .map(|pixel| model(pattern, side, pixel, &placed, blur, &light));
    let modelled: Vec<Modelled> = modelled.collect();
    let count = pixels.len() as f64;
    let squares = modelled.iter().map(|one| one.left.powi(2)).sum::<f64>();
    let mean = pixels.iter().map(|(_, light)| light).sum::<f64>() / count;
    let all = pixels.iter().map(|(_, light)| (light - mean).powi(2));
    // Of the pixels that count: what Tukey's weights leave out is judged by the cells.
    let variance = ALIKE * scatter.powi(2);
    let of = |k: usize| (variance * inverse[(k, k)]).sqrt();
    Some(MarkerFit {
        placed,
        deviation: [side * of(4).max(of(5)), of(6)],
        explained: 1.0 - squares / all.sum::<f64>(),
        wrong: wrong(pattern, blur, &light, &modelled),
        contrast: light[1],
    })
}

/// Where a point of the plane is on the marker, in cells from its upper left corner.
fn cell(pattern: &Pattern, side: f64, at: [f64; 2], placed: &Placed) -> [f64; 2] {
    let (sin, cos) = placed.yaw.sin_cos();
    let [x, y] = [0, 1].map(|i| (at[i] - placed.at[i]) / (side * placed.scale));
    let across = pattern.across as f64;
    [
        across * (0.5 + cos * x + sin * y),
        across * (0.5 + sin * x - cos * y),
    ]
}

/// Whether a point of the plane lies on the marker or within this margin (cells) about it.
pub(crate) fn is_on(
    pattern: &Pattern,
    side: f64,
    at: [f64; 2],
    placed: &Placed,
    margin: f64,
) -> bool {
    let within = -margin..=pattern.across as f64 + margin;
    cell(pattern, side, at, placed)
        .iter()
        .all(|part| within.contains(part))
}

/// Light of black, of white beyond it, and none of its slopes, for a place and a blur.
fn lit(
    pattern: &Pattern,
    side: f64,
    pixels: &[Lit],
    placed: &Placed,
    blur: f64,
) -> Option<[f64; 4]> {
    let (mut count, mut white, mut squares, mut sum, mut both) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (at, light) in pixels {
        let value = pattern.white(cell(pattern, side, *at, placed), blur).value;
        count += 1.0;
        white += value;
        squares += value * value;
        sum += light;
        both += value * light;
    }
    let slope = (count * both - white * sum) / (count * squares - white * white);
    slope
        .is_finite()
        .then(|| [(sum - slope * white) / count, slope, 0.0, 0.0])
}

fn model(
    pattern: &Pattern,
    side: f64,
    (at, light): &Lit,
    placed: &Placed,
    blur: f64,
    [black, white, right, down]: &[f64; 4],
) -> Modelled {
    let cells = cell(pattern, side, *at, placed);
    let across = pattern.across as f64;
    let [p, q] = cells.map(|part| part / across - 0.5);
    let seen = pattern.white(cells, blur);
    let falls = white + right * p + down * q;
    let [by_right, by_down] = seen.slope.map(|slope| across * falls * slope);
    let (sin, cos) = placed.yaw.sin_cos();
    let (sin, cos) = (sin / placed.scale, cos / placed.scale);
    let row = [
        1.0,
        seen.value,
        seen.value * p,
        seen.value * q,
        -by_right * cos - by_down * sin,
        -by_right * sin + by_down * cos,
        // Counter-clockwise seen from above, where `q` runs down.
        -by_right * q + by_down * p,
        falls * seen.by_blur,
        -by_right * p - by_down * q,
    ];
    Modelled {
        row: SVector::from(row),
        left: light - black - seen.value * falls,
        cell: cells,
    }
}

/// Cells whose pixels are nearer to the other colour.
fn wrong(pattern: &Pattern, blur: f64, light: &[f64; 4], modelled: &[Modelled]) -> usize {
    let across = pattern.across;
    let mut sums = vec![[0.0; 2]; across * across];
    for one in modelled {
        let columns = pattern.shares(one.cell[0], blur);
        let rows = pattern.shares(one.cell[1], blur);
        for &(row, [b, ..]) in &rows.parts[..rows.count] {
            for &(column, [a, ..]) in &columns.parts[..columns.count] {
                let [off, of] = &mut sums[row * across + column];
                *off += a * b * one.left;
                *of += (a * b).powi(2);
            }
        }
    }
    let is_wrong = |[off, of]: &&[f64; 2]| off.abs() > OTHERWISE * light[1] * of;
    sums.iter().filter(is_wrong).count()
}
