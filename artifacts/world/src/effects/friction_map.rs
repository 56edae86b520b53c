//! Friction that varies smoothly over the table, with no other form assumed: bumps on a grid, their heights drawn to none.
//!
//! μ(p) = μ·(1 + Σ h·exp(−|p − p_node|²/(2·w²))), each direction in its own spacing, w 0.8 of that.

use values::{Point, Rig};

use super::{
    action::{Acts, Effect, Slide},
    parameters::{EffectParameter, Parameters, Values},
    spec::{EffectSpec, Family, Naming},
    start::{Column, Experiment, FitStart},
    wording,
};

/// Nodes along x and y.
const ALONG: (usize, usize) = (5, 4);
const NODES: usize = ALONG.0 * ALONG.1;
/// Width of a bump over the distance of nodes: neighbours overlap, so that a sum of them is smooth.
const WIDTH: f64 = 0.8;
/// Least distance of nodes in m: a base of 3 cm sees nothing finer.
const LEAST_SPACING: f64 = 0.04;
/// Frames that must lie within a node's spacing for its height to be fitted.
const FRAMES: usize = 12;
/// Standard deviation of the heights before anything is measured: friction of real tables varies by 10 to 20 %.
const PRIOR: f64 = 0.15;
/// However deep bumps add up, this share of friction is left.
const LEAST_FACTOR: f64 = 0.05;

const NAMES: [&str; NODES] = [
    "height_00",
    "height_01",
    "height_02",
    "height_03",
    "height_10",
    "height_11",
    "height_12",
    "height_13",
    "height_20",
    "height_21",
    "height_22",
    "height_23",
    "height_30",
    "height_31",
    "height_32",
    "height_33",
    "height_40",
    "height_41",
    "height_42",
    "height_43",
];
const EDGES: [&str; 4] = ["low_x", "high_x", "low_y", "high_y"];

const fn edge(name: &'static str, neutral: f64) -> EffectParameter {
    EffectParameter {
        name,
        unit: "m",
        low: -5.0,
        high: 5.0,
        neutral,
        scale: 0.1,
    }
}

const fn parameters() -> [EffectParameter; NODES + 4] {
    let mut all = [edge("low_x", 0.2); NODES + 4];
    all[1] = edge("high_x", 0.8);
    all[2] = edge("low_y", -0.3);
    all[3] = edge("high_y", 0.3);
    let mut i = 0;
    while i < NODES {
        all[4 + i] = EffectParameter {
            name: NAMES[i],
            unit: "",
            low: -0.9,
            high: 3.0,
            neutral: 0.0,
            scale: PRIOR,
        };
        i += 1;
    }
    all
}

/// Friction map; parameters `low_x`, `high_x`, `low_y`, `high_y`: where the first and last nodes lie, and `height_ij`: of the
/// bump on the i-th node along x and the j-th along y, relative to friction.
pub const SPEC: EffectSpec = EffectSpec {
    name: "friction_map",
    parameters: Parameters::Listed(&parameters()),
    family: Family::FrictionByPlace,
    equivalent: &[],
    contains: &["friction_patch", "friction_gradient", "friction_step"],
    naming: Naming::LastResort,
    source: "friction varies over a table (Yu et al. 2016; Ma and Rodriguez 2018); Gaussian radial basis with a ridge",
    starts: grid,
    build: |values: &Values, _: &Rig| Box::new(FrictionMap::new(values)),
    statement: |values| {
        let map = FrictionMap::new(values);
        let factors = || (0..NODES).map(|node| (map.place(node), map.factor(map.place(node))));
        let nearest_one = (Point::default(), 1.0);
        let least = factors()
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or(nearest_one);
        let most = factors()
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or(nearest_one);
        let described = |(place, factor): (Point, f64)| {
            let change = wording::higher(factor - 1.0);
            format!("{change} around ({:.2}, {:.2}) m", place.x, place.y)
        };
        format!(
            "friction varies over the table: {}, {}",
            described(most),
            described(least)
        )
    },
};

