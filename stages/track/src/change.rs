//! The change of a pose that lays an outline on the edges seen: least squares with Tukey's weights, and how far a part of the outline
//! decides it.

use crate::edges::{Edge, Ray};
use crate::linear::solve;

/// A change of x, y (m), yaw (rad) and of the outline's size (px).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    pub(crate) parts: [f64; 4],
    /// What edges scatter by, in px.
    scale: f64,
}

/// Fewest edges.
const FEWEST_EDGES: usize = 16;
/// Rounds of weights.
const ROUNDS: usize = 4;
/// The same where a part is left out: the rest is near.
const ROUNDS_OF_PART: usize = 2;
/// Tukey's constant, and the least scale of residuals in px: what edges scatter by in a good image.
const TUKEY: f64 = 4.7;
const LEAST_SCALE: f64 = 0.08;
/// A deviation of a normal distribution, of the median of its absolute values.
const DEVIATION: f64 = 1.4826;
/// Parts of an outline, of which so many in a row are left out.
const PARTS: usize = 9;
const LEFT_OUT: usize = 3;

impl Change {
    /// The change that lies best on the edges; none where they are too few.
    pub(crate) fn least(rays: &[Ray], found: &[Edge], turns: bool) -> Option<Self> {
        let known: Vec<Known<'_>> = known(rays, found, |_| true).collect();
        Self::of(&known, turns, ROUNDS)
    }

    fn of(known: &[Known<'_>], turns: bool, rounds: usize) -> Option<Self> {
        if known.len() < FEWEST_EDGES {
            return None;
        }
        // At first all edges are off by the first guess: their median stands for what is left.
        let mut change = Self {
            parts: [0.0; 4],
            scale: f64::INFINITY,
        };
        let mut left: Vec<f64> = Vec::with_capacity(known.len());
        for _ in 0..rounds {
            let mut normal = [[0.0; 5]; 4];
            for &(ray, edge) in known {
                let weight = change.weight(ray, edge);
                let yaw = if turns { ray.moves[2] } else { 0.0 };
                let row = [ray.moves[0], ray.moves[1], yaw, 1.0, edge];
                for i in 0..4 {
                    for j in 0..5 {
                        normal[i][j] += weight * row[i] * row[j];
                    }
                }
            }
            if !turns {
                normal[2][2] = 1.0;
            }
            change.parts = solve(normal)?;
            left.clear();
            left.extend(
                known
                    .iter()
                    .map(|(ray, edge)| change.left(ray, *edge).abs()),
            );
            let middle = left.len() / 2;
            let (_, median, _) = left.select_nth_unstable_by(middle, f64::total_cmp);
            change.scale = (DEVIATION * *median).max(LEAST_SCALE);
        }
        Some(change)
    }

    /// What is left of each ray's edge, in px.
    pub(crate) fn residuals(&self, rays: &[Ray], found: &[Edge]) -> Vec<Edge> {
        let pairs = rays.iter().zip(found);
        pairs
            .map(|(ray, edge)| Some(self.left(ray, (*edge)?)))
            .collect()
    }

    /// How far (m) the centre moves at the most when any third of the outline is left out, as a jackknife of blocks does. What covers,
    /// cuts or blinds one side moves the edges of that side together: alike enough to agree with an outline that is moved towards them.
    /// None where the rest does not determine the centre.
    pub(crate) fn pull(&self, rays: &[Ray], found: &[Edge], turns: bool) -> Option<f64> {
        let part = |index: usize| index * PARTS / rays.len();
        let mut most = 0.0f64;
        for first in 0..PARTS {
            let is_kept = |index: usize| (part(index) + PARTS - first) % PARTS >= LEFT_OUT;
            let rest: Vec<Known<'_>> = known(rays, found, is_kept).collect();
            let without = Self::of(&rest, turns, ROUNDS_OF_PART)?;
            let moved = [0, 1].map(|i| without.parts[i] - self.parts[i]);
            most = most.max(moved[0].hypot(moved[1]));
        }
        Some(most)
    }

    fn left(&self, ray: &Ray, edge: f64) -> f64 {
        let [x, y, yaw, larger] = self.parts;
        edge - (ray.moves[0] * x + ray.moves[1] * y + ray.moves[2] * yaw + larger)
    }

    fn weight(&self, ray: &Ray, edge: f64) -> f64 {
        let share = self.left(ray, edge) / (TUKEY * self.scale);
        if share.abs() < 1.0 {
            (1.0 - share * share).powi(2)
        } else {
            0.0
        }
    }
}

/// A ray and where its edge is, in px.
type Known<'a> = (&'a Ray, f64);

/// The rays with an edge, of those whose number is kept.
fn known<'a>(
    rays: &'a [Ray],
    found: &'a [Edge],
    is_kept: impl Fn(usize) -> bool,
) -> impl Iterator<Item = Known<'a>> {
    let pairs = rays.iter().zip(found).enumerate();
    pairs.filter_map(move |(index, (ray, edge))| Some((ray, (*edge)?)).filter(|_| is_kept(index)))
}
