//! The change of a pose that lays an outline on the edges seen: least squares with Tukey's weights, and how well the edges
//! determine it.

use nalgebra::{Matrix3, Matrix4, SMatrix, SVector, Vector4};

use crate::edges::{Edge, Ray};

/// A change of x, y (m), yaw (rad) and of the outline's size (px).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    pub(crate) parts: [f64; 4],
    /// What edges scatter by, in px.
    scale: f64,
    /// The inverse of what the edges say of the parts, where each scatters by 1 px.
    inverse: Matrix4<f64>,
}

/// What is known of an outline beside its edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Prior {
    pub(crate) turns: bool,
    /// How much larger than it is the object is seen (px), and how well that is known (standard deviation, px): blur and sharpening move
    /// all edges alike. Where half of an outline is hidden, this separates its size from its place.
    pub(crate) larger: [f64; 2],
}

const FEWEST_EDGES: usize = 12;
const ROUNDS: usize = 4;
/// Rounds where a part is left out: the rest is near.
const ROUNDS_OF_PART: usize = 2;
/// Tukey's constant, and the least scale of residuals in px: what edges scatter by in a good image.
const TUKEY: f64 = 4.7;
const LEAST_SCALE: f64 = 0.08;
/// A deviation of a normal distribution, of the median of its absolute values.
const DEVIATION: f64 = 1.4826;
/// Parts of what is seen of an outline, of which so many in a row are left out.
const PARTS: usize = 9;
const LEFT_OUT: usize = 3;
/// Neighbouring rays see the same pixels: so many say what one would say alone.
const ALIKE: f64 = 2.5;

impl Change {
    /// The change that lies best on the edges; none where they are too few.
    pub(crate) fn least(rays: &[Ray], found: &[Edge], prior: &Prior) -> Option<Self> {
        let known: Vec<Known<'_>> = known(rays, found).collect();
        Self::of(&known, prior, ROUNDS)
    }

