//! Frames in which the tracker did not see the object: without a number, at zero, at a place off the table to which no object gets, at that of another object,
//! or at the last one again while the object moved on.
//!
//! Trackers write a place of their own where they see nothing, such as (-1, -1): off the table, again and again the same to the last digit, and farther from
//! where the object was, and is next, than anything gets from one frame to the next. Others write the last place again.

use std::collections::{HashSet, VecDeque};

use logs::Sample;
use values::{Point, Rig};

use crate::order::since;

/// Greatest speed of anything on a table, in m/s; and the distance, in m, below which noise may be what moves it.
const FASTEST: f64 = 15.0;
const FAR: f64 = 0.03;
/// Number of frames in a row of which it is asked: more of them are an object that lies somewhere.
const MOST_HELD: usize = 100_000;

/// Whether the second place lies farther from the first than any object gets in the time between.
pub(crate) fn is_out_of_reach(one: (i64, Point), other: (i64, Point)) -> bool {
    one.1.distance(other.1) > FAR.max(FASTEST * since(one.0, other.0))
}

/// Whether a distance is farther than what the robot strikes gets from one frame to another so many seconds later.
pub(crate) fn is_jump(distance: f64, time: f64, rig: &Rig) -> bool {
    /// An object leaves at no more than twice the tip's speed; the rest is what a speed from two frames is unsure by. A rig file may state less
    /// than its arm does.
    const TIMES: f64 = 3.0;
    const LEAST: f64 = 3.0;
    let fastest = (TIMES * rig.robot.speed.high).clamp(LEAST, FASTEST);
    // Stamps that are late bunch.
    distance > FAR.max(fastest * time.max(1.0 / rig.camera.rate))
}

/// A stream of centroids without those in which the tracker saw nothing.
#[derive(Default)]
pub(crate) struct Lost {
    nowhere: Nowhere,
    elsewhere: Elsewhere,
    stale: Stale,
}

impl Lost {
    /// Takes the next frame; hands on those in which the object was seen, in order, and gives the number of those in which it was not.
    pub(crate) fn take(&mut self, sample: Sample, rig: &Rig, mut see: impl FnMut(Sample)) -> usize {
        let (mut elsewhere, mut stale) = (0, 0);
        let lost = self.nowhere.take(sample, rig, |sample| {
            elsewhere += self.elsewhere.take(sample, rig, |sample| {
                stale += self.stale.take(sample, rig.camera.noise, &mut see);
            });
        });
        lost + elsewhere + stale
    }

    /// Hands on what no later frame tells of, at the end of the data: an object that was put where it is.
    pub(crate) fn release(&mut self, rig: &Rig, mut see: impl FnMut(Sample)) -> usize {
        let held = std::mem::take(&mut self.elsewhere.held).into_iter();
        held.map(|sample| self.stale.take(sample, rig.camera.noise, &mut see))
            .sum()
    }

    /// How often the tracker took another object for a while, since this was asked last.
    pub(crate) fn take_bursts(&mut self) -> u64 {
        std::mem::take(&mut self.elsewhere.bursts)
    }

    /// Number of the frames at the end of the data that no later one told of: off the table, where no object gets, or at the last place again.
    pub(crate) fn finish(self) -> usize {
        self.nowhere.held.len() + self.stale.held.len()
    }
}

/// Places that no object gets to.
#[derive(Default)]
struct Nowhere {
    /// Frames off the table, at one place, of which the next one at another tells.
    held: Vec<Sample>,
    /// Where the tracker last wrote a place off the table that no object gets to.
    nowhere: Option<Point>,
    /// The last frame in which the object was seen.
    last: Option<Sample>,
}

