//! The table, what stands on it, and the robot's base.

use values::{Interval, Obstacle, Point, Rig};

use super::draw::{Drawing, Ink, circle};

const TOP: Ink = Ink([0.30, 0.33, 0.38, 1.0]);
const EDGE: Ink = Ink([0.60, 0.64, 0.70, 1.0]);
const FENCE: Ink = Ink([0.85, 0.75, 0.35, 1.0]);
const OBSTACLE: Ink = Ink([0.80, 0.30, 0.30, 0.5]);
/// Thickness of the table and height of what stands on it, in m.
const THICKNESS: f64 = 0.01;
const HEIGHT: f64 = 0.03;
/// Radius of the robot's base as it is drawn, in m.
const BASE: f64 = 0.06;

/// What does not move.
pub fn table(rig: &Rig) -> Drawing {
    let mut drawing = Drawing::default();
    let (x, y) = (rig.table.x, rig.table.y);
    block(
        &mut drawing,
        x,
        y,
        [-1.5 * THICKNESS, -0.5 * THICKNESS],
        TOP,
    );
    drawing.outline(&corners(x, y), 0.0, EDGE);
    for fence in &rig.table.fences {
        drawing.line(&[fence.from, fence.to], HEIGHT, FENCE);
    }
    for obstacle in &rig.robot.obstacles {
        match *obstacle {
            Obstacle::Box { x, y } => {
                drawing.outline(&corners(x, y), HEIGHT, OBSTACLE);
                block(&mut drawing, x, y, [0.0, HEIGHT], OBSTACLE);
            }
            Obstacle::Disc { centre, radius } => {
                drawing.line(&circle(centre, radius), HEIGHT, OBSTACLE);
                drawing.post([centre.x, centre.y, 0.5 * HEIGHT], radius, HEIGHT, OBSTACLE);
            }
        }
    }
    let base = rig.robot.base.unwrap_or_default();
    drawing.line(&circle(base, BASE), 0.0, EDGE);
    drawing
}

fn corners(x: Interval, y: Interval) -> [Point; 4] {
    [
        Point::new(x.low, y.low),
        Point::new(x.high, y.low),
        Point::new(x.high, y.high),
        Point::new(x.low, y.high),
    ]
}

/// A slab between two heights.
fn block(drawing: &mut Drawing, x: Interval, y: Interval, [low, high]: [f64; 2], ink: Ink) {
    let middle = |low: f64, high: f64| 0.5 * (low + high);
    drawing.slab(
        [
            middle(x.low, x.high),
            middle(y.low, y.high),
            middle(low, high),
        ],
        [x.high - x.low, y.high - y.low, high - low],
        ink,
    );
}
