//! Whether something stopped an object at its rest: a hand, or an edge that gives nothing back.
//!
//! Friction lets an object creep to its stop; what is caught stands from one frame to the next. Two ways to the same stop are laid through
//! the last frames: at once, and as hard as no table brakes. Where the first fits better by far, it was no table.

use values::{Point, Shape, Track};

use super::frames::Frame;
use super::held::{BRAKES, no_table};
use super::tolerances::FRAMES_AFTER;
use crate::robust::median_point;

/// Time, in s, before the rest and after it over which frames are used.
const BEFORE: f64 = 0.3;
const AFTER: f64 = 0.1;
/// The moment at which an even braking ends is looked for from so long before the last frame in motion, in s, in steps of this.
const SOONER: f64 = 0.05;
const STEP: f64 = 0.002;
/// Longest time, in s, of a braking harder than any table's.
const LONGEST: f64 = 0.12;
/// Least number of frames that still move.
const FEWEST: usize = 2;
/// Least improvement of the sum of squares, in squares of the noise (4 standard errors).
const BETTER: f64 = 16.0;
/// Standard errors by which the table may brake harder than it seems.
const UNSURE: f64 = 2.0;
/// Speed, in m/s, below which what is caught is as good as at rest.
const SLOWEST: f64 = 0.1;
/// The same, where it is not known how a table brakes at the most.
const CLEARLY: f64 = 0.15;

/// The frames up to a rest, as distances before the stop.
struct Approach {
    /// Times in s and distances in m.
    frames: Vec<(f64, f64)>,
    /// Times in s between which the object stopped.
    first: f64,
    until: f64,
    /// Seconds from frame to frame.
    period: f64,
}

/// A way to the stop that ends at once.
struct AtOnce {
    /// Moment at which it ends, in s.
    moment: f64,
    /// Sum of squared distances that it leaves, in m².
    sum: f64,
    /// Speed at that moment, in m/s.
    speed: f64,
    /// Deceleration until then, in m/s², with its standard error for a noise of one.
    braking: f64,
    braking_error: f64,
}

/// The index of the first frame that may have been held, where the object stopped more suddenly than any table brakes that braked it so until
/// then. `rest` is the index of the first frame at rest, at `stop`; `noise` that of a coordinate.
pub(super) fn stopped(
    frames: &[Frame],
    rest: usize,
    stop: Point,
    noise: f64,
    shape: Shape,
) -> Option<usize> {
    let approach = Approach::of(frames, rest, stop)?;
    let at_once = approach.best()?;
    let square = (noise * noise).max(approach.square(&at_once));
    let usual = at_once.braking + UNSURE * square.sqrt() * at_once.braking_error;
    // Of few frames it is hardly known; then no table at all brakes so.
    let hardest = no_table(usual, shape).min(BRAKES);
    (at_once.speed > SLOWEST && approach.hard(hardest) - at_once.sum > BETTER * square)
        .then(|| approach.held(frames, &at_once))
}

/// Of a track that ends at rest, at `stop`, where the object goes from a clear speed to rest as if at once: the number of frames before it may have been held,
/// and the least braking, in m/s², by which a table can have done it.
pub(crate) fn stood(track: &Track, stop: Point) -> Option<(usize, f64)> {
    /// The braking that is looked for, in m/s², and how often the interval in which it lies is halved.
    const FROM: f64 = 1.0;
    const TO: f64 = 40.0;
    const HALVED: u32 = 6;
    /// What brakes it harder yet, and fits better by so much, in squares of the noise, takes its time.
    const HARDER: [f64; 4] = [1.0, 1.25, 1.6, 2.0];
    const SOFTER: f64 = 4.0;
    let frame = |at: usize| Frame {
        stamp: 0,
        t: track.t[at],
        point: track.point(at),
    };
    let frames: Vec<Frame> = (0..track.len()).map(frame).collect();
    let approach = Approach::of(&frames, frames.len().checked_sub(FRAMES_AFTER)?, stop)?;
    let at_once = approach.best()?;
    if at_once.speed < CLEARLY {
        return None;
    }
    let most = at_once.sum + BETTER * approach.square(&at_once);
    let (mut low, mut high) = (FROM, TO);
    for _ in 0..HALVED {
        let middle = (low * high).sqrt();
        match approach.hard(middle) > most {
            true => low = middle,
            false => high = middle,
        }
    }
    let softer = at_once.sum - SOFTER * approach.square(&at_once);
    let is_soft = HARDER
        .iter()
        .any(|times| approach.hard(times * high) < softer);
    (!is_soft).then(|| (approach.held(&frames, &at_once), low))
}

