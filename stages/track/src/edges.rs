//! Where the object's edge lies along rays across its outline.
//!
//! Along a ray the contrast falls from the level of what is inside to that of the table. The area under it gives where the edge
//! is, whatever blurs it: lens, motion and compression spread an edge to both sides alike. A tall object shows a side that may be
//! darker than its upper face; between the two runs a second edge, a known width (`band`) further in.
//!
//! Where the rim has not the object's colour (print, a side in another colour, a deep shadow), the ray's own two colours take the place
//! of object and table, if what is outside is table.

use nalgebra::{Matrix3, Vector3};

use crate::colour::Map;
use crate::outline::{Outline, distance};
use crate::table::Table;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    /// Where it crosses the outline, in px.
    pub(crate) at: [f64; 2],
    /// Outwards, of length 1.
    pub(crate) normal: [f64; 2],
    /// How the crossing moves along the ray with x, y (px/m), yaw (px/rad) and the object's height (px/m).
    pub(crate) moves: [f64; 4],
    /// Width of the object's side along the ray, in px.
    pub(crate) band: f64,
}

/// Rays at even distances around an outline, about this far apart (px).
pub(crate) fn rays(outline: &Outline, spacing: f64) -> Vec<Ray> {
    let length = outline.length();
    let count = (length / spacing).clamp(FEWEST_RAYS, MOST_RAYS).round();
    let step = length / count;
    let mut rays = Vec::with_capacity(count as usize + 1);
    let mut next = 0.5 * step;
    for (a, b) in outline.edges() {
        let edge = distance(a.at, b.at);
        let along = [0, 1].map(|i| (b.at[i] - a.at[i]) / edge);
        let normal = [along[1], -along[0]];
        let across = |v: [f64; 2]| normal[0] * v[0] + normal[1] * v[1];
        while next < edge {
            let share = next / edge;
            let between = |p: [f64; 2], q: [f64; 2]| [0, 1].map(|i| p[i] + share * (q[i] - p[i]));
            let at = between(a.at, b.at);
            let top = outline.top.iter().map(|top| across(*top));
            let band = match top.reduce(f64::max) {
                Some(top) => (across(at) - top).max(0.0),
                None => 0.0,
            };
            rays.push(Ray {
                at,
                normal,
                moves: [0, 1, 2, 3].map(|i| across(between(a.moves[i], b.moves[i]))),
                band,
            });
            next += step;
        }
        next -= edge;
    }
    rays
}

const FEWEST_RAYS: f64 = 40.0;
const MOST_RAYS: f64 = 160.0;

/// Distance of samples along a ray, in px.
const STEP: f64 = 0.5;
/// A side at least this wide (px) shows how bright it is.
pub(crate) const WIDE_BAND: f64 = 2.5;
/// Least difference of the levels inside and outside, of 1, for an edge to be one.
const LEAST_STEP: f32 = 0.62;

/// The contrast along a ray, of that of the object's middle, is less than this: else the edge of a hard shadow runs between, and the profile's
/// area shows of that edge.
const MOST_VALUE: f32 = 1.52;

/// The least difference of a ray's own two colours, of the brighter one's light and of 1, and how far samples of an edge between them
/// may lie beyond either, of that difference: what is more is no edge alone.
const LEAST_OWN_SHARE: f32 = 0.35;
const LEAST_OWN: f32 = 0.02;
const MOST_OWN_SPREAD: f64 = 1.4;
const MOST_BEYOND: f32 = 0.35;
/// Limits of a profile: the least difference of its levels, and what its samples lie between.
const MAIN: [f32; 3] = [LEAST_STEP, f32::NEG_INFINITY, MOST_VALUE];
const OWN: [f32; 3] = [0.5, -MOST_BEYOND, 1.0 + MOST_BEYOND];

/// Where an edge was found: its distance outwards from the ray's crossing, in px; none where there is none.
pub(crate) type Edge = Option<f64>;

/// What was found along the rays.
pub(crate) struct Edges {
    pub(crate) found: Vec<Edge>,
    /// How bright this image shows the object's side.
    pub(crate) side: SideSums,
    profiles: Vec<Option<Profile>>,
    /// The side's brightness that they were found with.
    bright: Side,
}

