//! The frames around one command: where and when, without those that jump away and back.

use std::collections::HashSet;

use logs::Sample;
use values::{Point, RejectReason, Rig};

use super::tolerances::REST_BEFORE;
use crate::order::since;
use crate::rejection::Rejection;
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
    /// Frames that neither jump away and back nor are stale.
    pub(super) frames: Vec<Frame>,
    /// Times, in s, of frames that jump or are stale.
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
            let detail = format!(
                "{} centroids come around one command, more than any camera gives: are stamps in another unit?",
                seen.len()
            );
            return Err(Rejection::new(RejectReason::UnitsImplausible, detail));
        }
        let all: Vec<Frame> = seen.iter().map(|sample| Frame::of(sample, start)).collect();
        let nominal = 1.0 / rig.camera.rate;
        let near: Vec<&Frame> = all
            .iter()
            .filter(|frame| (-REST_BEFORE..1.0).contains(&frame.t))
            .collect();
        if near.is_empty() {
            let detail =
                "no centroid comes from half a second before the command to a second after";
            return Err(Rejection::new(RejectReason::NoRestBefore, detail));
        }
        let period = mean_interval(&near);
        if period > SLOWEST {
            let detail = format!(
                "frames come every {:.1} ms, too seldom for a slide; the rig file says camera.rate = {}",
                1e3 * period,
                rig.camera.rate
            );
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
        let detail = format!(
            "a centroid is at ({:.4}, {:.4}) m, {t:.3} s after the command rises; the table is [{}, {}] × [{}, {}] m",
            point.x, point.y, table.x.low, table.x.high, table.y.low, table.y.high
        );
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

/// Centroids far off a table on which they would lie in another unit.
fn units(near: &[&Frame], rig: &Rig) -> Result<(), Rejection> {
    let points: Vec<Point> = near.iter().map(|frame| frame.point).collect();
    let middle = median_point(&points);
    let unit = [("mm", 1e-3), ("cm", 1e-2)]
        .into_iter()
        .find(|(_, metres)| {
            // As far off as another unit takes it, not just over the edge.
            !rig.table.contains(middle * 0.2) && rig.table.contains(middle * *metres)
        });
    match unit {
        Some((unit, _)) if !rig.table.contains(middle) => {
            let detail = format!(
                "centroids lie around ({:.1}, {:.1}): are they in {unit}, not in m?",
                middle.x, middle.y
            );
            Err(Rejection::new(RejectReason::UnitsImplausible, detail))
        }
        _ => Ok(()),
    }
}

/// Which frames jump away and back, or repeat the one before while the object moves.
pub(crate) fn outliers(frames: &[Frame], noise: f64) -> Vec<bool> {
    let mut marked = jumps(frames, noise);
    stale(frames, noise, &mut marked);
    marked
}

/// Which frames jump away from both their neighbours, farther than noise, jitter or an impact could take them.
fn jumps(frames: &[Frame], noise: f64) -> Vec<bool> {
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

/// Marks frames that repeat the one before to the last digit while the object moves, as the next one that is new shows: the tracker
/// had nothing new. A tracker whose places lie in steps repeats them at rest; by more than a few steps a frame, the object moves.
fn stale(frames: &[Frame], noise: f64, marked: &mut [bool]) {
    const MOVES: f64 = 3.0;
    const CATCHES_UP: f64 = 1.5;
    let moves = MOVES * noise.max(step(frames));
    let mut first = 1;
    while first + 1 < frames.len() {
        let point = frames[first].point;
        let next = (first + 1..frames.len()).find(|at| frames[*at].point != point);
        let Some(next) = next else { break };
        let before = point.distance(frames[first - 1].point);
        let after = point.distance(frames[next].point);
        if next > first + 1 && before > moves && after > CATCHES_UP * before {
            marked[first + 1..next].fill(true);
        }
        first = next;
    }
}

/// The step in which places lie, in m: where both coordinates are multiples of one length, or where places come again that were left, as
/// pixels do behind any lens. 0 where neither is seen: what is measured on end never comes again.
fn step(frames: &[Frame]) -> f64 {
    /// Number of changes of a coordinate that show a grid, and of places that come again that show a tracker which knows no others.
    const CHANGES: usize = 8;
    const AGAIN: usize = 3;
    let pairs = || frames.windows(2).map(|pair| (pair[0].point, pair[1].point));
    let grid = |of: fn(Point) -> f64| -> Option<f64> {
        /// Greatest distance from a whole number of steps, in steps.
        const OFF: f64 = 0.01;
        let changes: Vec<f64> = pairs()
            .map(|(one, other)| (of(other) - of(one)).abs())
            .filter(|change| *change > 0.0)
            .collect();
        let least = changes.iter().copied().fold(f64::INFINITY, f64::min);
        let is_whole = |change: &f64| (change / least - (change / least).round()).abs() < OFF;
        (changes.len() >= CHANGES && changes.iter().all(is_whole)).then_some(least)
    };
    let grids = [grid(|point| point.x), grid(|point| point.y)];
    if let Some(step) = grids.into_iter().flatten().reduce(f64::max) {
        return step;
    }
    let (mut known, mut again, mut least) = (HashSet::new(), 0, f64::INFINITY);
    let changes = pairs().filter(|(one, other)| one != other);
    for (one, other) in changes {
        known.insert((one.x.to_bits(), one.y.to_bits()));
        again += usize::from(known.contains(&(other.x.to_bits(), other.y.to_bits())));
        least = least.min(one.distance(other));
    }
    if again >= AGAIN { least } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames at 60 Hz of places in m.
    fn frames_of(places: impl IntoIterator<Item = Point>) -> Vec<Frame> {
        let frames = (0_i64..).zip(places).map(|(i, point)| Frame {
            stamp: i * 16_666_667,
            t: i as f64 / 60.0,
            point,
        });
        frames.collect()
    }

    fn marked(frames: &[Frame], noise: f64) -> Vec<usize> {
        let mut marked = vec![false; frames.len()];
        stale(frames, noise, &mut marked);
        (0..frames.len()).filter(|i| marked[*i]).collect()
    }

    /// At rest for a second, then a slide under 3 m/s² to rest, as a tracker sees it that rounds to steps of this many mm, on a sensor turned by
    /// 0.3 rad or not.
    fn coarse(step: f64, turn: f64, seed: u32) -> Vec<Frame> {
        let rounded = |x: f64| (x / (1e-3 * step)).round() * 1e-3 * step;
        let wobble = |i: u32, k: f64| {
            let number = (f64::from(12 * i + 7 * seed) * k).sin() * 43758.5453;
            0.4e-3 * step * 3.4 * (number - number.floor() - 0.5)
        };
        frames_of((0..140).map(|i| {
            let t = (f64::from(i) / 60.0 - 1.0).clamp(0.0, 0.3);
            let seen = Point::new(0.4021, 0.0313) + Point::polar(0.9 * t - 1.5 * t * t, 0.4);
            let seen = seen + Point::new(wobble(i, 12.9898), wobble(i, 78.233));
            Point::new(rounded(seen.x), rounded(seen.y)).rotated(turn)
        }))
    }

    #[test]
    fn a_coarse_tracker_that_repeats_a_place_is_not_stale() {
        for seed in 0..200 {
            for (step, turn) in [(1.0, 0.0), (1.0, 0.3), (2.7, 0.0), (2.7, 0.3)] {
                let mut frames = coarse(step, turn, seed);
                // As a camera of this step is stated, or better.
                for noise in [0.4e-3 * step, 0.2e-3 * step] {
                    let stale = marked(&frames, noise);
                    assert_eq!(stale, [0; 0], "{seed}, {step} mm, {turn} rad");
                }
                // It has nothing new for two frames as the object moves by many steps.
                for at in [64, 65] {
                    frames[at].point = frames[63].point;
                }
                assert_eq!(
                    marked(&frames, 0.4e-3 * step),
                    [64, 65],
                    "{seed}, {step} mm"
                );
            }
        }
    }

    #[test]
    fn what_repeats_while_the_object_moves_is_stale_and_what_rests_is_not() {
        let places = [
            0.3, 0.3, 0.3, 0.31, 0.32, 0.32, 0.32, 0.35, 0.355, 0.356, 0.356,
        ];
        let frames = frames_of(places.map(|x| Point::new(x, 0.0)));
        assert_eq!(marked(&frames, 0.0003), [5, 6]);
    }
}