impl Nowhere {
    fn take(&mut self, sample: Sample, rig: &Rig, mut see: impl FnMut(Sample)) -> usize {
        let is_zero = sample.x == 0.0 && sample.y == 0.0;
        if is_zero || !place(&sample).is_finite() {
            return 1;
        }
        let is_on = |sample: &Sample| rig.table.contains(place(sample));
        let jumps =
            |one: &Sample| is_out_of_reach((one.stamp, place(one)), (sample.stamp, place(&sample)));
        let mut lost = 0;
        if let Some(held) = self.held.last() {
            if place(held) == place(&sample) && self.held.len() < MOST_HELD {
                self.held.push(sample);
                return 0;
            }
            if is_on(&sample) && jumps(held) {
                let at = Some(place(held));
                // One frame alone is a stray one.
                if self.held.len() > 1 || self.nowhere == at {
                    lost = self.held.len();
                    self.held.clear();
                }
                self.nowhere = at;
            }
            self.last = self.held.last().copied().or(self.last);
            self.held.drain(..).for_each(&mut see);
        }
        if !is_on(&sample) && self.last.is_none_or(|last| is_on(&last) && jumps(&last)) {
            self.held.push(sample);
        } else {
            self.last = Some(sample);
            see(sample);
        }
        lost
    }
}

/// The place of another object, at rest, that is tracked for a while.
#[derive(Default)]
struct Elsewhere {
    /// The last frame in which the object was seen, and its speed then, in m/s, where the frame before saw it, too.
    last: Option<Sample>,
    speed: Option<f64>,
    /// Frames since, at one place to which it does not get.
    held: Vec<Sample>,
    bursts: u64,
    /// The place of the last ones that the tracker wrote again and again to the last digit, as it writes where it sees nothing.
    nowhere: Option<Point>,
}

impl Elsewhere {
    fn take(&mut self, sample: Sample, rig: &Rig, mut see: impl FnMut(Sample)) -> usize {
        /// Longest time, in s, for which another object is tracked: what stays longer was put there.
        const LONGEST: f64 = 0.5;
        /// Distance from one place of what lies still, in m and in deviations of the noise.
        const STILL: f64 = 0.002;
        const STILL_NOISE: f64 = 6.0;
        let jumps = |one: &Sample| {
            let far = place(one).distance(place(&sample));
            is_jump(far, since(one.stamp, sample.stamp), rig)
        };
        let mut lost = 0;
        if let (Some(first), Some(last)) = (self.held.first(), self.held.last()) {
            let is_known = self.nowhere == Some(place(first)) && self.held.len() < MOST_HELD;
            let is_long = since(first.stamp, sample.stamp) > LONGEST && !is_known;
            let gone = place(first).distance(place(&sample));
            if !is_long && gone < STILL + STILL_NOISE * rig.camera.noise {
                self.held.push(sample);
                return 0;
            }
            // A table only slows it down.
            let speed = self.speed.unwrap_or_default();
            let goes_on = |from: &Sample| {
                let most = FAR + speed * since(from.stamp, sample.stamp);
                place(from).distance(place(&sample)) < most
            };
            let is_back = !is_long && jumps(last) && self.last.as_ref().is_some_and(goes_on);
            match is_back {
                // One frame alone is a stray one.
                true if self.held.len() == 1 && !is_known => self.held.drain(..).for_each(&mut see),
                true => {
                    let is_one = self.held.iter().all(|held| place(held) == place(first));
                    self.bursts += u64::from(!is_known);
                    self.nowhere = is_one.then(|| place(first)).or(self.nowhere);
                    lost = self.held.drain(..).count();
                }
                false => {
                    self.speed = (self.held.len() > 1).then_some(0.0);
                    self.last = self.held.last().copied();
                    self.held.drain(..).for_each(&mut see);
                }
            }
        }
        let jumped = lost == 0 && self.last.as_ref().is_some_and(jumps);
        if jumped && self.speed.is_some() {
            self.held.push(sample);
            return 0;
        }
        let speed = |last: Sample| {
            let time = since(last.stamp, sample.stamp).max(1.0 / rig.camera.rate);
            place(&last).distance(place(&sample)) / time
        };
        self.speed = self.last.filter(|_| !jumped).map(speed);
        self.last = Some(sample);
        see(sample);
        lost
    }
}