/// Finds the edge along every ray, within `window` px of the outline, of which the outer `level` px on both ends give the levels.
/// `known` is the brightness of the object's sides where the log's other images tell it; else this image tells. Where it is strict, an edge
/// counts only if table is seen outside of it.
pub(crate) fn edges(
    map: &Map,
    table: &Table<'_>,
    rays: &[Ray],
    [window, level]: [f64; 2],
    (known, is_strict): (Option<&Side>, bool),
) -> Edges {
    let profiles: Vec<_> = rays
        .iter()
        .map(|ray| {
            let value =
                |t: f64| map.at(ray.at[0] + t * ray.normal[0], ray.at[1] + t * ray.normal[1]);
            Profile::along(value, ray, [window, level], MAIN)
        })
        .collect();
    let mut sums = SideSums::default();
    for (ray, profile) in rays.iter().zip(&profiles) {
        if let Some(ratio) = profile.as_ref().and_then(|profile| profile.side) {
            sums.add(ray, ratio.into());
        }
    }
    let side = known.copied().unwrap_or_else(|| sums.fit());
    let found = rays
        .iter()
        .zip(&profiles)
        .map(|(ray, profile)| match profile {
            Some(profile) => {
                let is_table = |t: f64| table.is_at([0, 1].map(|i| ray.at[i] + t * ray.normal[i]));
                if is_strict && !is_table(window) && !is_table(window - level) {
                    return None;
                }
                profile.edge(ray, window, &side)
            }
            None => {
                let value = own_contrast(table, ray, [window, level])?;
                let profile = Profile::along(value, ray, [window, level], OWN)?;
                let edge = profile.edge(ray, window, &side)?;
                // Two edges, of a print that ends near the rim, are wider than one.
                (profile.spread(ray, window, edge, &side) < MOST_OWN_SPREAD).then_some(edge)
            }
        });
    Edges {
        found: found.collect(),
        side: sums,
        profiles,
        bright: side,
    }
}

impl Edges {
    /// How wide most of the edges are blurred at the most: the mean distance, in px, by which the profile misses a step.
    pub(crate) fn spread(&self, rays: &[Ray], window: f64) -> f64 {
        let seen = rays.iter().zip(&self.profiles).zip(&self.found);
        let spreads = seen.filter_map(|((ray, profile), edge)| {
            let profile = profile.as_ref()?;
            Some(profile.spread(ray, window, (*edge)?, &self.bright))
        });
        let mut spreads: Vec<f64> = spreads.collect();
        spreads.sort_by(f64::total_cmp);
        let most = (MOST_SPREADS * spreads.len() as f64) as usize;
        spreads.get(most).copied().unwrap_or(0.0)
    }
}

/// Share of the edges that are blurred no more than is said: those across the movement are blurred less, glints more.
const MOST_SPREADS: f64 = 0.85;

/// How far a point of a ray has the colour of its inner end (1) and not that of its outer end (0), where those differ and the outer one is
/// table.
fn own_contrast<'a>(
    table: &'a Table<'_>,
    ray: &'a Ray,
    [window, level]: [f64; 2],
) -> Option<impl Fn(f64) -> Option<f32> + 'a> {
    let at = move |t: f64| [0, 1].map(|i| ray.at[i] + t * ray.normal[i]);
    type Seen = Option<[f32; 3]>;
    let mean = |of: &dyn Fn(f64) -> Seen, [from, to]: [f64; 2]| -> Seen {
        let (a, b, c) = (of(from)?, of(0.5 * (from + to))?, of(to)?);
        Some([0, 1, 2].map(|i| (a[i] + b[i] + c[i]) / 3.0))
    };
    let from = -(ray.band + window);
    let ends = [[from, from + level], [window - level, window]];
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let less = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|i| a[i] - b[i]);
    let light = |t: f64| table.light_at(at(t));
    let [inner, outer] = [mean(&light, ends[0])?, mean(&light, ends[1])?];
    let off = less(inner, outer);
    let bright = dot(inner, inner).max(dot(outer, outer)).sqrt();
    let is_apart = dot(off, off).sqrt() > LEAST_OWN.max(LEAST_OWN_SHARE * bright);
    let is_table_outside = ends[1].iter().all(|t| table.is_at(at(*t)));
    if !(is_apart && is_table_outside) {
        return None;
    }
    let codes = move |t: f64| table.codes_at(at(t));
    let [inner, outer] = [mean(&codes, ends[0])?, mean(&codes, ends[1])?];
    let off = less(inner, outer);
    let square = dot(off, off);
    Some(move |t: f64| Some(dot(less(codes(t)?, outer), off) / square))
}

/// What the contrast does along one ray.
struct Profile {
    /// Where it begins, in px outwards from the ray's crossing.
    from: f64,
    /// Its integral from there on, in px.
    area: f32,
    /// Level at the inner end.
    inner: f32,
    /// Level at the outer end.
    outer: f32,
    /// Level of the object's side over that of its upper face, where the side is wide.
    side: Option<f32>,
    /// Its samples, from the inner end on.
    values: Vec<f32>,
}

impl Profile {
    /// From `band + window` px inside the outline to `window` px outside; from nearer where a print ends the object's colour before. None
    /// where the levels differ by less than the first of `limits`, or a sample lies outside the others.
    fn along(
        value: impl Fn(f64) -> Option<f32>,
        ray: &Ray,
        [window, level]: [f64; 2],
        [least_step, lowest, highest]: [f32; 3],
    ) -> Option<Self> {
        let from = -(ray.band + window);
        let count = ((window - from) / STEP).round().max(1.0);
        let step = (window - from) / count;
        let mut values = Vec::with_capacity(count as usize);
        let (mut inner, mut outer, mut side) = ((0.0, 0.0), (0.0, 0.0), (0.0, 0.0));
        let add = |sum: &mut (f32, f32), value: f32| {
            sum.0 += value;
            sum.1 += 1.0;
        };
        for k in 0..count as usize {
            let t = from + (k as f64 + 0.5) * step;
            let value = value(t)?;
            if !(lowest..highest).contains(&value) {
                return None;
            }
            values.push(value);
            if t < from + level {
                add(&mut inner, value);
            } else if t > window - level {
                add(&mut outer, value);
            } else if ray.band > WIDE_BAND && t > 1.0 - ray.band && t < -1.0 {
                add(&mut side, value);
            }
        }
        let mean = |(sum, count): (f32, f32)| sum / count;
        let mut profile = Self {
            from,
            area: 0.0,
            inner: mean(inner),
            outer: mean(outer),
            side: (side.1 > 0.0).then(|| mean(side) / mean(inner)),
            values,
        };
        profile.begin_behind_print(step)?;
        profile.area = profile.values.iter().sum::<f32>() * step as f32;
        (profile.inner - profile.outer > least_step).then_some(profile)
    }