/// Moments from one to another, in s.
fn moments(from: f64, to: f64) -> impl Iterator<Item = f64> {
    let steps = ((to - from) / STEP) as u32;
    (0..=steps).map(move |i| from + STEP * f64::from(i))
}

/// Where an object that had as good as stopped goes on: the frame at which it was slowest, and its place then. A table never does that, and an
/// arm that goes on behind an object that slides leaves it no time to stop.
pub(super) fn carried_on(frames: &[Frame]) -> Option<(usize, Point)> {
    /// Time, in s, over which speeds are taken, and over as many frames.
    const TIME: f64 = 0.06;
    const FRAMES: usize = 3;
    /// Share of its fastest speed below which an object has as good as stopped; share above which it goes on; and the number of frames that show
    /// that.
    const STOPS: f64 = 0.1;
    const GOES_ON: f64 = 0.25;
    const IN_A_ROW: usize = 4;
    let to = |at: usize| {
        let later = frames.partition_point(|frame| frame.t < frames[at].t + TIME);
        later.max(at + FRAMES)
    };
    let speeds: Vec<f64> = (0..frames.len())
        .take_while(|at| to(*at) < frames.len())
        .map(|at| {
            let (one, other) = (&frames[at], &frames[to(at)]);
            one.point.distance(other.point) / (other.t - one.t)
        })
        .collect();
    let mut fastest: f64 = 0.0;
    let mut slowest: Option<(usize, f64)> = None;
    let mut faster = 0;
    for (at, speed) in speeds.iter().enumerate() {
        fastest = match slowest {
            None => fastest.max(*speed),
            Some(_) => fastest,
        };
        if *speed < STOPS * fastest && slowest.is_none_or(|(_, least)| *speed < least) {
            slowest = Some((at, *speed));
        }
        faster = match slowest {
            Some(_) if *speed > GOES_ON * fastest => faster + 1,
            _ => 0,
        };
        if let (Some((slowest, _)), true) = (slowest, faster == IN_A_ROW) {
            let near: Vec<Point> = frames[slowest..=to(slowest)]
                .iter()
                .map(|f| f.point)
                .collect();
            let stands = median_point(&near);
            let reach = near.iter().map(|p| p.distance(stands)).fold(0.0, f64::max);
            let first = frames
                .iter()
                .position(|f| f.point.distance(stands) <= reach)?;
            return Some((first, stands));
        }
    }
    None
}

impl Approach {
    /// The frames around the first one at rest, which has this index.
    fn of(frames: &[Frame], rest: usize, stop: Point) -> Option<Self> {
        let arrival = frames.get(rest)?.t;
        let last = frames.get(rest.checked_sub(1)?)?.t;
        let from = frames.partition_point(|frame| frame.t < arrival - BEFORE);
        let to = frames.partition_point(|frame| frame.t <= arrival + AFTER);
        let ahead = stop - frames.get(from..rest)?.first()?.point;
        let ahead = ahead * (1.0 / ahead.norm().max(1e-12));
        Some(Self {
            frames: frames[from..to]
                .iter()
                .map(|frame| (frame.t, (stop - frame.point).dot(ahead)))
                .collect(),
            first: last - SOONER,
            until: arrival + AFTER,
            period: (frames[to - 1].t - frames[from].t) / (to - from).max(2) as f64,
        })
    }

    /// The way that ends at once and fits best.
    fn best(&self) -> Option<AtOnce> {
        moments(self.first, self.until)
            .filter_map(|moment| self.at_once(moment))
            .min_by(|one, other| one.sum.total_cmp(&other.sum))
    }

    /// The square of what a distance differs by from that way, in m².
    fn square(&self, at_once: &AtOnce) -> f64 {
        at_once.sum / self.frames.len().saturating_sub(3).max(1) as f64
    }

    /// Least sum of squares of a way on which a table brakes so hard at last, in m/s².
    fn hard(&self, hardest: f64) -> f64 {
        moments(self.first, self.until)
            .flat_map(|moment| moments(0.0, LONGEST).map(move |time| (moment, time)))
            .filter_map(|(moment, time)| self.braked(moment, time, hardest))
            .fold(f64::INFINITY, f64::min)
    }

    /// The index of the first frame that may have been held.
    fn held(&self, frames: &[Frame], at_once: &AtOnce) -> usize {
        frames.partition_point(|frame| frame.t < at_once.moment - 0.5 * self.period)
    }