    fn of(known: &[Known<'_>], prior: &Prior, rounds: usize) -> Option<Self> {
        if known.len() < FEWEST_EDGES {
            return None;
        }
        // At first all edges are off by the first guess: their median stands for what is left.
        let mut change = Self {
            parts: [0.0; 4],
            scale: f64::INFINITY,
            inverse: Matrix4::zeros(),
        };
        let mut left: Vec<f64> = Vec::with_capacity(known.len());
        for _ in 0..rounds {
            let (mut normal, mut right) = (Matrix4::<f64>::zeros(), Vector4::<f64>::zeros());
            for &(ray, edge) in known {
                let weight = change.weight(ray, edge);
                let yaw = if prior.turns { ray.moves[2] } else { 0.0 };
                let row = Vector4::new(ray.moves[0], ray.moves[1], yaw, 1.0);
                normal += weight * row * row.transpose();
                right += weight * edge * row;
            }
            if !prior.turns {
                normal[(2, 2)] = 1.0;
            }
            let [larger, deviation] = prior.larger;
            let scale = if change.scale.is_finite() {
                change.scale
            } else {
                1.0
            };
            let trust = ALIKE * (scale / deviation).powi(2);
            normal[(3, 3)] += trust;
            right[3] += trust * larger;
            // Positions in m and sizes in px: scaled to ones on the diagonal, so that singular is singular in any unit.
            let scales = normal.diagonal().map(|square| 1.0 / square.sqrt());
            let scaled = Matrix4::from_fn(|i, j| normal[(i, j)] * scales[i] * scales[j]);
            let inverse = scaled.cholesky()?.inverse();
            change.inverse = Matrix4::from_fn(|i, j| inverse[(i, j)] * scales[i] * scales[j]);
            change.parts = (change.inverse * right).into();
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

    /// Standard deviation of a coordinate of the centre, in m: as the edges scatter one by one, and as they do side by side, which a jackknife
    /// of blocks shows: any third of what is seen of the outline is left out. What covers, cuts or blinds one side, and the edges of
    /// compression, move that side's edges together. None where the rest does not determine the centre.
    pub(crate) fn deviation(&self, rays: &[Ray], found: &[Edge], prior: &Prior) -> Option<f64> {
        let all: Vec<Known<'_>> = known(rays, found).collect();
        let part = |index: usize| index * PARTS / all.len();
        let mut squares = 0.0;
        for first in 0..PARTS {
            let is_kept = |index: usize| (part(index) + PARTS - first) % PARTS >= LEFT_OUT;
            let rest = all.iter().enumerate().filter(|(index, _)| is_kept(*index));
            let rest: Vec<Known<'_>> = rest.map(|(_, known)| *known).collect();
            let without = Self::of(&rest, prior, ROUNDS_OF_PART)?;
            let moved = [0, 1].map(|i| (without.parts[i] - self.parts[i]).powi(2));
            squares += (moved[0] + moved[1]) / PARTS as f64;
        }
        let scatter = 0.5 * (self.inverse[(0, 0)] + self.inverse[(1, 1)]);
        Some((ALIKE * self.scale * self.scale * scatter + squares).sqrt())
    }

    /// What the edges say of a pattern, by which each ray's edge is put out for each of its parts. The place of the object and its size
    /// are left open, so that sums of several images add up.
    pub(crate) fn pattern<const N: usize>(
        &self,
        rays: &[Ray],
        found: &[Edge],
        prior: &Prior,
        of: impl Fn(&Ray) -> SVector<f64, N>,
    ) -> PatternSums<N> {
        let (mut normal, mut right) = (Matrix4::<f64>::zeros(), Vector4::<f64>::zeros());
        let mut mixed = SMatrix::<f64, 4, N>::zeros();
        let mut sums = PatternSums::<N>::default();
        for (ray, edge) in known(rays, found) {
            let weight = self.weight(ray, edge) / (ALIKE * self.scale * self.scale);
            let yaw = if prior.turns { ray.moves[2] } else { 0.0 };
            let row = Vector4::new(ray.moves[0], ray.moves[1], yaw, 1.0);
            let out = of(ray);
            let left = self.left(ray, edge);
            normal += weight * row * row.transpose();
            right += weight * left * row;
            mixed += weight * row * out.transpose();
            sums.normal += weight * out * out.transpose();
            sums.right += weight * left * out;
        }
        if !prior.turns {
            normal[(2, 2)] = 1.0;
        }
        let Some(inverse) = normal.try_inverse() else {
            return PatternSums::default();
        };
        PatternSums {
            normal: sums.normal - mixed.transpose() * inverse * mixed,
            right: sums.right - mixed.transpose() * inverse * right,
        }
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

/// What images say of a pattern by where edges lie: sums of a least-squares fit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PatternSums<const N: usize> {
    pub(crate) normal: SMatrix<f64, N, N>,
    pub(crate) right: SVector<f64, N>,
}

impl<const N: usize> Default for PatternSums<N> {
    fn default() -> Self {
        Self {
            normal: SMatrix::zeros(),
            right: SVector::zeros(),
        }
    }
}

/// The brightness of the object's side beyond the one that edges were found with (a + b·cos + c·sin of the direction that it faces): a side
/// taken for brighter than it is puts each edge out by its width.
pub(crate) type BandSums = PatternSums<3>;

impl BandSums {
    /// What the side's brightness may differ by from what its pixels show, of the upper face's (standard deviation).
    const LIKELY: f64 = 0.25;

    pub(crate) fn plus(&self, other: &Self) -> Self {
        Self {
            normal: self.normal + other.normal,
            right: self.right + other.right,
        }
    }

    /// The side's brightness less the one that the edges were found with.
    pub(crate) fn fit(&self) -> [f64; 3] {
        let prior = Matrix3::identity() / (Self::LIKELY * Self::LIKELY);
        let solved = (self.normal + prior).cholesky();
        solved.map_or([0.0; 3], |normal| normal.solve(&self.right).into())
    }
}

/// A ray and where its edge is, in px.
type Known<'a> = (&'a Ray, f64);

fn known<'a>(rays: &'a [Ray], found: &'a [Edge]) -> impl Iterator<Item = Known<'a>> {
    let pairs = rays.iter().zip(found);
    pairs.filter_map(|(ray, edge)| Some((ray, (*edge)?)))
}
