//! How tall the object is seen to be, by all of a log's places: its upper face is seen farther from the point below the camera than its foot.
//!
//! A taller object has a longer outline, and so has one whose side is darker or brighter than it is taken for. So what rays across the
//! outline show is modelled whole: the light of upper face, side and table, blurred as a lens blurs light, then as bytes. The side's light,
//! the blur and the height are the log's, place and size each image's. It is done twice, by the brightness and by the colour in which object
//! and table differ: what is not modelled (compressed colours, shadows) puts the two apart.

use nalgebra::{SMatrix, SVector};
use statrs::function::erf::erf;

use crate::colour::{byte_of, light_of};
use crate::edges::Ray;

/// What one image shows along rays across the object's outline.
#[derive(Clone, Debug)]
pub(crate) struct Profiles {
    pub(crate) rays: Vec<Profile>,
    /// The object's and the table's bytes, as shares of 255.
    pub(crate) object: [f64; 3],
    pub(crate) table: [f64; 3],
}

/// Bytes along a ray, as shares of 255: how far out of the outline each was seen, in px.
#[derive(Clone, Debug)]
pub(crate) struct Profile {
    pub(crate) ray: Ray,
    pub(crate) bytes: Vec<(f64, [f64; 3])>,
}

/// A height beyond the one that is stated, and its standard deviation, in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HeightOff {
    pub(crate) metres: f64,
    deviation: f64,
}

/// Px of a ray at each end from which its two colours are taken, and px beyond side and outline that it is looked at.
const LEVEL: f64 = 2.5;
pub(crate) const WINDOW: f64 = 4.0;
pub(crate) const STEP: f64 = 0.5;
/// The inner end has the object's colour to this (share of 255), else a print lies there; inner and outer differ by this.
const PRINT: f64 = 0.12;
const LEAST_STEP: f64 = 0.05;
/// Fewest images and rays.
const FEWEST_IMAGES: usize = 5;
const FEWEST_RAYS: usize = 150;
/// Unknowns of the log: height (m), light of the side, of the upper face's (mean, cosine, sine), blur (px); of an image: place (m), yaw, size (px).
const OF_LOG: usize = 5;
const OF_IMAGE: usize = 4;
const ALL: usize = OF_LOG + OF_IMAGE;
const SCALES: [f64; ALL] = [0.01, 1.0, 1.0, 1.0, 1.0, 0.001, 0.001, 0.01, 1.0];
/// What is likely of them (mean, and standard deviation): sides get less light than the top.
const LIKELY: [(f64, f64); ALL] = [
    (0.0, f64::INFINITY),
    (0.6, 0.2),
    (0.0, 0.15),
    (0.0, 0.15),
    (0.9, f64::INFINITY),
    (0.0, f64::INFINITY),
    (0.0, f64::INFINITY),
    (0.0, 0.1),
    (0.0, 0.3),
];
const BLUR: std::ops::Range<f64> = 0.3..4.0;
const ROUNDS: usize = 10;
/// Rounds with the first scatter, the least scatter (shares of 255), Tukey's constant, a deviation of a median, and how many samples say
/// what one would say alone.
const FIRST_ROUNDS: usize = 3;
const FIRST_SCATTER: f64 = 0.05;
const LEAST_SCATTER: f64 = 0.004;
const TUKEY: f64 = 4.7;
const DEVIATION: f64 = 1.4826;
const ALIKE: f64 = 6.0;
/// Groups of images of which each is left out in turn.
const GROUPS: usize = 5;
/// What no model of an edge has (px): it puts the height out by as much as moves the edges so far.
const UNSEEN: f64 = 0.06;
/// A height that is not known to this (m) is not told, nor one that differs by less than so many deviations.
const KNOWN: f64 = 0.003;
const SURE: f64 = 4.0;

impl HeightOff {
    /// What a centre is off (m) for it at the most, at so many m from the point below a camera so high over the upper face: by as much as that
    /// face is seen elsewhere. What the object's foot says against it, the side's light takes up.
    pub(crate) fn puts_off(&self, from_foot: f64, above: f64) -> f64 {
        self.metres.abs() * from_foot / above
    }

    /// How tall it is seen, and the standard deviation of that, in m.
    pub(crate) fn seen(&self, stated: f64) -> [f64; 2] {
        [stated + self.metres, self.deviation]
    }

