//! From rest to rest: when an object begins to move, and where it first comes to rest.
//!
//! - *Rest before*: the frames of the half second before the command rises lie within noise of one place.
//! - *First motion*: the first frame that is surely away (8 noise deviations or 5 mm, and stays so) is followed back to the
//!   first frame that left the level of the frames right before it; where a line through the frames that follow meets
//!   that level yet earlier, a frame that lies between counts too. The track's zero is the stamp of that frame: the
//!   impact lies between the frame before and it.
//! - *First rest*: the first quarter second whose frames lie within noise of one place and do not drift; what comes later,
//!   such as a hand that puts the object back, is never looked at.

use logs::Sample;
use values::{Point, RejectReason, Rig, Track};

use crate::command::{Episode, Rejection};
use crate::robust::{mean_near_median, median, median_point, spread};
use crate::segment::seconds;

/// Rest before is looked for in this time before the command rises, in s.
const REST_BEFORE: f64 = 0.5;
/// The initial position is taken from this time before first motion, in s.
const INITIAL_TIME: f64 = 0.3;
/// An object that lies still this long has come to rest, in s.
const REST_AFTER: f64 = 0.25;
/// The stop is taken from at most this time of rest, in s, without its first part, in which the last creep may be.
const STOP_TIME: f64 = 0.6;
const CREEP_TIME: f64 = 0.08;
/// Rest needs as many frames, whatever the camera's rate.
const REST_FRAMES: usize = 4;
/// Frames of rest at the end of a track.
const FRAMES_AFTER: usize = 5;
/// Trackers shift by as much when a marker is lost: less is no motion, in m.
const WANDER: f64 = 0.002;
/// Surely away from rest, in m and in noise deviations.
const SURELY_AWAY: f64 = 0.005;
const SURELY_AWAY_NOISE: f64 = 8.0;
/// Surely at the place, in noise deviations.
const AT_PLACE_NOISE: f64 = 4.0;
/// Away from the frames right before, in noise deviations.
const LEFT_NOISE: f64 = 5.0;
/// The object moves at the latest this long after the command fell back, in s: a camera's and a recorder's delay.
const LATEST_MOTION: f64 = 0.5;
/// What moves an object later than this after the command fell back is no strike, whatever the clocks, in s.
const UNRELATED: f64 = 3.0;
/// An object struck leaves at this part of the robot's slowest strike at least; a hand's carrying is slower.
const STRUCK: f64 = 0.5;
/// Most that may be missing between two frames, in periods: around impact and rest, and within the slide.
const GAP_AT_ENDS: f64 = 3.5;
const GAP_WITHIN: f64 = 6.5;
/// A slide only slows down: a frame this many times faster than its beginning is another's doing.
const FASTER: f64 = 2.0;
/// Most of a slide's frames that may be missing.
const MOST_MISSING: f64 = 0.3;
/// A camera this many times slower than the rig file says is another one.
const SLOWER: f64 = 3.0;

/// What the centroids around one command tell.
#[derive(Debug)]
pub(crate) struct Slide {
    /// Stamp of the first frame in motion, in ns.
    pub(crate) first_motion: i64,
    pub(crate) initial: Point,
    pub(crate) stop: Point,
    pub(crate) track: Track,
    /// Frames that jumped away and back, left out of the track.
    pub(crate) outliers: usize,
}

struct Frame {
    stamp: i64,
    /// Seconds since the command rose.
    t: f64,
    point: Point,
}

/// The frames around one command.
pub(crate) struct Frames<'a> {
    rig: &'a Rig,
    /// Finite ones that do not jump away and back.
    frames: Vec<Frame>,
    /// Times of frames that jump away and back.
    outliers: Vec<f64>,
    /// Times of frames without a finite centroid.
    not_finite: Vec<f64>,
    /// Times and places of frames off the table.
    off_table: Vec<(f64, Point)>,
    /// When the command fell back, in s since it rose.
    fall: f64,
    /// Seconds from frame to frame.
    period: f64,
}

