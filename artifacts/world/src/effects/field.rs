//! A smooth field over the table: bumps on a grid, f(p) = Σ h·exp(−½·|(p − p_node)/w|²), each direction in its own spacing.
//!
//! Parameters: `low_x`, `high_x`, `low_y`, `high_y`, where the first and last nodes lie, and `node_k`, the height of the bump on the k-th node, those along y
//! first. Nodes are about as far apart along x as along y.

use values::Point;

use super::{Column, EffectParameter, Experiment, FitStart, Values};

/// Width of a bump over the distance of nodes: neighbours overlap, so that a sum of them is smooth.
const WIDTH: f64 = 0.8;
/// Least distance of nodes in m: a base of 3 cm sees nothing finer.
const LEAST_SPACING: f64 = 0.04;
/// Frames that must lie within a node's spacing for its height to be fitted.
const FRAMES: usize = 12;

const EDGES: [&str; 4] = ["low_x", "high_x", "low_y", "high_y"];
/// Nodes at the most, and along one direction.
const MOST: usize = 120;
const MOST_ALONG: usize = 16;
const FEWEST_ALONG: usize = 3;
const NAMES: [&str; MOST] = {
    macro_rules! ten {
        ($($ten:literal)*) => {
            [$(ten!(@ $ten 0 1 2 3 4 5 6 7 8 9)),*]
        };
        (@ $ten:literal $($one:literal)*) => { [$(concat!("node_", $ten, $one)),*] };
    }
    let tens = ten!("" "1" "2" "3" "4" "5" "6" "7" "8" "9" "10" "11");
    let mut names = [""; MOST];
    let mut node = 0;
    while node < MOST {
        names[node] = tens[node / 10][node % 10];
        node += 1;
    }
    names
};

const fn edge(name: &'static str, neutral: f64) -> EffectParameter {
    EffectParameter::new(name, "m", [-5.0, 5.0], 0.1).neutral_at(neutral)
}

#[derive(Clone, Copy)]
pub(super) struct Nodes {
    /// Greatest number of nodes.
    pub(super) count: usize,
    /// A height: its unit and range, and as its scale the standard deviation before anything is measured; its name is not used.
    pub(super) height: EffectParameter,
}

impl Nodes {
    /// All parameters; `ALL` is the number of nodes and four.
    pub(super) const fn parameters<const ALL: usize>(self) -> [EffectParameter; ALL] {
        let mut all = [edge("low_x", 0.2); ALL];
        all[1] = edge("high_x", 0.8);
        all[2] = edge("low_y", -0.3);
        all[3] = edge("high_y", 0.3);
        let mut node = 0;
        while node < self.count {
            all[4 + node] = EffectParameter {
                name: NAMES[node],
                ..self.height
            };
            node += 1;
        }
        all
    }

    /// Number of nodes along x and y of a field between these.
    fn along(self, [low_x, high_x, low_y, high_y]: [f64; 4]) -> (usize, usize) {
        let (x, y) = (
            (high_x - low_x).max(LEAST_SPACING),
            (high_y - low_y).max(LEAST_SPACING),
        );
        let count = self.count as f64;
        let most = (self.count / FEWEST_ALONG).min(MOST_ALONG);
        let j = ((count * y / x).sqrt().round() as usize).clamp(FEWEST_ALONG, most);
        ((self.count / j).min(MOST_ALONG), j)
    }

    /// The one start of a fit: a column of this height for each node that strikes passed.
    pub(super) fn starts(self, experiment: &Experiment<'_>, height: f64) -> Vec<FitStart> {
        let [x, y] = experiment.extent();
        let edges = [x.0, x.1, y.0, y.1];
        let form: Vec<(&str, f64)> = EDGES.into_iter().zip(edges).collect();
        let field = Field::new(self.along(edges), edges, Vec::new());
        let frames = |place: Point| {
            let near = |point: Point| {
                let apart = point - place;
                (apart.x / field.spacing.x).abs() < 0.5 && (apart.y / field.spacing.y).abs() < 0.5
            };
            let strikes = experiment.strikes.iter();
            strikes
                .flat_map(|strike| (0..strike.track.len()).map(|i| strike.track.point(i)))
                .filter(|point| near(*point))
                .count()
        };
        let nodes = 0..field.along.0 * field.along.1;
        let seen: Vec<&str> = nodes
            .filter(|node| frames(field.place(*node)) >= FRAMES)
            .map(|node| NAMES[node])
            .collect();
        if seen.len() < 2 {
            return Vec::new();
        }
        let columns = seen.iter().map(|name| Column::new(&form, (name, height)));
        let mut start = FitStart::new(columns.collect(), &seen);
        start.shrinks_to = Some(self.height.scale);
        vec![start]
    }