    /// By what a log's images show; none where they do not tell it surely. `stated` is the height of the rig file.
    pub(crate) fn of(images: &[Profiles], stated: f64) -> Option<Self> {
        let mean = |of: &dyn Fn(&Profiles) -> [f64; 3]| {
            let sums = images
                .iter()
                .map(of)
                .fold([0.0; 3], |sum, part| [0, 1, 2].map(|i| sum[i] + part[i]));
            sums.map(|sum| sum / images.len().max(1) as f64)
        };
        let (object, table) = (mean(&|one| one.object), mean(&|one| one.table));
        let apart = [0, 1, 2].map(|i| object[i] - table[i]);
        let far = apart.iter().map(|part| part * part).sum::<f64>().sqrt();
        // Weights of ITU-R BT.601.
        let (brightness, colour) = rayon::join(
            || Fit::of(images, stated, [0.299, 0.587, 0.114]),
            || Fit::of(images, stated, apart.map(|part| part / far)),
        );
        let (brightness, colour) = (brightness?, colour?);
        let between = 0.5 * (brightness.height - colour.height);
        let deviation = [brightness, colour].map(|fit| fit.deviation);
        let deviation = deviation[0].max(deviation[1]).hypot(between);
        let found = Self {
            metres: 0.5 * (brightness.height + colour.height),
            deviation,
        };
        let is_told = deviation < KNOWN && found.metres.abs() > SURE * deviation;
        is_told.then_some(found)
    }
}

/// A ray that is fitted, and the light at its two ends.
struct Fitted<'a> {
    profile: &'a Profile,
    inner: [f64; 3],
    outer: [f64; 3],
}

impl<'a> Fitted<'a> {
    fn of(profile: &'a Profile, object: [f64; 3], weights: [f64; 3]) -> Option<Self> {
        let (first, last) = (profile.bytes.first()?.0, profile.bytes.last()?.0);
        let mean = |is_in: &dyn Fn(f64) -> bool| {
            let all = profile.bytes.iter().filter(|(t, _)| is_in(*t));
            let (count, sum) = all.fold((0.0, [0.0; 3]), |(count, sum), (_, bytes)| {
                (count + 1.0, [0, 1, 2].map(|i| sum[i] + bytes[i]))
            });
            sum.map(|sum| sum / count)
        };
        let inner = mean(&|t| t < first + LEVEL);
        let outer = mean(&|t| t > last - LEVEL);
        let step = (0..3)
            .map(|i| weights[i] * (inner[i] - outer[i]))
            .sum::<f64>();
        let is_print = (0..3).any(|i| (inner[i] - object[i]).abs() > PRINT);
        (!is_print && step.abs() > LEAST_STEP).then(|| Self {
            profile,
            inner: inner.map(light_of),
            outer: outer.map(light_of),
        })
    }
}

/// What is left of a sample, and how it changes with the unknowns.
struct Sample {
    left: f64,
    row: SVector<f64, ALL>,
}

/// What one image says of the log's unknowns, its own left open.
type Sums = (SMatrix<f64, OF_LOG, OF_LOG>, SVector<f64, OF_LOG>);

/// The height (m) beyond the one that is stated, and its standard deviation.
#[derive(Clone, Copy, Debug)]
struct Fit {
    height: f64,
    deviation: f64,
}

