//! How one plane is seen on another.

use crate::homography::homography;

/// A homography: (x, y) to ((a·x + b·y + c) / (g·x + h·y + 1), (d·x + e·y + f) / (g·x + h·y + 1)), between points that are moved and
/// scaled to be about one from their middle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Homography {
    from: Scale,
    to: Scale,
    parts: [f64; 8],
}

#[derive(Clone, Copy, Debug)]
struct Scale {
    middle: [f64; 2],
    size: f64,
}

impl Scale {
    fn of(points: impl Iterator<Item = [f64; 2]> + Clone) -> Option<Self> {
        let count = points.clone().count() as f64;
        let sum = points
            .clone()
            .fold([0.0; 2], |sum, at| [sum[0] + at[0], sum[1] + at[1]]);
        let middle = sum.map(|sum| sum / count);
        let far = points.map(|at| (at[0] - middle[0]).hypot(at[1] - middle[1]));
        let size = far.sum::<f64>() / count;
        (size > 0.0 && size.is_finite()).then_some(Self { middle, size })
    }

    fn small(&self, at: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| (at[i] - self.middle[i]) / self.size)
    }

    fn large(&self, at: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| at[i] * self.size + self.middle[i])
    }
}

impl Homography {
    /// The one that lies best between pairs of points; none where they do not determine it.
    pub(crate) fn between(pairs: &[([f64; 2], [f64; 2])]) -> Option<Self> {
        let from = Scale::of(pairs.iter().map(|pair| pair.0))?;
        let to = Scale::of(pairs.iter().map(|pair| pair.1))?;
        let small = |pair: &([f64; 2], [f64; 2])| (from.small(pair.0), to.small(pair.1));
        let parts = homography(pairs.iter().map(small))?;
        Some(Self { from, to, parts })
    }

    pub(crate) fn seen(&self, at: [f64; 2]) -> [f64; 2] {
        let [x, y] = self.from.small(at);
        let [a, b, c, d, e, f, g, h] = self.parts;
        let depth = g * x + h * y + 1.0;
        self.to
            .large([(a * x + b * y + c) / depth, (d * x + e * y + f) / depth])
    }

    /// Its matrix, rows first, for points relative to `origin` on the side that is seen.
    pub(crate) fn matrix(&self, origin: [f64; 2]) -> [[f64; 3]; 3] {
        let [a, b, c, d, e, f, g, h] = self.parts;
        let small = |[p, q, r]: [f64; 3]| {
            let [x, y] = self.from.middle;
            let [p, q] = [p / self.from.size, q / self.from.size];
            [p, q, r - p * x - q * y]
        };
        let rows = [small([a, b, c]), small([d, e, f]), small([g, h, 1.0])];
        let across = |row: usize| {
            let off = self.to.middle[row] - origin[row];
            [0, 1, 2].map(|i| self.to.size * rows[row][i] + off * rows[2][i])
        };
        [across(0), across(1), rows[2]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_pairs_give_the_homography_and_its_matrix() {
        let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 3.0], [0.0, 3.0]];
        let quad = [[110.0, 60.0], [220.0, 80.0], [240.0, 260.0], [90.0, 240.0]];
        let pairs: Vec<_> = square.into_iter().zip(quad).collect();
        let plane = Homography::between(&pairs).expect("determined");
        let origin = [160.0, 120.0];
        let matrix = plane.matrix(origin);
        for (from, to) in pairs {
            let seen = plane.seen(from);
            let [u, v, w] = matrix.map(|row| row[0] * from[0] + row[1] * from[1] + row[2]);
            let by_matrix = [u / w + origin[0], v / w + origin[1]];
            for seen in [seen, by_matrix] {
                assert!((seen[0] - to[0]).hypot(seen[1] - to[1]) < 1e-9, "{seen:?}");
            }
        }
        let line: Vec<_> = (0..4).map(|k| ([f64::from(k), 0.0], quad[0])).collect();
        assert!(Homography::between(&line).is_none());
    }
}