impl<'a> Frames<'a> {
    pub(crate) fn new(seen: &[Sample], episode: &Episode, rig: &'a Rig) -> Result<Self, Rejection> {
        let start = episode.start();
        let all: Vec<Frame> = seen
            .iter()
            .map(|sample| Frame {
                stamp: sample.stamp,
                t: seconds(sample.stamp.saturating_sub(start)),
                point: Point::new(sample.x, sample.y),
            })
            .collect();
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
        let period = median(near.windows(2).map(|pair| pair[1].t - pair[0].t));
        if period > SLOWER * nominal {
            let detail = format!(
                "frames come every {:.1} ms, at {} Hz they should every {:.1} ms",
                1e3 * period,
                rig.camera.rate,
                1e3 * nominal
            );
            return Err(Rejection::new(RejectReason::FramesMissing, detail));
        }
        units(&near, rig)?;
        let not_finite = all
            .iter()
            .filter(|frame| !frame.point.is_finite())
            .map(|frame| frame.t)
            .collect();
        let finite: Vec<Frame> = all
            .into_iter()
            .filter(|frame| frame.point.is_finite())
            .collect();
        let off_table = finite
            .iter()
            .filter(|f| !rig.table.contains(f.point))
            .map(|f| (f.t, f.point))
            .collect();
        let jumps = jumps(&finite, rig.camera.noise);
        let outliers = finite
            .iter()
            .zip(&jumps)
            .filter(|(_, jumps)| **jumps)
            .map(|(frame, _)| frame.t)
            .collect();
        let frames = finite
            .into_iter()
            .zip(jumps)
            .filter(|(_, jumps)| !jumps)
            .map(|(frame, _)| frame)
            .collect();
        Ok(Self {
            rig,
            frames,
            outliers,
            not_finite,
            off_table,
            fall: seconds(episode.end().saturating_sub(start)),
            period: if period.is_nan() { nominal } else { period },
        })
    }

    fn points(&self, from: usize, to: usize) -> Vec<Point> {
        self.frames[from..to]
            .iter()
            .map(|frame| frame.point)
            .collect()
    }

    /// Index of the first frame at or after this time.
    fn at(&self, t: f64) -> usize {
        self.frames.partition_point(|frame| frame.t < t)
    }

    /// A frame without a finite centroid, or one off the table, in this time.
    fn unusable(&self, from: f64, to: f64) -> Option<Rejection> {
        let within = |t: f64| (from..=to).contains(&t);
        if let Some(t) = self.not_finite.iter().find(|t| within(**t)) {
            let detail = format!("a centroid is not finite {t:.3} s after the command rises");
            return Some(Rejection::new(RejectReason::NotFinite, detail));
        }
        let (t, point) = self.off_table.iter().find(|(t, _)| within(*t))?;
        let table = &self.rig.table;
        let detail = format!(
            "a centroid is at ({:.4}, {:.4}) m, {t:.3} s after the command rises; the table is [{}, {}] × [{}, {}] m",
            point.x, point.y, table.x.low, table.x.high, table.y.low, table.y.high
        );
        Some(Rejection::new(RejectReason::OffTable, detail))
    }
}