/// Places that are written again while the object moves on.
#[derive(Default)]
struct Stale {
    /// The last place, and how far the one before it lay, in m.
    last: Option<Sample>,
    before: f64,
    /// Frames that repeat it to the last digit, of which the next one that is new tells.
    held: Vec<Sample>,
    /// Places of the last while.
    places: VecDeque<Point>,
}

impl Stale {
    /// Takes the next frame. A tracker whose places lie in steps repeats them at rest; by more than a few steps a frame, the object moves.
    fn take(&mut self, sample: Sample, noise: f64, mut see: impl FnMut(Sample)) -> usize {
        /// Least distance from frame to frame of an object that moves, in deviations of the noise, and in steps.
        const MOVES: f64 = 3.0;
        /// How many times as far as before it has gone in the meantime where it repeats once: a camera may be half as fast as its stamps.
        const CATCHES_UP: f64 = 1.5;
        /// Time, in s, for which a moving object that is caught lies still.
        const RESTS: f64 = 0.25;
        /// Number of places that tell in which steps they lie.
        const PLACES: usize = 240;
        let Some(last) = self.last else {
            self.last = Some(sample);
            see(sample);
            return 0;
        };
        let gone = place(&last).distance(place(&sample));
        let may_move = self.before > MOVES * noise;
        if gone == 0.0 && may_move && since(last.stamp, sample.stamp) < RESTS {
            self.held.push(sample);
            return 0;
        }
        let is_stale = || {
            let moves = MOVES * noise.max(step(&self.places));
            let is_on = self.held.len() > 1 || gone > CATCHES_UP * self.before;
            is_on && self.before > moves && gone > moves
        };
        let lost = match !self.held.is_empty() && is_stale() {
            true => self.held.drain(..).count(),
            false => 0,
        };
        self.held.drain(..).for_each(&mut see);
        // A jump is no motion.
        let at = |frame: &Sample| (frame.stamp, place(frame));
        self.before = match is_out_of_reach(at(&last), at(&sample)) {
            true => 0.0,
            false => gone,
        };
        self.last = Some(sample);
        if self.places.len() == PLACES {
            self.places.pop_front();
        }
        self.places.push_back(place(&sample));
        see(sample);
        lost
    }
}