    /// Where the object's colour is stronger nearer to the rim than at the inner end, a print lies there: the profile begins where that
    /// colour does. None where too little is left.
    fn begin_behind_print(&mut self, step: f64) -> Option<()> {
        /// How much stronger, and which share of the strongest is that colour.
        const STRONGER: f32 = 1.09;
        const SAME: f32 = 0.93;
        let three = |k: usize| (self.values[k - 1] + self.values[k] + self.values[k + 1]) / 3.0;
        let last = self.values.len().checked_sub(2)?;
        let most = (1..=last).map(three).fold(0.0, f32::max);
        if most < STRONGER * self.inner {
            return Some(());
        }
        let begin = (1..=last).rev().find(|k| three(*k) > SAME * most)?;
        let begin = begin.saturating_sub(1).max(1);
        self.inner = three(begin);
        self.from += begin as f64 * step;
        self.side = None;
        self.values.drain(..begin);
        (self.from < -1.0).then_some(())
    }

    /// With the edge at d, the upper face at `inner` up to d − band, the side up to d and the table at `outer` beyond, the area
    /// is inner·(d − band − from) + side·band + outer·(window − d): solved for d. A profile that begins on the side has no more of it.
    fn edge(&self, ray: &Ray, window: f64, side: &Side) -> Edge {
        let [area, inner, outer] = [self.area, self.inner, self.outer].map(f64::from);
        let band = self.band(ray);
        let ratio = if band > 0.0 { side.ratio(ray) } else { 1.0 };
        let d = (area + inner * self.from + inner * (1.0 - ratio) * band - outer * window)
            / (inner - outer);
        (d.abs() < window).then_some(d)
    }

    /// Width of the side along the ray, as far as the profile has its edge.
    fn band(&self, ray: &Ray) -> f64 {
        if self.from < -ray.band - 0.5 {
            ray.band
        } else {
            0.0
        }
    }

    /// Mean distance, in px, by which the profile misses a step at `edge`.
    fn spread(&self, ray: &Ray, window: f64, edge: f64, side: &Side) -> f64 {
        let (from, band) = (self.from, self.band(ray));
        let step = (window - from) / self.values.len() as f64;
        let rim = self.inner * side.ratio(ray) as f32;
        let missed = self.values.iter().enumerate().map(|(k, value)| {
            let t = from + (k as f64 + 0.5) * step;
            let level = if t > edge {
                self.outer
            } else if t > edge - band {
                rim
            } else {
                self.inner
            };
            f64::from((value - level).abs())
        });
        missed.sum::<f64>() * step / f64::from(self.inner - self.outer)
    }
}

/// What images show of how bright the object's side is: sums of a least-squares fit.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SideSums {
    normal: Matrix3<f64>,
    right: Vector3<f64>,
    count: f64,
}

/// How bright the object's side is, of its upper face: a + b·cos + c·sin of the direction that it faces in the image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side(pub(crate) [f64; 3]);

impl SideSums {
    /// Rays from which a side's brightness is taken, at the least.
    const FEWEST: f64 = 5.0;
    const RIDGE: f64 = 0.02;

    fn add(&mut self, ray: &Ray, ratio: f64) {
        let row = Vector3::new(1.0, ray.normal[0], ray.normal[1]);
        self.normal += row * row.transpose();
        self.right += ratio * row;
        self.count += 1.0;
    }

    pub(crate) fn plus(&self, other: &Self) -> Self {
        Self {
            normal: self.normal + other.normal,
            right: self.right + other.right,
            count: self.count + other.count,
        }
    }

    pub(crate) fn fit(&self) -> Side {
        if self.count < Self::FEWEST {
            return Side([1.0, 0.0, 0.0]);
        }
        // What is seen in one direction says nothing of others: a ridge keeps them at the mean.
        let mut normal = self.normal;
        for i in [1, 2] {
            normal[(i, i)] += Self::RIDGE * self.count;
        }
        let solved = normal.cholesky().map(|normal| normal.solve(&self.right));
        Side(solved.map_or([1.0, 0.0, 0.0], Into::into))
    }
}

impl Side {
    fn ratio(&self, ray: &Ray) -> f64 {
        let Self([a, b, c]) = self;
        (a + b * ray.normal[0] + c * ray.normal[1]).clamp(0.0, 2.0)
    }
}
