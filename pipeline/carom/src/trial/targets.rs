//! Which targets a trial strikes at.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use strike::Planner;
use values::{Point, Strike, wrap_angle};

/// Starts and targets of the paper's Figure 8.
const STARTS: usize = 2;
/// Shares of the way from the shortest to the longest path, and from the rightmost to the leftmost bearing.
const TARGETS: [(f64, f64); 4] = [(0.25, 0.25), (0.25, 0.75), (0.75, 0.25), (0.75, 0.75)];
/// Figure 8's targets are drawn in towards the middle of what was trained by this share until they can be planned.
const SHRINK: f64 = 0.8;
const SHRINKS: u32 = 12;
/// Draws for each random target that is wanted.
const TRIES: usize = 20;
/// Share of training strikes at each end that targets keep clear of.
const EDGE: f64 = 0.02;

pub type Pair = (Point, Point);

/// Where the strikes that were learnt from started, and which paths they took.
pub struct Region {
    x: (f64, f64),
    y: (f64, f64),
    distance: (f64, f64),
    bearing: (f64, f64),
}

impl Region {
    /// The region of these strikes; none where there is no strike.
    pub fn of(strikes: &[Strike]) -> Option<Self> {
        // Bearings on either side of ±π are neighbours: they are taken relative to their middle.
        let sum = |sum: Point, strike: &Strike| sum + Point::polar(1.0, strike.path().bearing());
        let middle = strikes.iter().fold(Point::default(), sum).bearing();
        let ends = |value: &dyn Fn(&Strike) -> f64| {
            let mut values: Vec<f64> = strikes.iter().map(value).collect();
            values.sort_by(f64::total_cmp);
            let last = values.len().checked_sub(1)?;
            let skipped = (EDGE * last as f64).round() as usize;
            Some((values[skipped], values[last - skipped]))
        };
        Some(Self {
            x: ends(&|strike| strike.initial.x)?,
            y: ends(&|strike| strike.initial.y)?,
            distance: ends(&|strike| strike.path().norm())?,
            bearing: ends(&|strike| middle + wrap_angle(strike.path().bearing() - middle))?,
        })
    }

    /// The paper's Figure 8 for this rig: two starts, four targets each, near and far, right and left. All can be planned
    /// by `reference`, or are as near to the middle of what was trained as is tried.
    pub fn figure_8(&self, reference: &Planner) -> Vec<Pair> {
        (0..STARTS)
            .flat_map(|start| {
                let share = (start as f64 + 0.5) / STARTS as f64;
                let from = Point::new(between(self.x, 0.5), between(self.y, share));
                TARGETS.map(|target| (from, self.nearest_planned(reference, from, target)))
            })
            .collect()
    }

    fn nearest_planned(&self, reference: &Planner, from: Point, target: (f64, f64)) -> Point {
        let mut away = 1.0;
        let mut to = from;
        for _ in 0..SHRINKS {
            let towards = |share: f64| 0.5 + away * (share - 0.5);
            to = from
                + Point::polar(
                    between(self.distance, towards(target.0)),
                    between(self.bearing, towards(target.1)),
                );
            if reference.plan(from, to).is_ok() {
                break;
            }
            away *= SHRINK;
        }
        to
    }

    /// Random starts and targets that `reference` can plan, and how many were drawn in all.
    pub fn random(&self, reference: &Planner, count: usize, seed: u64) -> (Vec<Pair>, usize) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut pairs = Vec::with_capacity(count);
        let mut drawn = 0;
        while pairs.len() < count && drawn < TRIES * count {
            drawn += 1;
            let mut draw = |ends| between(ends, random.random::<f64>());
            let from = Point::new(draw(self.x), draw(self.y));
            let to = from + Point::polar(draw(self.distance), draw(self.bearing));
            if reference.plan(from, to).is_ok() {
                pairs.push((from, to));
            }
        }
        (pairs, drawn)
    }
}

fn between((low, high): (f64, f64), share: f64) -> f64 {
    low + share * (high - low)
}