/// The step in which places lie, in m: where both coordinates are multiples of one length, or where places come again that were left, as
/// pixels do behind any lens. 0 where neither is seen: what is measured on end never comes again. Infinite where too few changes tell.
fn step(places: &VecDeque<Point>) -> f64 {
    /// Number of changes of a coordinate that show a grid, and of places that come again that show a tracker which knows no others.
    const CHANGES: usize = 8;
    const AGAIN: usize = 3;
    let pairs = || places.iter().copied().zip(places.iter().skip(1).copied());
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
    if pairs().filter(|(one, other)| one != other).count() < CHANGES {
        return f64::INFINITY;
    }
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

fn place(sample: &Sample) -> Point {
    Point::new(sample.x, sample.y)
}

#[cfg(test)]
mod tests {
    use values::Shape;

    use super::*;

    /// Number of the frames, at 60 Hz, that are lost and that are seen.
    fn counts(places: &[[f64; 2]]) -> (usize, usize) {
        let (rig, mut lost) = (Rig::demo(Shape::Cylinder), Lost::default());
        let (mut unseen, mut seen) = (0, Vec::new());
        for (i, [x, y]) in (0_i64..).zip(places) {
            let sample = Sample::at(i * 16_666_667, Point::new(*x, *y));
            unseen += lost.take(sample, &rig, |sample| seen.push(sample.stamp));
        }
        unseen += lost.release(&rig, |sample| seen.push(sample.stamp));
        assert!(seen.is_sorted());
        (unseen + lost.finish(), seen.len())
    }

    #[test]
    fn a_place_off_the_table_that_no_object_gets_to_is_a_lost_frame() {
        let at = |x: f64| [x, 0.1];
        let nowhere = [-1.0, -1.0];
        assert_eq!(
            counts(&[at(0.3), nowhere, nowhere, at(0.31), at(0.32)]),
            (2, 3)
        );
        // One alone is a stray frame, until it comes again; so where no number comes in between.
        let mixed = [
            nowhere,
            at(0.3),
            [9999.0; 2],
            [f64::NAN; 2],
            [9999.0; 2],
            at(0.3),
        ];
        assert_eq!(counts(&mixed), (3, 3));
        let again = [at(0.3), nowhere, at(0.3), nowhere, at(0.3)];
        assert_eq!(counts(&again), (1, 4));
        assert_eq!(counts(&[at(0.3), [0.0; 2], at(0.3)]), (1, 2));
        // Nor is one lost without a word where the log ends with it.
        assert_eq!(counts(&[at(0.3), nowhere, nowhere]), (2, 1));
    }

    #[test]
    fn an_object_that_lies_off_the_table_is_seen_there() {
        // It slides over the edge, and is put back.
        let falls = (0..40).map(|i| [0.9 + 0.005 * f64::from(i), 0.1]);
        let falls: Vec<[f64; 2]> = falls
            .chain([[1.095, 0.1]; 30])
            .chain([[0.3, 0.1]; 5])
            .collect();
        assert_eq!(counts(&falls), (0, 75));
        // A hand puts it beyond the stated bounds, from where it is struck; the tracker's places are coarse.
        let struck = (0..20).map(|i| [0.05 + 0.01 * f64::from(i), 0.1]);
        let struck: Vec<[f64; 2]> = [[0.6, 0.1]; 5]
            .into_iter()
            .chain([[0.05, 0.1]; 30])
            .chain(struck)
            .collect();
        assert_eq!(counts(&struck), (0, 55));
        // All places are in mm, and coarse.
        let in_mm: Vec<[f64; 2]> = (0..30)
            .map(|i| [400.0 + 12.0 * f64::from(i / 3), 100.0])
            .collect();
        assert_eq!(counts(&in_mm).0, 0);
    }

    #[test]
    fn another_object_that_is_tracked_for_a_while_is_a_lost_frame() {
        let slide = |i: u32| [0.3 + 0.008 * f64::from(i), 0.1];
        let other = |i: u32| [0.6 + 0.0005 * f64::from(i % 3), 0.4];
        let seen = |others: std::ops::Range<u32>| -> Vec<[f64; 2]> {
            let of = |i| {
                if others.contains(&i) {
                    other(i)
                } else {
                    slide(i)
                }
            };
            (0..60).map(of).collect()
        };
        assert_eq!(counts(&seen(20..28)), (8, 52));
        assert_eq!(counts(&seen(20..40)), (20, 40));
        // One frame alone is a stray one; it never comes back; it is carried away for a second.
        assert_eq!(counts(&seen(20..21)), (0, 60));
        assert_eq!(counts(&seen(20..59)), (0, 60));
        // A place that comes again to the last digit is written where nothing is seen, for however long.
        let nothing = |i: u32| match i {
            20..26 | 35..100 => [0.6, 0.4],
            _ => slide(i.min(60)),
        };
        assert_eq!(counts(&(0..120).map(nothing).collect::<Vec<_>>()), (71, 49));
        let carried = [[0.3, 0.1]; 10].into_iter().chain([[0.6, 0.4]; 60]);
        let carried: Vec<[f64; 2]> = carried.chain([[0.3, 0.1]; 10]).collect();
        assert_eq!(counts(&carried), (0, 80));
    }

    /// Which of these places, at 60 Hz, are left out as stale.
    fn stale(places: &[Point], noise: f64) -> Vec<i64> {
        let (mut stale, mut seen) = (Stale::default(), Vec::new());
        let frames: Vec<Sample> = (0_i64..).zip(places).map(|(i, p)| frame(i, *p)).collect();
        let mut lost = 0;
        for sample in &frames {
            lost += stale.take(*sample, noise, |sample| seen.push(sample.stamp));
        }
        seen.extend(stale.held.iter().map(|sample| sample.stamp));
        assert!(seen.is_sorted() && seen.len() + lost == frames.len());
        let missing = (0_i64..)
            .zip(&frames)
            .filter(|(_, f)| !seen.contains(&f.stamp));
        missing.map(|(i, _)| i).collect()
    }

    fn frame(i: i64, place: Point) -> Sample {
        Sample::at(i * 16_666_667, place)
    }

    /// At rest for a second, then a slide under 3 m/s² to rest, as a tracker sees it that rounds to steps of this many mm, on a sensor turned by
    /// 0.3 rad or not.
    fn coarse(step: f64, turn: f64, seed: u32) -> Vec<Point> {
        let rounded = |x: f64| (x / (1e-3 * step)).round() * 1e-3 * step;
        let wobble = |i: u32, k: f64| {
            let number = (f64::from(12 * i + 7 * seed) * k).sin() * 43758.5453;
            0.4e-3 * step * 3.4 * (number - number.floor() - 0.5)
        };
        let places = (0..140).map(|i| {
            let t = (f64::from(i) / 60.0 - 1.0).clamp(0.0, 0.3);
            let seen = Point::new(0.4021, 0.0313) + Point::polar(0.9 * t - 1.5 * t * t, 0.4);
            let seen = seen + Point::new(wobble(i, 12.9898), wobble(i, 78.233));
            Point::new(rounded(seen.x), rounded(seen.y)).rotated(turn)
        });
        places.collect()
    }

    #[test]
    fn a_coarse_tracker_that_repeats_a_place_is_not_stale() {
        for seed in 0..200 {
            for (step, turn) in [(1.0, 0.0), (1.0, 0.3), (2.7, 0.0), (2.7, 0.3)] {
                let mut places = coarse(step, turn, seed);
                // As a camera of this step is stated, or better.
                for noise in [0.4e-3 * step, 0.2e-3 * step] {
                    assert_eq!(
                        stale(&places, noise),
                        [0; 0],
                        "{seed}, {step} mm, {turn} rad"
                    );
                }
                // It has nothing new for two frames as the object moves by many steps.
                for at in [64, 65] {
                    places[at] = places[63];
                }
                let found = stale(&places, 0.4e-3 * step);
                assert_eq!(found, [64, 65], "{seed}, {step} mm");
            }
        }
    }

    #[test]
    fn what_repeats_while_the_object_moves_is_stale_and_what_rests_is_not() {
        let found = |places: &[f64]| {
            // After a while in which it is seen to measure on end.
            let before = (0..20).map(|i| 0.3 + 0.0001 * f64::from(i).sin());
            let all = before.chain(places.iter().copied());
            let places: Vec<Point> = all.map(|x| Point::new(x, 0.0)).collect();
            stale(&places, 0.0003)
                .iter()
                .map(|i| i - 20)
                .collect::<Vec<i64>>()
        };
        let slides = [
            0.3, 0.3, 0.3, 0.31, 0.32, 0.32, 0.32, 0.35, 0.355, 0.356, 0.356,
        ];
        assert_eq!(found(&slides), [5, 6]);
        // Struck back meanwhile, it is no farther than a frame before.
        let struck = [0.3, 0.31, 0.32, 0.32, 0.32, 0.32, 0.315, 0.30, 0.285];
        assert_eq!(found(&struck), [3, 4, 5]);
        // Caught, and struck again.
        let rests: Vec<f64> = [0.3, 0.31]
            .into_iter()
            .chain([0.32; 20])
            .chain([0.33, 0.34])
            .collect();
        assert_eq!(found(&rests), [0; 0]);
        // A camera of half the rate of its stamps.
        let slow: Vec<f64> = (0..20).map(|i| 0.3 + 0.01 * f64::from(i / 2)).collect();
        assert_eq!(found(&slow), [0; 0]);
    }
}
