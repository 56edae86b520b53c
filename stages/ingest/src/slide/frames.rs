//! The frames around one command: where and when, without those that jump away and back.

use logs::Sample;
use values::{Point, RejectReason, Rig};

use super::tolerances::REST_BEFORE;
use crate::order::since;
use crate::rejection::{Detail, Rejection};
use crate::robust::{median, median_point};

/// Greatest time between frames, in s, that show a slide.
const SLOWEST: f64 = 1.0 / 15.0;

/// Greatest number of frames around one command: 20 s of a camera at 2.5 kHz.
const MOST_FRAMES: usize = 50_000;
/// Ratio to the usual interval from which one has frames missing.
const INTERVAL_WITH_GAP: f64 = 1.75;

pub(crate) struct Frame {
    pub(super) stamp: i64,
    /// Seconds since the command rose.
    pub(super) t: f64,
    pub(super) point: Point,
}

impl Frame {
    /// The frame of a centroid, its time in s since the stamp `start`.
    pub(crate) fn of(sample: &Sample, start: i64) -> Self {
        Self {
            stamp: sample.stamp,
            t: since(start, sample.stamp),
            point: Point::new(sample.x, sample.y),
        }
    }
}

/// The frames around one command.
pub(crate) struct Frames<'a> {
    pub(super) rig: &'a Rig,
    /// Frames that do not jump away and back.
    pub(super) frames: Vec<Frame>,
    /// Times, in s, of frames that jump.
    pub(super) outliers: Vec<f64>,
    /// Times and places of frames off the table.
    off_table: Vec<(f64, Point)>,
    /// When the command fell back, in s since it rose.
    pub(super) fall: f64,
    /// Seconds from frame to frame.
    pub(crate) period: f64,
}
impl<'a> Frames<'a> {
    /// Frames seen around a command that rose and fell at these stamps.
    pub(crate) fn new(
        seen: &[Sample],
        (start, end): (i64, i64),
        rig: &'a Rig,
    ) -> Result<Self, Rejection> {
        if seen.len() > MOST_FRAMES {
            let centroids = seen.len();
            let detail = Detail::TooManyCentroids { centroids };
            return Err(Rejection::new(RejectReason::UnitsImplausible, detail));
        }
        let all: Vec<Frame> = seen.iter().map(|sample| Frame::of(sample, start)).collect();
        let nominal = 1.0 / rig.camera.rate;
        let near: Vec<&Frame> = all
            .iter()
            .filter(|frame| (-REST_BEFORE..1.0).contains(&frame.t))
            .collect();
        if near.is_empty() {
            let detail = Detail::NoCentroidNear;
            return Err(Rejection::new(RejectReason::NoRestBefore, detail));
        }
        let period = mean_interval(&near);
        if period > SLOWEST {
            let rate = rig.camera.rate;
            let detail = Detail::FramesTooSeldom { period, rate };
            return Err(Rejection::new(RejectReason::FramesMissing, detail));
        }
        units(&near, rig)?;
        let off_table = all
            .iter()
            .filter(|f| !rig.table.contains(f.point))
            .map(|f| (f.t, f.point))
            .collect();
        let jumps = outliers(&all, rig.camera.noise);
        let outliers = all
            .iter()
            .zip(&jumps)
            .filter(|(_, jumps)| **jumps)
            .map(|(frame, _)| frame.t)
            .collect();
        let frames = all
            .into_iter()
            .zip(jumps)
            .filter(|(_, jumps)| !jumps)
            .map(|(frame, _)| frame)
            .collect();
        Ok(Self {
            rig,
            frames,
            outliers,
            off_table,
            fall: since(start, end),
            period: if period.is_nan() { nominal } else { period },
        })
    }

    pub(super) fn points(&self, from: usize, to: usize) -> Vec<Point> {
        self.frames[from..to]
            .iter()
            .map(|frame| frame.point)
            .collect()
    }

    /// Index of the first frame at or after this time.
    pub(super) fn at(&self, t: f64) -> usize {
        self.frames.partition_point(|frame| frame.t < t)
    }