fn grid(experiment: &Experiment<'_>) -> Vec<FitStart> {
    let [x, y] = experiment.extent();
    let form: Vec<(&str, f64)> = EDGES.into_iter().zip([x.0, x.1, y.0, y.1]).collect();
    let corner = Point::new(x.0, y.0);
    let spacing = spacing([x.1 - x.0, y.1 - y.0]);
    let frames = |node: usize| {
        let place = place(node, corner, spacing);
        let near = |point: Point| {
            let apart = point - place;
            (apart.x / spacing.x).abs() < 0.5 && (apart.y / spacing.y).abs() < 0.5
        };
        let strikes = experiment.strikes.iter();
        strikes
            .flat_map(|strike| (0..strike.track.len()).map(|i| strike.track.point(i)))
            .filter(|point| near(*point))
            .count()
    };
    let seen: Vec<&str> = (0..NODES)
        .filter(|node| frames(*node) >= FRAMES)
        .map(|node| NAMES[node])
        .collect();
    if seen.len() < 2 {
        return Vec::new();
    }
    let columns = seen.iter().map(|name| Column::new(&form, (name, 0.05)));
    let mut start = FitStart::new(columns.collect(), &seen);
    start.shrinks_to = Some(PRIOR);
    vec![start]
}

/// Distances of nodes in m along x and y.
fn spacing([x, y]: [f64; 2]) -> Point {
    let (i, j) = ((ALONG.0 - 1) as f64, (ALONG.1 - 1) as f64);
    Point::new((x / i).max(LEAST_SPACING), (y / j).max(LEAST_SPACING))
}

fn place(node: usize, corner: Point, spacing: Point) -> Point {
    let (i, j) = ((node / ALONG.1) as f64, (node % ALONG.1) as f64);
    corner + Point::new(i * spacing.x, j * spacing.y)
}

struct FrictionMap {
    heights: [f64; NODES],
    corner: Point,
    spacing: Point,
}

impl FrictionMap {
    fn new(values: &Values) -> Self {
        let [low_x, high_x, low_y, high_y] = EDGES.map(|name| values.get(name));
        Self {
            heights: NAMES.map(|name| values.get(name)),
            corner: Point::new(low_x, low_y),
            spacing: spacing([high_x - low_x, high_y - low_y]),
        }
    }

    fn place(&self, node: usize) -> Point {
        place(node, self.corner, self.spacing)
    }

    fn factor(&self, position: Point) -> f64 {
        let at = position - self.corner;
        let along = |at: f64, spacing: f64, node: usize| {
            (-0.5 * ((at / spacing - node as f64) / WIDTH).powi(2)).exp()
        };
        let by_x: [f64; ALONG.0] = std::array::from_fn(|i| along(at.x, self.spacing.x, i));
        let by_y: [f64; ALONG.1] = std::array::from_fn(|j| along(at.y, self.spacing.y, j));
        let heights = self.heights.iter().enumerate();
        let sum: f64 = heights
            .map(|(node, height)| height * by_x[node / ALONG.1] * by_y[node % ALONG.1])
            .sum();
        (1.0 + sum).max(LEAST_FACTOR)
    }
}

impl Effect for FrictionMap {
    fn acts(&self) -> Acts {
        Acts::Slide
    }

    fn friction_factor(&self, slide: &Slide<'_>) -> f64 {
        self.factor(slide.position)
    }

    fn stretch(&self, _: Point) -> f64 {
        WIDTH * self.spacing.x.min(self.spacing.y)
    }
}

#[cfg(test)]
mod tests {
    use values::Point;

    use crate::effects::tests::{Bench, DRY};

    #[test]
    fn it_changes_the_track() {
        Bench::with("friction_map", &[("height_12", 0.2)]).assert_changes_track();
    }

    #[test]
    fn the_stop_follows_its_formula() {
        let map = [
            ("low_x", 0.3),
            ("high_x", 0.7),
            ("low_y", -0.15),
            ("high_y", 0.15),
            ("height_12", 0.4),
            ("height_21", -0.2),
        ];
        let slid = Bench::with("friction_map", &map).slide(0.9, 0.1);
        slid.assert_integrates(|position, velocity| {
            let bump = |x: f64, y: f64| {
                let apart = position - Point::new(x, y);
                let width = 0.8 * 0.1;
                (-0.5 * apart.dot(apart) / (width * width)).exp()
            };
            let more = 0.4 * bump(0.4, 0.05) - 0.2 * bump(0.5, -0.05);
            velocity * (-DRY * more / velocity.norm())
        });
    }
}