impl Fit {
    fn of(images: &[Profiles], stated: f64, weights: [f64; 3]) -> Option<Self> {
        let images = images.iter().map(|image| {
            let rays = image.rays.iter();
            let rays = rays.filter_map(|ray| Fitted::of(ray, image.object, weights));
            rays.collect::<Vec<Fitted<'_>>>()
        });
        let images: Vec<_> = images.filter(|rays| !rays.is_empty()).collect();
        let rays = images.iter().map(Vec::len).sum::<usize>();
        if images.len() < FEWEST_IMAGES || rays < FEWEST_RAYS {
            return None;
        }
        let of_log: [f64; OF_LOG] = std::array::from_fn(|k| LIKELY[k].0);
        let mut of_log = SVector::from(of_log);
        let mut of_images = vec![SVector::<f64, OF_IMAGE>::zeros(); images.len()];
        let mut sums: Vec<Sums> = Vec::new();
        for round in 0..=ROUNDS {
            let samples = images.iter().zip(&of_images).map(|(rays, own)| {
                let rays = rays.iter();
                let seen = rays.flat_map(|ray| ray.samples(stated, &of_log, own, weights));
                seen.collect::<Vec<Sample>>()
            });
            let samples: Vec<Vec<Sample>> = samples.collect();
            let mut off: Vec<f64> = samples.iter().flatten().map(|one| one.left.abs()).collect();
            let middle = off.len() / 2;
            let (_, median, _) = off.select_nth_unstable_by(middle, f64::total_cmp);
            let least = if round < FIRST_ROUNDS {
                FIRST_SCATTER
            } else {
                LEAST_SCATTER
            };
            let scatter = (DEVIATION * *median).max(least);
            let parts = samples.iter().zip(&of_images);
            let parts: Option<Vec<Part>> = parts
                .map(|(all, own)| Part::of(all, own, scatter))
                .collect();
            let parts = parts?;
            sums = parts.iter().map(|part| part.sums).collect();
            if round == ROUNDS {
                break;
            }
            let step = solved(&sums, &of_log, |_| true)?.0;
            for (part, own) in parts.iter().zip(&mut of_images) {
                *own += scaled::<OF_IMAGE>(OF_LOG, part.own(&step));
            }
            of_log += scaled::<OF_LOG>(0, step);
            of_log[0] = of_log[0].clamp(-0.8 * stated, 3.0 * stated);
            of_log[4] = of_log[4].clamp(BLUR.start, BLUR.end);
        }
        let (_, variance) = solved(&sums, &of_log, |_| true)?;
        let height = |left_out: usize| {
            let step = solved(&sums, &of_log, |image| image % GROUPS != left_out)?.0;
            Some(SCALES[0] * step[0])
        };
        let without: Option<Vec<f64>> = (0..GROUPS).map(height).collect();
        let without = without?;
        let mean = without.iter().sum::<f64>() / GROUPS as f64;
        let squares = without.iter().map(|one| (one - mean).powi(2)).sum::<f64>();
        let jackknife = squares * (GROUPS - 1) as f64 / GROUPS as f64;
        let moves = images
            .iter()
            .flatten()
            .map(|ray| ray.profile.ray.moves[3].powi(2));
        let unseen = UNSEEN / (moves.sum::<f64>() / rays as f64).sqrt();
        Some(Self {
            height: of_log[0],
            deviation: (jackknife + SCALES[0].powi(2) * variance)
                .sqrt()
                .hypot(unseen),
        })
    }
}

/// The step of the log's unknowns by some of its images, and the variance of its first part.
fn solved(
    sums: &[Sums],
    at: &SVector<f64, OF_LOG>,
    is_taken: impl Fn(usize) -> bool,
) -> Option<(SVector<f64, OF_LOG>, f64)> {
    let (mut normal, mut right) = likely::<OF_LOG>(0, at);
    for (_, (more, to)) in sums
        .iter()
        .enumerate()
        .filter(|(image, _)| is_taken(*image))
    {
        normal += more;
        right += to;
    }
    let factor = normal.cholesky()?;
    Some((factor.solve(&right), factor.inverse()[(0, 0)]))
}

/// What is likely of `N` unknowns from `first` on, as sums.
fn likely<const N: usize>(
    first: usize,
    at: &SVector<f64, N>,
) -> (SMatrix<f64, N, N>, SVector<f64, N>) {
    let weight = |k: usize| (SCALES[first + k] / LIKELY[first + k].1).powi(2);
    let toward = |k: usize| weight(k) * (LIKELY[first + k].0 - at[k]) / SCALES[first + k];
    (
        SMatrix::from_diagonal(&SVector::from_fn(|k, _| weight(k))),
        SVector::from_fn(|k, _| toward(k)),
    )
}

/// A step of unknowns in their units: half a scale at the most.
fn scaled<const N: usize>(first: usize, step: SVector<f64, N>) -> SVector<f64, N> {
    SVector::from_fn(|k, _| SCALES[first + k] * step[k].clamp(-0.5, 0.5))
}

/// The sums of one image, and what its own unknowns follow from.
struct Part {
    sums: Sums,
    inverse: SMatrix<f64, OF_IMAGE, OF_IMAGE>,
    mixed: SMatrix<f64, OF_IMAGE, OF_LOG>,
    right: SVector<f64, OF_IMAGE>,
}