    pub(super) fn field(self, values: &Values) -> Field {
        let edges = EDGES.map(|name| values.get(name));
        let along = self.along(edges);
        let names = NAMES[..along.0 * along.1].iter();
        Field::new(along, edges, names.map(|name| values.get(name)).collect())
    }
}

pub(super) struct Field {
    along: (usize, usize),
    heights: Vec<f64>,
    corner: Point,
    spacing: Point,
}

impl Field {
    fn new(
        along: (usize, usize),
        [low_x, high_x, low_y, high_y]: [f64; 4],
        heights: Vec<f64>,
    ) -> Self {
        let spacing = |width: f64, count: usize| (width / (count - 1) as f64).max(LEAST_SPACING);
        Self {
            along,
            heights,
            corner: Point::new(low_x, low_y),
            spacing: Point::new(
                spacing(high_x - low_x, along.0),
                spacing(high_y - low_y, along.1),
            ),
        }
    }

    fn place(&self, node: usize) -> Point {
        let (i, j) = (node / self.along.1, node % self.along.1);
        self.corner + Point::new(i as f64 * self.spacing.x, j as f64 * self.spacing.y)
    }

    /// Where the nodes lie, in m.
    pub(super) fn places(&self) -> impl Iterator<Item = Point> {
        (0..self.heights.len()).map(|node| self.place(node))
    }

    /// Value of the field, and its slope along x and y per metre.
    pub(super) fn at(&self, position: Point) -> (f64, Point) {
        let at = position - self.corner;
        // Of each node along one direction, the bump and its derivative.
        let along = |at: f64, spacing: f64, count: usize| -> [(f64, f64); MOST_ALONG] {
            let mut all = [(0.0, 0.0); MOST_ALONG];
            for (node, bump) in all.iter_mut().enumerate().take(count) {
                let apart = (at / spacing - node as f64) / WIDTH;
                let height = (-0.5 * apart * apart).exp();
                *bump = (height, -height * apart / (WIDTH * spacing));
            }
            all
        };
        let by_x = along(at.x, self.spacing.x, self.along.0);
        let by_y = along(at.y, self.spacing.y, self.along.1);
        let (mut value, mut slope) = (0.0, Point::default());
        for (row, (x, along_x)) in self.heights.chunks(self.along.1).zip(by_x) {
            let (mut sum, mut along_y) = (0.0, 0.0);
            for (height, (y, slope)) in row.iter().zip(by_y) {
                sum += height * y;
                along_y += height * slope;
            }
            value += x * sum;
            slope = slope + Point::new(along_x * sum, x * along_y);
        }
        (value, slope)
    }

    /// Distance in m within which it is smooth.
    pub(super) fn stretch(&self) -> f64 {
        WIDTH * self.spacing.x.min(self.spacing.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_as_far_apart_along_both_directions_and_no_more_than_their_number() {
        let height = EffectParameter::new("height", "m", [-0.2, 0.2], 0.003);
        let nodes = Nodes { count: 120, height };
        for [x, y] in [[0.8, 1.0], [1.2, 0.6], [0.7, 0.7], [0.3, 0.9]] {
            let edges = [0.1, 0.1 + x, -0.5 * y, 0.5 * y];
            let field = Field::new(nodes.along(edges), edges, Vec::new());
            let ratio = field.spacing.x / field.spacing.y;
            assert!((0.8..1.25).contains(&ratio), "{x} by {y} m: {ratio}");
            let count = field.along.0 * field.along.1;
            assert!((100..=120).contains(&count), "{x} by {y} m: {count}");
        }
        // One lane, or one place: as many along as there may be, and as few across.
        for edges in [
            [0.1, 2.1, 0.0, 0.0],
            [0.5, 0.5, -0.4, 0.4],
            [0.5, 0.5, 0.0, 0.0],
        ] {
            let (i, j) = nodes.along(edges);
            assert!(i >= FEWEST_ALONG && j >= FEWEST_ALONG && i * j <= 120);
        }
    }
}