    /// Fits an even braking up to a moment, at which the object stands at the stop at once.
    fn at_once(&self, moment: f64) -> Option<AtOnce> {
        // Distances v·s + a·s²/2, s the time before the moment.
        let (mut xx, mut xz, mut zz, mut xd, mut zd, mut count) = (0.0, 0.0, 0.0, 0.0, 0.0, 0);
        for (t, d) in &self.frames {
            let s = moment - t;
            if s > 0.0 {
                let (x, z) = (s, 0.5 * s * s);
                (xx, xz, zz) = (xx + x * x, xz + x * z, zz + z * z);
                (xd, zd) = (xd + x * d, zd + z * d);
                count += 1;
            }
        }
        let determinant = xx * zz - xz * xz;
        if count < FEWEST || determinant <= 0.0 {
            return None;
        }
        // A table brakes, and does not push.
        let free = (xx * zd - xz * xd) / determinant;
        let braking = free.max(0.0);
        let speed = (xd - braking * xz) / xx;
        let sum = self.sum(|t| {
            let s = (moment - t).max(0.0);
            speed * s + 0.5 * braking * s * s
        });
        Some(AtOnce {
            moment,
            sum,
            speed,
            braking,
            braking_error: (xx / determinant).sqrt(),
        })
    }

    /// Sum of squares of an even braking until a moment, and from then on, for this time, one as hard as `hardest` (m/s²) to the stop.
    fn braked(&self, moment: f64, time: f64, hardest: f64) -> Option<f64> {
        let (speed, way) = (hardest * time, 0.5 * hardest * time * time);
        let (mut zz, mut zd, mut count) = (0.0, 0.0, 0);
        for (t, d) in &self.frames {
            let s = moment - t;
            if s > 0.0 {
                let z = 0.5 * s * s;
                zz += z * z;
                zd += z * (d - way - speed * s);
                count += 1;
            }
        }
        if count == 0 {
            return None;
        }
        let braking = (zd / zz).clamp(0.0, hardest);
        Some(self.sum(|t| {
            let s = moment - t;
            if s > 0.0 {
                way + speed * s + 0.5 * braking * s * s
            } else {
                0.5 * hardest * (time + s).max(0.0).powi(2)
            }
        }))
    }

    fn sum(&self, distance: impl Fn(f64) -> f64) -> f64 {
        let square = |(t, d): &(f64, f64)| (d - distance(*t)).powi(2);
        self.frames.iter().map(square).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOISE: f64 = 0.0006;

    /// Where it may have been held, of an object that is at this place at a time, at rest from `rest` on; at 60 Hz, with the camera's noise.
    fn held_at(place: impl Fn(f64) -> f64, rest: f64, phase: f64) -> Option<f64> {
        let wobble = |i: u32, k: f64| NOISE * 1.4 * (f64::from(i * i) * k + phase).sin();
        let frames: Vec<Frame> = (0..60)
            .map(|i| {
                let t = (f64::from(i) + phase) / 60.0;
                Frame {
                    stamp: 0,
                    t,
                    point: Point::new(place(t) + wobble(i, 1.1), wobble(i, 2.3)),
                }
            })
            .collect();
        let at = frames.partition_point(|frame| frame.t < rest);
        let stop = Point::new(place(1.0), 0.0);
        stopped(&frames, at, stop, NOISE, Shape::Cylinder).map(|at| frames[at].t)
    }

    #[test]
    fn what_a_hand_catches_is_no_stop_and_what_a_table_stops_is_one() {
        for phase in (0..10).map(|i| f64::from(i) / 10.0) {
            for speed in [0.8, 1.2] {
                // Caught at 0.4 s, and after four frames.
                for moment in [0.4, 0.07] {
                    let caught = |t: f64| {
                        let left = (moment - t).max(0.0);
                        -speed * left - 1.25 * left * left
                    };
                    let at = held_at(caught, moment, phase).expect("caught");
                    assert!((at - moment).abs() < 0.02, "{speed} {phase}: {at}");
                }
            }
            // To rest by itself; over a patch that brakes three times as hard.
            for hard in [2.5, 7.5] {
                let rest = |t: f64| {
                    let left = (0.4 - t).max(0.0);
                    let (late, early) = (left.min(0.05), (left - 0.05).max(0.0));
                    -0.5 * hard * late * late - hard * late * early - 1.25 * early * early
                };
                for seen in [0.36, 0.38, 0.4] {
                    assert_eq!(held_at(rest, seen, phase), None, "{hard} {phase}");
                }
            }
        }
    }
}
