//! The rests around a slide: before the command, right before first motion, and the first one after.

use values::{Point, RejectReason};

use super::frames::Frames;
use super::tolerances::{AT_PLACE_NOISE, GAP_AT_IMPACT, REST_BEFORE};
use crate::rejection::{Detail, Rejection};
use crate::robust::{mean_near_median, median_point, spread};

/// Time, in s, before first motion over which the initial position is taken.
const INITIAL_TIME: f64 = 0.3;
/// Time, in s, that an object must lie still to have come to rest.
const REST_AFTER: f64 = 0.25;
/// Longest time of rest from which the stop is taken, in s, without its first part, in which the last creep may be.
const STOP_TIME: f64 = 0.6;
const CREEP_TIME: f64 = 0.08;
/// Least number of frames of a rest, whatever the camera's rate.
const REST_FRAMES: usize = 4;
/// Distance, in m, by which trackers shift when a marker is lost: less is no motion.
const WANDER: f64 = 0.002;
/// Greatest ratio of a camera's noise to what its rig file says.
pub(crate) const NOISIER: f64 = 3.0;
/// Least speed of a struck object, as a part of the robot's slowest strike; a hand's carrying is slower.
const STRUCK: f64 = 0.5;

/// Place of the object before the strike, and its noise.
pub(super) struct Rest {
    pub(super) place: Point,
    /// Standard deviation of a coordinate, in m.
    pub(super) noise: f64,
}

/// Whether these frames lie still: within noise of one place, without drift from their first to their last third.
pub(crate) fn lies_still(points: &[Point], noise: f64) -> bool {
    let reach = AT_PLACE_NOISE * noise + WANDER;
    let middle = median_point(points);
    let third = points.len().div_ceil(3);
    let drift =
        median_point(&points[..third]).distance(median_point(&points[points.len() - third..]));
    let near = points
        .iter()
        .filter(|point| point.distance(middle) <= reach)
        .count();
    5 * near >= 4 * points.len() && drift <= WANDER + noise
}

pub(super) fn rest_before(frames: &Frames<'_>) -> Result<Rest, Rejection> {
    let known = frames.rig.camera.noise;
    let to = frames.at(0.0);
    let points = frames.points(frames.at(-REST_BEFORE), to);
    if points.len() < REST_FRAMES {
        let detail = Detail::FewCentroidsBefore {
            centroids: points.len(),
            seconds: REST_BEFORE,
        };
        return Err(Rejection::new(RejectReason::NoRestBefore, detail));
    }
    // An object that was only just put down rests for a shorter time.
    for time in [REST_BEFORE, REST_AFTER] {
        let points = frames.points(frames.at(-time), to);
        let noise = spread(&points).clamp(known, NOISIER * known);
        if points.len() >= REST_FRAMES && lies_still(&points, noise) {
            return Ok(Rest {
                place: median_point(&points),
                noise,
            });
        }
    }
    if let Some(t) = struck_before(frames, known) {
        let detail = Detail::StruckEarly { by: -t };
        return Err(Rejection::new(RejectReason::ClockSkew, detail));
    }
    let travel = points[0].distance(points[points.len() - 1]);
    let detail = Detail::MovesBefore {
        by: travel,
        seconds: REST_BEFORE,
    };
    Err(Rejection::new(RejectReason::NoRestBefore, detail))
}

/// Time, in s, at which the object last left a rest before the command's rise, if it did so as fast as one that is struck.
fn struck_before(frames: &Frames<'_>, noise: f64) -> Option<f64> {
    /// Frames over which its speed is taken.
    const SPEED_FRAMES: usize = 5;
    let all = &frames.frames;
    let left = (1..frames.at(0.0)).rev().find(|end| {
        let points = frames.points(frames.at(all[*end - 1].t - REST_AFTER), *end);
        points.len() >= REST_FRAMES && lies_still(&points, noise)
    })?;
    let later = all.get(left + SPEED_FRAMES)?;
    let speed = later.point.distance(all[left].point) / (later.t - all[left].t);
    (speed >= STRUCK * frames.rig.robot.speed.low).then_some(all[left].t)
}

/// Place of the object right before it moves, in m.
pub(super) fn initial(frames: &Frames<'_>, rest: &Rest, first: usize) -> Result<Point, Rejection> {
    let from = frames.at(frames.frames[first].t - INITIAL_TIME);
    let points = frames.points(from, first);
    let gap = frames.frames[first].t
        - first
            .checked_sub(1)
            .map_or(f64::NEG_INFINITY, |at| frames.frames[at].t);
    if points.len() < REST_FRAMES || gap > GAP_AT_IMPACT * frames.period {
        let detail = Detail::GapBeforeMotion {
            gap,
            frames: points.len(),
            seconds: INITIAL_TIME,
            period: frames.period,
        };
        return Err(Rejection::new(RejectReason::FramesMissing, detail));
    }
    Ok(mean_near_median(&points, AT_PLACE_NOISE * rest.noise))
}

/// The first frame at rest, where that is, and the end of the frames that show it.
pub(super) fn rest_after(
    frames: &Frames<'_>,
    rest: &Rest,
    first: usize,
) -> Result<(usize, Point, usize), Rejection> {
    let all = &frames.frames;
    let reach = AT_PLACE_NOISE * rest.noise;
    for from in first + 1..all.len() {
        let until = frames.at(all[from].t + REST_AFTER);
        if until == all.len()
            && all[all.len() - 1].t < all[from].t + REST_AFTER - 1.5 * frames.period
        {
            break;
        }
        let points = frames.points(from, until);
        if points.len() < REST_FRAMES || !is_rest(&points, reach, rest.noise) {
            continue;
        }
        // On, while it stays there.
        let middle = median_point(&points);
        let most = frames.at(all[from].t + STOP_TIME);
        let mut last = until;
        while last < most && all[last].point.distance(middle) <= reach {
            last += 1;
        }
        let settled = frames.at(all[from].t + CREEP_TIME).min(last - REST_FRAMES);
        let stop = mean_near_median(&frames.points(settled, last), reach);
        let near = |at: usize| all[at].point.distance(stop) <= 0.7 * reach;
        let arrival = (from..last)
            .find(|at| (*at..last.min(at + 3)).all(near))
            .unwrap_or(from);
        return Ok((arrival, stop, last));
    }
    let (last, moving) = (&all[all.len() - 1], &all[first]);
    let detail = Detail::NeverRests {
        seconds: last.t - moving.t,
        away: last.point.distance(rest.place),
        rest: REST_AFTER,
    };
    Err(Rejection::new(RejectReason::NoRestAfter, detail))
}

/// Whether nearly all frames lie at one place and their halves do not drift.
pub(crate) fn is_rest(points: &[Point], reach: f64, noise: f64) -> bool {
    /// Standard deviation of a median, in that of a mean.
    const MEDIAN_NOISE: f64 = 1.2533;
    let middle = median_point(points);
    let half = points.len() / 2;
    let near = points
        .iter()
        .filter(|point| point.distance(middle) <= reach)
        .count();
    let drift = median_point(&points[..half]).distance(median_point(&points[half..]));
    let drift_noise = 2.0_f64.sqrt() * MEDIAN_NOISE * noise / (half as f64).sqrt();
    7 * near >= 6 * points.len() && drift <= 3.0 * drift_noise
}