    /// The first of the frames from `first` on, before `until`, from which on the object is off the table, or seen no more; none where it
    /// stays, or comes back.
    pub(super) fn left_table(&self, first: usize, until: usize) -> Option<usize> {
        /// Number of frames in a row off the table that are no tracker's jump.
        const STAYS: usize = 3;
        let is_off = |frame: &Frame| !self.rig.table.contains(frame.point);
        let left = (first..until).find(|at| is_off(&self.frames[*at]))?;
        let after = &self.frames[left..until];
        let is_gone = after.len() >= STAYS || until == self.frames.len();
        (is_gone && after.iter().take(STAYS).all(is_off)).then_some(left)
    }

    /// A frame off the table, in this time.
    pub(super) fn unusable(&self, from: f64, to: f64) -> Option<Rejection> {
        let within = |t: f64| (from..=to).contains(&t);
        let (t, point) = self.off_table.iter().find(|(t, _)| within(*t))?;
        let table = &self.rig.table;
        let detail = Detail::OffTable {
            x: point.x,
            y: point.y,
            after: *t,
            table: [table.x.low, table.x.high, table.y.low, table.y.high],
        };
        Some(Rejection::new(RejectReason::OffTable, detail))
    }
}

/// Intervals that are so short beside most are of stamps that bunch; one in so many shows that stamps do. Longer intervals than this, beside most,
/// are then gaps.
const BUNCHED: f64 = 0.5;
const MANY_BUNCHED: usize = 10;
const LATE_INTERVAL: f64 = 3.5;

/// Seconds from frame to frame, frames that are missing left out of account: the mean of the intervals, for a camera whose clock
/// ticks coarser than its frames come has two intervals, and its period is neither. Where stamps are so late that they bunch, long intervals make
/// up for short ones.
fn mean_interval(frames: &[&Frame]) -> f64 {
    let intervals = || frames.windows(2).map(|pair| pair[1].t - pair[0].t);
    let middle = median(intervals());
    let bunched = intervals().filter(|t| *t < BUNCHED * middle).count();
    let most = match MANY_BUNCHED * bunched > frames.len() {
        true => LATE_INTERVAL * middle,
        false => INTERVAL_WITH_GAP * middle,
    };
    let (count, sum) = intervals()
        .filter(|interval| *interval <= most)
        .fold((0_usize, 0.0), |(count, sum), interval| {
            (count + 1, sum + interval)
        });
    sum / count as f64
}

/// Centroids far off a table, as far from the frame's origin as which they would lie in another unit; in which frame is asked later.
fn units(near: &[&Frame], rig: &Rig) -> Result<(), Rejection> {
    let points: Vec<Point> = near.iter().map(|frame| frame.point).collect();
    let middle = median_point(&points);
    let (x, y) = (rig.table.x, rig.table.y);
    let nearest = Point::new(0f64.clamp(x.low, x.high), 0f64.clamp(y.low, y.high)).norm();
    let farthest = x
        .low
        .abs()
        .max(x.high.abs())
        .hypot(y.low.abs().max(y.high.abs()));
    let unit = [(false, 1e-3), (true, 1e-2)]
        .into_iter()
        .find(|(_, metres)| (nearest..=farthest).contains(&(middle.norm() * metres)));
    match unit {
        // As far off as another unit takes it, not just over the edge.
        Some((are_centimetres, _)) if middle.norm() * 0.2 > farthest => {
            let detail = Detail::OtherUnit {
                x: middle.x,
                y: middle.y,
                are_centimetres,
            };
            Err(Rejection::new(RejectReason::UnitsImplausible, detail))
        }
        _ => Ok(()),
    }
}

/// Which frames jump away from both their neighbours, farther than noise, jitter or an impact could take them.
pub(crate) fn outliers(frames: &[Frame], noise: f64) -> Vec<bool> {
    const JUMP_NOISE: f64 = 10.0;
    let mut jumps = vec![false; frames.len()];
    for (at, three) in frames.windows(3).enumerate() {
        let [before, frame, after] = three else {
            continue;
        };
        let middle = (before.point + after.point) * 0.5;
        let span = before.point.distance(after.point);
        // Anything between its neighbours is no farther from their middle than half the span.
        jumps[at + 1] = frame.point.distance(middle) > JUMP_NOISE * noise + span;
    }
    jumps
}
