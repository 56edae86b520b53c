//! When an object begins to move.

use values::{Point, RejectReason};

use super::frames::{Frame, Frames};
use super::rest::Rest;
use super::tolerances::{SURELY_AWAY, SURELY_AWAY_NOISE};
use crate::rejection::{Detail, Rejection};
use crate::robust::median_point;

/// Distance from the frames right before that shows motion, in noise deviations.
const LEFT_NOISE: f64 = 5.0;
/// Latest first motion after the command fell back, in s: a camera's and a recorder's delay.
const LATEST_MOTION: f64 = 0.5;
/// Time, in s, after the command fell back from which what moves an object is no strike, whatever the clocks.
const UNRELATED: f64 = 3.0;

/// The first frame in motion.
pub(super) fn first_motion(frames: &Frames<'_>, rest: &Rest) -> Result<usize, Rejection> {
    const STAYS: usize = 5;
    const STAYS_AT_LEAST: usize = 4;
    let all = &frames.frames;
    let away = (SURELY_AWAY_NOISE * rest.noise).max(SURELY_AWAY);
    let is_away = |at: usize| all[at].point.distance(rest.place) > away;
    let sure = (frames.at(0.0)..all.len()).find(|at| {
        let until = all.len().min(at + STAYS);
        is_away(*at) && (*at..until).filter(|at| is_away(*at)).count() >= STAYS_AT_LEAST
    });
    let Some(sure) = sure else {
        let farthest = all[frames.at(0.0)..]
            .iter()
            .map(|f| f.point.distance(rest.place))
            .fold(0.0, f64::max);
        let detail = Detail::NeverMoves {
            seconds: all.last().map_or(0.0, |frame| frame.t),
            farthest,
            frames: STAYS,
        };
        return Err(Rejection::new(RejectReason::NoMotion, detail));
    };
    let first = follow_back(all, sure, rest.noise);
    let t = all[first].t;
    let late = t - frames.fall;
    if late > LATEST_MOTION {
        let is_related = late <= UNRELATED;
        let detail = Detail::MovesLate {
            by: late,
            is_related,
        };
        let reason = if is_related {
            RejectReason::ClockSkew
        } else {
            RejectReason::NoMotion
        };
        return Err(Rejection::new(reason, detail));
    }
    if t < -2.0 * frames.period {
        let detail = Detail::MovesEarly { by: -t };
        return Err(Rejection::new(RejectReason::ClockSkew, detail));
    }
    Ok(first)
}

/// The first frame in motion, from one that surely is.
fn follow_back(all: &[Frame], sure: usize, noise: f64) -> usize {
    /// Frames whose median is the level before a frame.
    const LEVEL_FRAMES: usize = 8;
    /// Frames of a line through the first motion.
    const LINE_FRAMES: usize = 4;
    /// Part of a frame by which the line must meet the level before a frame for that frame to count.
    const MARGIN: f64 = 0.25;
    let ahead = all[(sure + 2).min(all.len() - 1)].point;
    let level_before = |at: usize| {
        let points: Vec<Point> = all[at.saturating_sub(LEVEL_FRAMES)..at]
            .iter()
            .map(|frame| frame.point)
            .collect();
        median_point(&points)
    };
    let along = |at: usize, level: Point| {
        let direction = ahead - level;
        (all[at].point - level).dot(direction) / direction.norm()
    };
    let mut first = sure;
    while first > 1 {
        let level = level_before(first - 1);
        let (previous, this) = (along(first - 1, level), along(first, level));
        if !(previous > LEFT_NOISE * noise && previous < this) {
            break;
        }
        first -= 1;
    }
    if first > 1 {
        let level = level_before(first - 1);
        let line: Vec<(f64, f64)> = (first..all.len().min(first + LINE_FRAMES))
            .map(|at| (all[at].t, along(at, level)))
            .collect();
        let period = all[first].t - all[first - 1].t;
        if line.len() == LINE_FRAMES
            && meets_zero(&line).is_some_and(|t| t < all[first - 1].t - MARGIN * period)
            && along(first - 1, level) > 0.0
        {
            first -= 1;
        }
    }
    first
}

/// Where a rising line fitted through (t, distance) meets zero.
fn meets_zero(points: &[(f64, f64)]) -> Option<f64> {
    let count = points.len() as f64;
    let (t, d) = points.iter().fold((0.0, 0.0), |sum, point| {
        (sum.0 + point.0 / count, sum.1 + point.1 / count)
    });
    let (tt, td) = points.iter().fold((0.0, 0.0), |sum, p| {
        (sum.0 + (p.0 - t).powi(2), sum.1 + (p.0 - t) * (p.1 - d))
    });
    let speed = td / tt;
    (speed > 0.0).then(|| t - d / speed)
}