/// Centroids far off a table on which they would lie in another unit.
fn units(near: &[&Frame], rig: &Rig) -> Result<(), Rejection> {
    let points: Vec<Point> = near
        .iter()
        .map(|frame| frame.point)
        .filter(|point| point.is_finite())
        .collect();
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

/// Finds the slide that one command caused.
pub(crate) fn find(frames: &Frames<'_>) -> Result<Slide, Rejection> {
    let found = find_among(frames);
    let (from, to) = match &found {
        Ok(found) => (-REST_BEFORE, found.end),
        Err(_) => (-REST_BEFORE, f64::INFINITY),
    };
    match (found, frames.unusable(from, to)) {
        (Ok(found), None) => Ok(found.slide),
        (Err(rejection), None) => Err(rejection),
        // A cause that explains the other.
        (_, Some(unusable)) => Err(unusable),
    }
}

struct Found {
    slide: Slide,
    /// Time of the last frame that was used.
    end: f64,
}

fn find_among(frames: &Frames<'_>) -> Result<Found, Rejection> {
    let rest = rest_before(frames)?;
    let first = first_motion(frames, &rest)?;
    let initial = initial(frames, &rest, first)?;
    let (arrival, stop, last) = rest_after(frames, &rest, first)?;
    missing(frames, first, arrival, last)?;
    carried(frames, first, arrival, rest.noise)?;
    let end = (arrival + FRAMES_AFTER).min(last);
    let start = &frames.frames[first];
    let used = &frames.frames[first..end];
    let track = Track {
        t: used
            .iter()
            .map(|frame| seconds(frame.stamp.saturating_sub(start.stamp)))
            .collect(),
        x: used.iter().map(|frame| frame.point.x).collect(),
        y: used.iter().map(|frame| frame.point.y).collect(),
    };
    let end = frames.frames[last - 1].t;
    let outliers = frames
        .outliers
        .iter()
        .filter(|t| (start.t..end).contains(*t))
        .count();
    let slide = Slide {
        first_motion: start.stamp,
        initial,
        stop,
        track,
        outliers,
    };
    Ok(Found { slide, end })
}

/// Where the object lies before, and how noisy that is.
struct Rest {
    place: Point,
    /// Standard deviation of a coordinate, in m.
    noise: f64,
}

/// Whether these frames lie still: within noise of one place, without drift from their first to their last third.
fn lies_still(points: &[Point], noise: f64) -> bool {
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

fn rest_before(frames: &Frames<'_>) -> Result<Rest, Rejection> {
    let known = frames.rig.camera.noise;
    let to = frames.at(0.0);
    let points = frames.points(frames.at(-REST_BEFORE), to);
    if points.len() < REST_FRAMES {
        let detail = format!(
            "{} centroids come in the {REST_BEFORE} s before the command",
            points.len()
        );
        return Err(Rejection::new(RejectReason::NoRestBefore, detail));
    }
    // An object that was only just put down rests for a shorter time.
    for time in [REST_BEFORE, REST_AFTER] {
        let points = frames.points(frames.at(-time), to);
        let noise = spread(&points).clamp(known, 3.0 * known);
        if points.len() >= REST_FRAMES && lies_still(&points, noise) {
            return Ok(Rest {
                place: median_point(&points),
                noise,
            });
        }
    }
    if let Some(t) = struck_before(frames, known) {
        let detail = format!("the object is struck {:.3} s before the command rises", -t);
        return Err(Rejection::new(RejectReason::ClockSkew, detail));
    }
    let travel = points[0].distance(points[points.len() - 1]);
    let detail = format!(
        "the object moves {:.1} mm in the {REST_BEFORE} s before the command",
        1e3 * travel
    );
    Err(Rejection::new(RejectReason::NoRestBefore, detail))
}

/// When the object last left a rest before the command's rise, if it did so as fast as one that is struck.
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

fn first_motion(frames: &Frames<'_>, rest: &Rest) -> Result<usize, Rejection> {
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
        let detail = format!(
            "in {:.2} s after the command rises the object is never farther than {:.1} mm from its rest for {STAYS} frames",
            all.last().map_or(0.0, |frame| frame.t),
            1e3 * farthest
        );
        return Err(Rejection::new(RejectReason::NoMotion, detail));
    };
    let first = follow_back(all, sure, rest.noise);
    let t = all[first].t;
    let late = t - frames.fall;
    if late > LATEST_MOTION {
        let related = late <= UNRELATED;
        let cause = if related {
            "clocks disagree, or something else moved it"
        } else {
            "something else moved it"
        };
        let detail =
            format!("the object first moves {late:.3} s after the command fell back: {cause}");
        let reason = if related {
            RejectReason::ClockSkew
        } else {
            RejectReason::NoMotion
        };
        return Err(Rejection::new(reason, detail));
    }
    if t < -2.0 * frames.period {
        let detail = format!("the object moves {:.3} s before the command rises", -t);
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
    /// The line must meet the level this part of a frame before a frame for it to count.
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
#[expect(clippy::cast_precision_loss, reason = "a handful of points")]
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

fn initial(frames: &Frames<'_>, rest: &Rest, first: usize) -> Result<Point, Rejection> {
    let from = frames.at(frames.frames[first].t - INITIAL_TIME);
    let points = frames.points(from, first);
    let gap = frames.frames[first].t
        - first
            .checked_sub(1)
            .map_or(f64::NEG_INFINITY, |at| frames.frames[at].t);
    if points.len() < REST_FRAMES || gap > GAP_AT_ENDS * frames.period {
        let detail = format!(
            "{:.1} ms without a frame before first motion, and {} frames in the {INITIAL_TIME} s before; frames come every {:.1} ms",
            1e3 * gap,
            points.len(),
            1e3 * frames.period
        );
        return Err(Rejection::new(RejectReason::FramesMissing, detail));
    }
    Ok(mean_near_median(&points, AT_PLACE_NOISE * rest.noise))
}

/// The first frame at rest, where that is, and the end of the frames that show it.
fn rest_after(
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
    let detail = format!(
        "{:.2} s of frames after first motion, up to {:.1} mm away, and nowhere {REST_AFTER} s of rest",
        last.t - moving.t,
        1e3 * last.point.distance(rest.place)
    );
    Err(Rejection::new(RejectReason::NoRestAfter, detail))
}

/// Whether nearly all frames lie at one place and their halves do not drift.
#[expect(clippy::cast_precision_loss, reason = "a few dozen points")]
fn is_rest(points: &[Point], reach: f64, noise: f64) -> bool {
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

fn missing(
    frames: &Frames<'_>,
    first: usize,
    arrival: usize,
    last: usize,
) -> Result<(), Rejection> {
    let all = &frames.frames;
    let period = frames.period;
    let gap = |at: usize| all[at].t - all[at - 1].t;
    let widest = |from: usize, to: usize| (from..to).map(gap).fold(0.0, f64::max);
    let around_rest = widest(
        (arrival - 1).max(first + 1),
        (arrival + FRAMES_AFTER).min(last),
    );
    let within = widest(first + 1, arrival.max(first + 2));
    for (what, gap, most) in [
        ("around the rest", around_rest, GAP_AT_ENDS),
        ("within the slide", within, GAP_WITHIN),
    ] {
        if gap > most * period {
            let detail = format!(
                "{:.1} ms without a frame {what}; frames come every {:.1} ms",
                1e3 * gap,
                1e3 * period
            );
            return Err(Rejection::new(RejectReason::FramesMissing, detail));
        }
    }
    #[expect(clippy::cast_precision_loss, reason = "a few thousand frames")]
    let there = (arrival - first) as f64;
    let due = (all[arrival].t - all[first].t) / period;
    if there < (1.0 - MOST_MISSING) * due - 1.0 {
        let detail = format!("{there} of {due:.0} frames of the slide are there");
        return Err(Rejection::new(RejectReason::FramesMissing, detail));
    }
    Ok(())
}

/// A step far faster than the slide began: the object was taken away, or another was put there.
fn carried(frames: &Frames<'_>, first: usize, arrival: usize, noise: f64) -> Result<(), Rejection> {
    /// Frames in which a slide is fastest: contact may last for some.
    const BEGINNING: usize = 10;
    let all = &frames.frames;
    let step = |at: usize| all[at].point.distance(all[at - 1].point);
    let speed = |at: usize| step(at) / (all[at].t - all[at - 1].t);
    let fastest = (first + 1..arrival.min(first + BEGINNING) + 1)
        .map(speed)
        .fold(speed(first), f64::max);
    for at in first + BEGINNING..arrival {
        let most = FASTER * fastest * (all[at].t - all[at - 1].t) + SURELY_AWAY_NOISE * noise;
        if step(at) > most {
            let detail = format!(
                "{:.3} s after first motion, not yet at rest, the object jumps {:.1} mm from one frame to the next",
                all[at].t - all[first].t,
                1e3 * step(at)
            );
            return Err(Rejection::new(RejectReason::NoRestAfter, detail));
        }
    }
    Ok(())
}
