//! Where the object's edge lies along rays across its outline.
//!
//! Along a ray the contrast falls from the level of what is inside to that of the table. The area under it gives where the edge
//! is, whatever blurs it: lens, motion and compression spread an edge to both sides alike. A tall object shows a side that may be
//! darker than its upper face; between the two runs a second edge, a known width (`band`) further in.

use crate::colour::Map;
use crate::linear::solve;
use crate::outline::{Outline, distance};

/// A ray across the outline.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    /// Where it crosses the outline, in px.
    pub(crate) at: [f64; 2],
    /// Outwards, of length 1.
    pub(crate) normal: [f64; 2],
    /// How the crossing moves along the ray with x, y (px/m) and yaw (px/rad).
    pub(crate) moves: [f64; 3],
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
                moves: [0, 1, 2].map(|i| across(between(a.moves[i], b.moves[i]))),
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
const WIDE_BAND: f64 = 2.5;
/// Least difference of the levels inside and outside, of 1, for an edge to be one.
const LEAST_STEP: f32 = 0.35;

/// The object's light along a ray, of its middle's, is less than this: else the edge of a hard shadow runs between, and the profile's area
/// shows of that edge.
const MOST_VALUE: f32 = 2.5;

/// Where an edge was found: its distance outwards from the ray's crossing, in px; none where there is none.
pub(crate) type Edge = Option<f64>;

/// Finds the edge along every ray, within `window` px of the outline, of which the outer `level` px on both ends give the levels.
pub(crate) fn edges(map: &Map, rays: &[Ray], window: f64, level: f64) -> Vec<Edge> {
    let profiles: Vec<_> = rays
        .iter()
        .map(|ray| Profile::along(map, ray, window, level))
        .collect();
    let side = Side::fit(rays, &profiles);
    let found = rays.iter().zip(&profiles);
    found
        .map(|(ray, profile)| profile.as_ref()?.edge(ray, window, &side))
        .collect()
}

/// What the contrast does along one ray.
struct Profile {
    /// Its integral over the window, in px.
    area: f32,
    /// Level at the inner end.
    inner: f32,
    /// Level at the outer end.
    outer: f32,
    /// Level of the object's side over that of its upper face, where the side is wide.
    side: Option<f32>,
}

impl Profile {
    /// From `band + window` px inside the outline to `window` px outside.
    fn along(map: &Map, ray: &Ray, window: f64, level: f64) -> Option<Self> {
        let from = -(ray.band + window);
        let count = ((window - from) / STEP).round().max(1.0);
        let step = (window - from) / count;
        let (mut area, mut inner, mut outer, mut side) = (0.0, (0.0, 0.0), (0.0, 0.0), (0.0, 0.0));
        let mut most = 0.0f32;
        let add = |sum: &mut (f32, f32), value: f32| {
            sum.0 += value;
            sum.1 += 1.0;
        };
        for k in 0..count as usize {
            let t = from + (k as f64 + 0.5) * step;
            let value = map.at(ray.at[0] + t * ray.normal[0], ray.at[1] + t * ray.normal[1])?;
            area += value;
            most = most.max(value);
            if t < from + level {
                add(&mut inner, value);
            } else if t > window - level {
                add(&mut outer, value);
            } else if ray.band > WIDE_BAND && t > 1.0 - ray.band && t < -1.0 {
                add(&mut side, value);
            }
        }
        let mean = |(sum, count): (f32, f32)| sum / count;
        let (inner, outer) = (mean(inner), mean(outer));
        let is_edge = inner - outer > LEAST_STEP && most < MOST_VALUE;
        is_edge.then(|| Self {
            area: area * step as f32,
            inner,
            outer,
            side: (side.1 > 0.0).then(|| mean(side) / inner),
        })
    }

    /// With the edge at d, the upper face at `inner` up to d − band, the side up to d and the table at `outer` beyond, the area
    /// is inner·(d + window) + side·band + outer·(window − d): solved for d.
    fn edge(&self, ray: &Ray, window: f64, side: &Side) -> Edge {
        let [area, inner, outer] = [self.area, self.inner, self.outer].map(f64::from);
        let band = inner * side.ratio(ray) * ray.band;
        let d = (area - band - (inner + outer) * window) / (inner - outer);
        (d.abs() < window).then_some(d)
    }
}

/// How bright the side is, of the upper face: a + b·cos + c·sin of the direction that it faces.
struct Side([f64; 3]);

impl Side {
    fn fit(rays: &[Ray], profiles: &[Option<Profile>]) -> Self {
        let mut normal = [[0.0; 4]; 3];
        let mut count = 0;
        for (ray, profile) in rays.iter().zip(profiles) {
            let Some(ratio) = profile.as_ref().and_then(|profile| profile.side) else {
                continue;
            };
            count += 1;
            let row = [1.0, ray.normal[0], ray.normal[1], f64::from(ratio)];
            for i in 0..3 {
                for j in 0..4 {
                    normal[i][j] += row[i] * row[j];
                }
            }
        }
        if count < Self::FEWEST {
            return Self([1.0, 0.0, 0.0]);
        }
        // What is seen in one direction says nothing of others: a ridge keeps them at the mean.
        for (i, row) in normal.iter_mut().enumerate().skip(1) {
            row[i] += Self::RIDGE * f64::from(count);
        }
        Self(solve(normal).unwrap_or([1.0, 0.0, 0.0]))
    }

    /// Rays from which a side's brightness is taken, at the least.
    const FEWEST: u32 = 5;
    const RIDGE: f64 = 0.02;

    fn ratio(&self, ray: &Ray) -> f64 {
        let Self([a, b, c]) = self;
        (a + b * ray.normal[0] + c * ray.normal[1]).clamp(0.0, 2.0)
    }
}