impl Part {
    fn of(samples: &[Sample], own: &SVector<f64, OF_IMAGE>, scatter: f64) -> Option<Self> {
        let (mut normal, mut right) = (
            SMatrix::<f64, ALL, ALL>::zeros(),
            SVector::<f64, ALL>::zeros(),
        );
        for one in samples {
            let far = (one.left / (TUKEY * scatter)).powi(2);
            if far < 1.0 {
                let weight = (1.0 - far).powi(2) / (ALIKE * scatter * scatter);
                normal += weight * one.row * one.row.transpose();
                right += weight * one.left * one.row;
            }
        }
        let (likely, toward) = likely::<OF_IMAGE>(OF_LOG, own);
        let inverse =
            (normal.fixed_view::<OF_IMAGE, OF_IMAGE>(OF_LOG, OF_LOG) + likely).try_inverse()?;
        let mixed = normal
            .fixed_view::<OF_IMAGE, OF_LOG>(OF_LOG, 0)
            .into_owned();
        let of_own = right.fixed_rows::<OF_IMAGE>(OF_LOG) + toward;
        let log = normal.fixed_view::<OF_LOG, OF_LOG>(0, 0) - mixed.transpose() * inverse * mixed;
        let to = right.fixed_rows::<OF_LOG>(0) - mixed.transpose() * inverse * of_own;
        Some(Self {
            sums: (log, to),
            inverse,
            mixed,
            right: of_own,
        })
    }

    /// The step of the image's own unknowns beside one of the log's.
    fn own(&self, step: &SVector<f64, OF_LOG>) -> SVector<f64, OF_IMAGE> {
        self.inverse * (self.right - self.mixed * step)
    }
}

impl Fitted<'_> {
    /// The ray's samples under the model.
    fn samples(
        &self,
        stated: f64,
        log: &SVector<f64, OF_LOG>,
        own: &SVector<f64, OF_IMAGE>,
        weights: [f64; 3],
    ) -> Vec<Sample> {
        let Ray {
            normal,
            moves,
            band,
            ..
        } = self.profile.ray;
        let [height, mean, cosine, sine, blur] = (*log).into();
        let [x, y, yaw, larger] = (*own).into();
        let side = mean + cosine * normal[0] + sine * normal[1];
        let is_dark = side < DARKEST;
        let side = side.max(DARKEST);
        let edge = moves[0] * x + moves[1] * y + moves[2] * yaw + larger + moves[3] * height;
        let inset = band * (1.0 + height / stated);
        let sample = |(t, bytes): &(f64, [f64; 3])| {
            let [within, rim] = [edge - inset - t, edge - t].map(|far| far / blur);
            let [face, solid] =
                [within, rim].map(|z| 0.5 * (1.0 + erf(z * std::f64::consts::FRAC_1_SQRT_2)));
            let [face_slope, solid_slope] =
                [within, rim].map(|z| (-0.5 * z * z).exp() / (std::f64::consts::TAU.sqrt() * blur));
            let (mut left, mut by_face, mut by_solid, mut by_side) = (0.0, 0.0, 0.0, 0.0);
            for i in 0..3 {
                let (inner, outer) = (self.inner[i], self.outer[i]);
                let rim = side * inner;
                let light = outer + solid * (rim - outer) + face * (inner - rim);
                let (byte, slope) = byte_of(light);
                left += weights[i] * (bytes[i] - byte);
                let slope = weights[i] * slope;
                by_face += slope * (inner - rim);
                by_solid += slope * (rim - outer);
                by_side += slope * (solid - face) * inner;
            }
            let by_inset = -by_face * face_slope;
            let by_edge = by_solid * solid_slope - by_inset;
            let by_side = if is_dark { 0.0 } else { by_side };
            let by_blur = -(by_face * face_slope * within + by_solid * solid_slope * rim);
            let row = [
                by_edge * moves[3] + by_inset * band / stated,
                by_side,
                by_side * normal[0],
                by_side * normal[1],
                by_blur,
                by_edge * moves[0],
                by_edge * moves[1],
                by_edge * moves[2],
                by_edge,
            ];
            Sample {
                left,
                row: SVector::from_fn(|k, _| row[k] * SCALES[k]),
            }
        };
        self.profile.bytes.iter().map(sample).collect()
    }
}

/// The least light of a side, of the upper face's.
const DARKEST: f64 = 0.02;
