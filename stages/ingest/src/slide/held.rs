//! Where something takes hold of a sliding object.
//!
//! A table brakes an object about as hard all the way; a patch, a slope or drag make some difference. A hand, a mallet or an edge that it
//! runs against change its velocity many times as fast.

use values::{Point, Shape};

use super::frames::Frame;
use crate::robust::median;

/// Time, in s, over which velocities are taken, and no less than half of it.
const TIME: f64 = 0.06;
/// Least ratio of a change of velocity to that on the whole, and least difference (m/s²), that is no table's.
const HARDER: f64 = 4.0;
const MARGIN: f64 = 2.0;
/// Greatest deceleration by a table, in m/s²: all that is said of a ball, which slides before it rolls.
pub(super) const BRAKES: f64 = 10.0;
/// Time from the beginning, in s, over which a table's braking is taken, as well as over the whole slide; the greater counts.
const FIRST: f64 = 0.4;
/// Number of frames in a row that show it.
const IN_A_ROW: usize = 2;

/// Index of the frame from which on the object may be held, if it ever is.
pub(crate) fn held(frames: &[Frame], shape: Shape) -> Option<usize> {
    let changes: Vec<Option<f64>> = (0..frames.len()).map(|at| change(frames, at)).collect();
    let first = frames.partition_point(|frame| frame.t - frames[0].t <= FIRST);
    let usual = |changes: &[Option<f64>]| median(changes.iter().copied().flatten());
    let most = no_table(usual(&changes).max(usual(&changes[..first])), shape);
    let is_harder = |change: &Option<f64>| change.is_some_and(|change| change > most);
    changes
        .windows(IN_A_ROW)
        .position(|row| row.iter().all(is_harder))
}

/// Deceleration, in m/s², beyond that of any table that brakes so much on the whole.
pub(super) fn no_table(usual: f64, shape: Shape) -> f64 {
    match shape {
        Shape::Sphere => BRAKES + MARGIN,
        Shape::Cylinder | Shape::Box => HARDER * usual + MARGIN,
    }
}

/// How many frames to look at where the object rests from the frame `rest` on: what stops it may do so within its last frames.
pub(crate) fn held_until(frames: &[Frame], rest: usize) -> usize {
    let at = |rest: &Frame| frames.partition_point(|frame| frame.t <= rest.t + TIME);
    frames.get(rest).map_or(frames.len(), at)
}

/// By how much the velocity changes at a frame, in m/s²; none where there are too few frames before or after it.
fn change(frames: &[Frame], at: usize) -> Option<f64> {
    let now = &frames[at];
    let from = &frames[frames.partition_point(|frame| frame.t < now.t - TIME)];
    let to = &frames[frames.partition_point(|frame| frame.t <= now.t + TIME) - 1];
    let (before, after) = (now.t - from.t, to.t - now.t);
    let enough = before >= 0.5 * TIME && after >= 0.5 * TIME;
    let velocity = |one: &Frame, other: &Frame, time: f64| -> Point {
        (other.point - one.point) * (1.0 / time)
    };
    enough.then(|| {
        (velocity(now, to, after) - velocity(from, now, before)).norm() / (0.5 * (before + after))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames of places along x at 120 Hz.
    fn frames(place: impl Fn(f64) -> f64) -> Vec<Frame> {
        (0..90)
            .map(|i| {
                let t = f64::from(i) / 120.0;
                Frame {
                    stamp: 0,
                    t,
                    point: Point::new(place(t), 0.0),
                }
            })
            .collect()
    }

    #[test]
    fn a_hand_that_stops_a_puck_is_seen_and_what_tables_do_is_not() {
        // 1.2 m/s on an air table; from 0.4 s on a hand brakes it within 60 ms.
        let caught = frames(|t| {
            let late = (t - 0.4).clamp(0.0, 0.06);
            1.2 * t.min(0.46) - 0.02 * t * t - 10.0 * late * late
        });
        let at = held(&caught, Shape::Cylinder).expect("held");
        assert!((0.34..=0.4).contains(&caught[at].t), "{}", caught[at].t);
        // A slide to rest; friction that trebles half-way; drag.
        let slide = |t: f64| 1.4 * t.min(0.5) - 1.4 * t.min(0.5).powi(2);
        assert_eq!(held(&frames(slide), Shape::Cylinder), None);
        let patch = |t: f64| {
            let late = (t - 0.3).clamp(0.0, 0.22);
            1.8 * t.min(0.3) - 1.35 * t.min(0.3).powi(2) + (1.0 - 2.7 * late) * late
        };
        assert_eq!(held(&frames(patch), Shape::Cylinder), None);
        let drag = |t: f64| 2.0 / 0.5 * (1.0 - (-0.5 * t).exp());
        assert_eq!(held(&frames(drag), Shape::Cylinder), None);
        // A ball that slides before it rolls.
        let ball = |t: f64| t - 1.4 * t.min(0.1).powi(2) - 0.28 * (t - 0.1).max(0.0);
        assert_eq!(held(&frames(ball), Shape::Sphere), None);
    }
}
