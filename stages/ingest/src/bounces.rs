//! Where an object's velocity changes from one frame to the next, and how it flies in between.
//!
//! A line is laid through the places of a few frames before a moment, and another through those after it. Where both fit and the
//! velocities differ, something pushed. Near the tip's measured place that is an impact. Elsewhere, where the velocity's part along the
//! push is reversed, it is what friction, a slope or an edge never do: something stood in the way. One such place decides nothing
//! ([`crate::fences`]).

use std::collections::VecDeque;

use logs::Sample;
use serde::{Deserialize, Serialize};
use values::{Point, Rig};

use crate::arm::{State, TouchDelay, distances, touching, touchings};
use crate::order::since;
use crate::slide::{NOISIER, lies_still};

/// A moving object that was turned round.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bounce {
    /// Place of the object's centre as it was turned round, in m.
    pub place: Point,
    /// Velocity of the object before, in m/s.
    pub before: Point,
    /// Velocity of the object after, in m/s.
    pub after: Point,
}

/// What the tip pushed, by the places of both, however far both radii reach.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hit {
    /// From the tip's centre to the object's as it was pushed, in m.
    pub apart: f64,
    /// Speed of the tip towards the object, in m/s.
    pub speed: f64,
}

/// A moment at which an object's velocity changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Break {
    /// Stamp of the change, and of the first frame after it, in ns.
    pub(crate) stamp: i64,
    pub(crate) first: i64,
    /// Place of the change, and the velocities before and after it.
    pub(crate) bounce: Bounce,
    /// Standard deviation of a velocity's coordinate, in m/s.
    noise: f64,
    /// Whether the object lay still before: its velocity there is noise.
    pub(crate) is_from_rest: bool,
}

impl Break {
    /// Whether the object was turned round, as friction never does.
    fn is_turned(&self) -> bool {
        if self.is_from_rest {
            return false;
        }
        let Bounce { before, after, .. } = self.bounce;
        let impulse = after - before;
        let towards = impulse * (-1.0 / impulse.norm().max(1e-12));
        let least = SLOWEST.max(SLOPE_NOISE * self.noise);
        before.dot(towards) >= least && -after.dot(towards) >= least
    }
}

/// Frames from one break to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct Flight {
    /// What began it; none at the beginning of the data, and after a pause.
    pub(crate) begun: Option<Break>,
    pub(crate) frames: Vec<Sample>,
    /// Whether a break ends it.
    pub(crate) is_broken: bool,
}

/// Least number of frames of each line, and the time that they take, in s.
pub(crate) const FRAMES: usize = 4;
pub(crate) const TIME: f64 = 0.05;
/// Time between frames, in s, beyond which they show no motion.
const GAP: f64 = 0.07;
/// Greatest root mean square of the frames about a line, in m and in deviations of the camera's noise.
const STRAIGHT: f64 = 0.0008;
const STRAIGHT_NOISE: f64 = 2.0;
/// Least speed of an object towards and away from what turns it, in m/s and in deviations of a line's slope; and least change of velocity at a break.
const SLOWEST: f64 = 0.06;
const SLOPE_NOISE: f64 = 4.0;
const BREAK: f64 = 0.1;
pub(crate) const BREAK_NOISE: f64 = 7.0;
/// Greatest deceleration by a table, in m/s², and greatest push aside, as a part of it.
const BRAKES: f64 = 10.0;
const BRAKES_ASIDE: f64 = 0.3;
/// An object that is turned round was in motion before: it did not lie still in this time before, in s. Frames are kept for longer: a break
/// is known some time after it.
const REST: f64 = 0.25;
const RECENT: f64 = 1.0;
/// A tip that touches approaches along the line of centres at this speed at least, in m/s, and what it pushes goes away from it within the
/// angle of this cosine.
const APPROACH: f64 = 0.05;
const AWAY: f64 = 0.5;
/// Distance (m) beside both radii, and time (s), within which the tip has to do with a break.
const NEAR_TIP: f64 = 0.03;
const TIP_TIME: f64 = 0.05;
/// A tip that may have pushed it is nearer than this to it, in m, and goes towards it at this speed, in m/s, and it goes away from the tip
/// within the angle of this cosine.
const FARTHEST: f64 = 0.2;
const HITS: f64 = 0.3;
const STRAIGHT_AWAY: f64 = 0.95;
/// Greatest time, in s, between the tip's touch of what rested and the moment at which a camera that is late, or early, shows it.
const FARTHEST_IN_TIME: f64 = 0.5;
/// Time, in s, for which states are held.
const HELD: f64 = 30.0;
/// Number of frames from which a flight is handled in parts.
const MOST_FRAMES: usize = 5_000;
/// Greatest number of breaks that wait for the arm's states.
const MOST_WAITING: usize = 200;

/// Finds breaks in a stream of centroids.
pub(crate) struct Breaks {
    noise: f64,
    reach: f64,
    frames: VecDeque<(i64, Point)>,
    /// Centroids of the last while, in which a rest before a break would show.
    recent: VecDeque<Sample>,
    /// Stamp of the first frame after the last moment that was looked at.
    asked: i64,
    /// The best of the moments in a row that look like a break, and how badly its lines fit.
    best: Option<(f64, Break)>,
    flight: Flight,
    /// Flights that have ended, and wait until it is known where the tip was when they began.
    ended: VecDeque<Flight>,
    tips: VecDeque<State>,
    /// What the tip pushed of the flights that were taken.
    pub(crate) hits: Vec<Hit>,
    /// Distance of both centres at a touch; breaks of what rested, until states after them have come; and touches about such breaks.
    touching: f64,
    resting: VecDeque<Break>,
    pub(crate) touches: Vec<TouchDelay>,
}

impl Breaks {
    /// A finder for a camera whose coordinates scatter by `noise` (m).
    pub(crate) fn new(rig: &Rig, noise: f64) -> Self {
        Self {
            noise,
            reach: rig.object.solid.reach() + rig.striker.radius + NEAR_TIP,
            frames: VecDeque::new(),
            recent: VecDeque::new(),
            asked: i64::MIN,
            best: None,
            flight: Flight::default(),
            ended: VecDeque::new(),
            tips: VecDeque::new(),
            hits: Vec::new(),
            touching: touching(rig),
            resting: VecDeque::new(),
            touches: Vec::new(),
        }
    }

    /// Takes a centroid, in order of stamps.
    pub(crate) fn see(&mut self, sample: &Sample) {
        let last = self.frames.back().map(|(stamp, _)| *stamp);
        if last.is_some_and(|last| since(last, sample.stamp) > GAP) {
            self.pause();
        }
        self.frames
            .push_back((sample.stamp, Point::new(sample.x, sample.y)));
        self.flight.frames.push(*sample);
        self.recent.push_back(*sample);
        while since(self.recent[0].stamp, sample.stamp) > RECENT {
            self.recent.pop_front();
        }
        let Some(split) = self.split() else {
            return;
        };
        // Where frames come a little sooner or later than before, the newest leave out moments before this one.
        let parted = |at: usize| {
            let first = self.frames[at].0;
            let all: Vec<(f64, Point)> = self
                .frames
                .iter()
                .map(|(stamp, point)| (since(first, *stamp), *point))
                .collect();
            self.broken(first, &all[..at], &all[at..])
        };
        let from = self.frames.partition_point(|frame| frame.0 <= self.asked);
        let found: Vec<Option<(f64, Break)>> = (from..=split).map(parted).collect();
        self.asked = self.frames[split].0;
        for found in found {
            match found {
                Some((misfit, found)) => {
                    if self.best.is_none_or(|(least, _)| misfit < least) {
                        self.best = Some((misfit, found));
                    }
                }
                None => self.settle(),
            }
        }
        if self.flight.frames.len() > MOST_FRAMES {
            self.pause();
        }
        // As many before it as after it are looked at.
        let Some(last) = split.checked_sub(1).and_then(|i| self.frames.get(i)) else {
            return;
        };
        let last = last.0;
        let span = since(self.frames[split].0, sample.stamp).max(TIME);
        let mut before = split;
        while before > FRAMES && since(self.frames[1].0, last) > 1.5 * span {
            self.frames.pop_front();
            before -= 1;
        }
    }

    /// Where the frames are parted: the newest ones after it are enough for a line, and so are those before it.
    fn split(&self) -> Option<usize> {
        let (newest, _) = self.frames.back()?;
        let enough = |count: usize, span: f64| count >= FRAMES && span >= TIME;
        let split = (0..self.frames.len())
            .rev()
            .find(|at| enough(self.frames.len() - at, since(self.frames[*at].0, *newest)))?;
        let before = split.checked_sub(1)?;
        let (first, last) = (self.frames.front()?.0, self.frames[before].0);
        enough(split, since(first, last)).then_some(split)
    }

    /// Whether the velocity changes between these frames, and how badly the lines through them fit. `first` is the stamp of the first frame
    /// after.
    fn broken(
        &self,
        first: i64,
        before: &[(f64, Point)],
        after: &[(f64, Point)],
    ) -> Option<(f64, Break)> {
        if before.len() < FRAMES {
            return None;
        }
        // As long before as after.
        let span = after.last()?.0 - after[0].0;
        let from = before.partition_point(|(t, _)| *t < before[before.len() - 1].0 - 1.01 * span);
        let before = &before[from.min(before.len() - FRAMES)..];
        let (one, other) = (Straight::through(before)?, Straight::through(after)?);
        let most = STRAIGHT + STRAIGHT_NOISE * self.noise;
        if one.misfit > most || other.misfit > most {
            return None;
        }
        let impulse = other.velocity - one.velocity;
        // A camera may be noisier than its rig file says, in one log of many.
        let seen = (0.5 * (one.misfit.powi(2) + other.misfit.powi(2))).sqrt();
        let noise = self.noise.max(seen) * one.slope_error.max(other.slope_error);
        if impulse.norm() < BREAK.max(BREAK_NOISE * noise) || one.brakes_to(&other, noise) {
            return None;
        }
        // Where both lines come nearest to one another, between the frames.
        let apart = other.at(0.0) - one.at(0.0);
        let t = (-apart.dot(impulse) / impulse.dot(impulse))
            .clamp(before[before.len() - 1].0, after[0].0);
        let misfit = one.misfit + other.misfit + one.at(t).distance(other.at(t));
        let found = Break {
            stamp: first.saturating_add((1e9 * t) as i64),
            first,
            bounce: Bounce {
                place: (one.at(t) + other.at(t)) * 0.5,
                before: one.velocity,
                after: other.velocity,
            },
            noise,
            is_from_rest: false,
        };
        Some((misfit, found))
    }

    /// The best moment of those in a row is the break: what was before it has ended.
    fn settle(&mut self) {
        let Some((_, mut found)) = self.best.take() else {
            return;
        };
        found.is_from_rest = self.lay_still(found.first);
        let frames = &mut self.flight.frames;
        let parted = frames.partition_point(|frame| frame.stamp < found.first);
        let after = frames.split_off(parted);
        let next = Flight {
            begun: Some(found),
            frames: after,
            is_broken: false,
        };
        let mut ended = std::mem::replace(&mut self.flight, next);
        ended.is_broken = true;
        self.ended.push_back(ended);
    }

    /// Whether the object was at rest before this stamp, in as much noise as there may be.
    fn lay_still(&self, first: i64) -> bool {
        let before = self.recent.iter().filter(|frame| frame.stamp < first);
        let before = before.filter(|frame| since(frame.stamp, first) <= REST);
        let points: Vec<Point> = before.map(|frame| Point::new(frame.x, frame.y)).collect();
        points.len() >= FRAMES && lies_still(&points, NOISIER * self.noise)
    }

    /// Ends the flight in hand: nothing is seen for a while, or for ever.
    fn pause(&mut self) {
        self.settle();
        self.frames.clear();
        self.recent.clear();
        self.ended.push_back(std::mem::take(&mut self.flight));
    }

    /// Takes a state of the arm, in order of stamps.
    pub(crate) fn tip(&mut self, state: &State) {
        if !(state.position.is_finite() && state.velocity.is_finite()) {
            return;
        }
        self.tips.push_back(*state);
        while self
            .tips
            .front()
            .is_some_and(|first| since(first.stamp, state.stamp) > HELD)
        {
            self.tips.pop_front();
        }
    }

    /// Flights that have ended, with what the tip did where it began them; those of which that is not yet known only at the end of the data.
    pub(crate) fn take(&mut self, at_end: bool) -> Vec<(Flight, Option<Touch>)> {
        if at_end {
            self.pause();
        }
        let mut taken = Vec::new();
        while let Some(flight) = self.ended.front() {
            let is_known = flight.begun.is_none_or(|begun| {
                let last = self.tips.back();
                last.is_some_and(|last| since(begun.stamp, last.stamp) > TIP_TIME)
            });
            if !(at_end || is_known || self.ended.len() > MOST_WAITING) {
                break;
            }
            let touch = flight.begun.and_then(|begun| self.touch(&begun));
            let hit = flight.begun.and_then(|begun| self.hit(&begun));
            self.hits.extend(hit);
            self.resting
                .extend(flight.begun.filter(|begun| begun.is_from_rest));
            if let Some(flight) = self.ended.pop_front() {
                taken.push((flight, touch));
            }
        }
        self.touch_resting(at_end);
        taken
    }

    /// Touches about the breaks of what rested, as many as there are, each by how long before the break it was.
    fn touch_resting(&mut self, at_end: bool) {
        while let Some(begun) = self.resting.front() {
            let time = |tip: &State| since(begun.stamp, tip.stamp);
            let is_known = self
                .tips
                .back()
                .is_some_and(|last| time(last) > FARTHEST_IN_TIME);
            if !(is_known || at_end) {
                break;
            }
            let near = self
                .tips
                .iter()
                .filter(|tip| time(tip).abs() <= FARTHEST_IN_TIME);
            let distances = distances(near, begun.bounce.place, begun.stamp);
            let delays = touchings(&distances, self.touching).map(|touching| TouchDelay {
                seconds: -touching.touch,
                speed: touching.speed,
            });
            self.touches.extend(delays);
            self.resting.pop_front();
        }
    }

    /// The states about a moment.
    fn tips_about(&self, stamp: i64) -> Vec<State> {
        let from = self
            .tips
            .partition_point(|tip| since(tip.stamp, stamp) > TIP_TIME);
        let near = self.tips.range(from..);
        near.take_while(|tip| since(stamp, tip.stamp) <= TIP_TIME)
            .copied()
            .collect()
    }

    /// What the tip may have done at a break, by the direction of the push alone.
    fn hit(&self, begun: &Break) -> Option<Hit> {
        let near = self.tips_about(begun.stamp);
        if near.is_empty() {
            return None;
        }
        let tip = Touch::at(&near, begun.stamp);
        let Bounce {
            place,
            before,
            after,
        } = begun.bounce;
        let (centres, impulse) = (place - tip.position, after - before);
        let apart = centres.norm();
        let speed = tip.velocity.dot(centres) / apart.max(1e-12);
        let away = impulse.dot(centres) / (impulse.norm() * apart).max(1e-12);
        (apart < FARTHEST && speed > HITS && away > STRAIGHT_AWAY).then_some(Hit { apart, speed })
    }

    /// What the tip did at a break, where it is near.
    fn touch(&self, begun: &Break) -> Option<Touch> {
        let near = self.tips_about(begun.stamp);
        let is_near = |tip: &State| tip.position.distance(begun.bounce.place) < self.reach;
        if !near.iter().any(is_near) {
            return None;
        }
        let touch = Touch::at(&near, begun.stamp);
        let Bounce {
            place,
            before,
            after,
        } = begun.bounce;
        let centres = place - touch.position;
        let centres = centres * (1.0 / centres.norm().max(1e-12));
        let impulse = after - before;
        let approaches = (touch.velocity - before).dot(centres) >= APPROACH;
        (approaches && impulse.dot(centres) >= AWAY * impulse.norm()).then_some(touch)
    }
}

/// The stamp of the first frame after these frames' object was turned round, if it was; their coordinates scatter by this.
pub(crate) fn turned_round(
    rig: &Rig,
    noise: f64,
    frames: impl IntoIterator<Item = Sample>,
) -> Option<i64> {
    let mut breaks = Breaks::new(rig, noise);
    frames.into_iter().for_each(|frame| breaks.see(&frame));
    let begun = breaks
        .take(true)
        .into_iter()
        .filter_map(|(flight, _)| flight.begun);
    begun
        .filter(Break::is_turned)
        .map(|begun| begun.first)
        .next()
}

/// The tip at a break.
#[derive(Clone, Debug)]
pub(crate) struct Touch {
    /// States about it.
    pub(crate) states: Vec<State>,
    /// Where the tip was, in m, and its velocity right before, in m/s.
    pub(crate) position: Point,
    pub(crate) velocity: Point,
}

impl Touch {
    /// The tip at a moment by the states near it, of which there is one at least.
    fn at(near: &[State], stamp: i64) -> Self {
        let after = near
            .partition_point(|tip| tip.stamp <= stamp)
            .clamp(1, near.len());
        let last = near[after - 1];
        let velocity = last_velocity(&near[..after], stamp);
        Self {
            states: near.to_vec(),
            position: last.position + velocity * since(last.stamp, stamp),
            velocity,
        }
    }

    /// The tip where it was when the object was pushed, which a camera that lies this behind (s) told at this stamp.
    pub(crate) fn earlier(&self, stamp: i64, delay: f64) -> Self {
        let stamp = stamp.saturating_sub((1e9 * delay) as i64);
        Self::at(&self.states, stamp)
    }
}

/// A tip's velocity right before an impact is that of a line through its states in this time, in s, where there are as many; a tip gives way
/// in the impact, and later states say nothing.
const LINE_TIME: f64 = 0.03;
const LINE_STATES: usize = 5;

fn last_velocity(before: &[State], impact: i64) -> Point {
    let from = before.partition_point(|tip| since(tip.stamp, impact) > LINE_TIME);
    let line: Vec<(f64, Point)> = before[from..]
        .iter()
        .map(|tip| (since(impact, tip.stamp), tip.velocity))
        .collect();
    let last = before.last().map_or(Point::default(), |tip| tip.velocity);
    if line.len() < LINE_STATES {
        return last;
    }
    Straight::through(&line).map_or(last, |line| line.at(0.0))
}

impl Flight {
    /// What turned the object round as it began, where something did.
    pub(crate) fn bounce(&self) -> Option<Bounce> {
        self.begun
            .filter(Break::is_turned)
            .map(|begun| begun.bounce)
    }
}

/// A straight line through frames.
struct Straight {
    middle: f64,
    mean: Point,
    velocity: Point,
    /// Root mean square distance of a coordinate, in m.
    misfit: f64,
    /// Standard deviation of the slope for a noise of one.
    slope_error: f64,
}

impl Straight {
    fn through(frames: &[(f64, Point)]) -> Option<Self> {
        if frames.len() < FRAMES {
            return None;
        }
        let n = frames.len() as f64;
        let middle = frames.iter().map(|(t, _)| t).sum::<f64>() / n;
        let mean = frames.iter().fold(Point::default(), |sum, (_, p)| sum + *p) * (1.0 / n);
        let (mut slope, mut square) = (Point::default(), 0.0);
        for (t, point) in frames {
            slope = slope + (*point - mean) * (t - middle);
            square += (t - middle).powi(2);
        }
        let mut line = Self {
            middle,
            mean,
            velocity: slope * (1.0 / square),
            misfit: 0.0,
            slope_error: 1.0 / square.sqrt(),
        };
        let squares: f64 = frames
            .iter()
            .map(|(t, point)| point.distance(line.at(*t)).powi(2))
            .sum();
        line.misfit = (squares / (2.0 * n - 4.0)).sqrt();
        (line.velocity.is_finite() && line.misfit.is_finite()).then_some(line)
    }

    /// Whether friction alone may have brought it from this velocity to the other line's: along its way, no faster than any table brakes, and
    /// not turned round.
    fn brakes_to(&self, other: &Self, noise: f64) -> bool {
        let ahead = self.velocity * (1.0 / self.velocity.norm().max(1e-12));
        let impulse = other.velocity - self.velocity;
        let across = Point::new(-ahead.y, ahead.x);
        let (along, across) = (impulse.dot(ahead), impulse.dot(across).abs());
        along < 0.0
            && other.velocity.dot(ahead) > -SLOPE_NOISE * noise
            && across < (BRAKES_ASIDE * along.abs()).max(SLOPE_NOISE * noise)
            && along.abs() <= BRAKES * (other.middle - self.middle)
    }

    fn at(&self, t: f64) -> Point {
        self.mean + self.velocity * (t - self.middle)
    }
}

#[cfg(test)]
mod tests {
    use values::Shape;

    use super::*;

    /// Bounces of an object whose place is this function of time, at 60 Hz with a noise of half a millimetre.
    fn found(place: impl Fn(f64) -> Point) -> Vec<Bounce> {
        let rig = Rig::demo(Shape::Cylinder);
        let mut breaks = Breaks::new(&rig, rig.camera.noise);
        for i in 0..120_i64 {
            let t = i as f64 / 60.0;
            let wobble = |k: f64| 0.0007 * ((i * i) as f64 * k).sin();
            let point = place(t);
            breaks.see(&Sample::at(
                (t * 1e9) as i64,
                Point::new(point.x + wobble(1.1), point.y + wobble(2.3)),
            ));
        }
        let flights = breaks.take(true);
        flights
            .iter()
            .filter_map(|(flight, _)| flight.bounce())
            .collect()
    }

    #[test]
    fn a_fence_turns_an_object_round_and_friction_slopes_and_pushes_do_not() {
        // Towards a fence at x = 0.6, which gives back 60 %.
        let fenced = found(|t| {
            let hit = 0.43;
            let x = if t < hit {
                0.6 - 0.8 * (hit - t)
            } else {
                0.6 - 0.48 * (t - hit)
            };
            Point::new(x, 0.3 * t)
        });
        let [bounce] = fenced[..] else {
            panic!("{fenced:?}");
        };
        assert!((bounce.place.x - 0.6).abs() < 0.004, "{bounce:?}");
        assert!((bounce.after.x + 0.48).abs() < 0.06, "{bounce:?}");

        // A slide to rest; friction that trebles; a second push; up a slope and down again.
        let slide = |t: f64| 0.8 * t.min(0.4) - t.min(0.4).powi(2);
        assert_eq!(found(|t| Point::new(slide(t), 0.0)), []);
        let edge = |t: f64| {
            if t < 0.3 {
                t
            } else {
                0.3 + (1.0 - 3.0 * (t.min(0.46) - 0.3)) * (t.min(0.46) - 0.3)
            }
        };
        assert_eq!(found(|t| Point::new(edge(t), 0.0)), []);
        assert_eq!(
            found(|t| Point::new(if t < 0.5 { 0.3 * t } else { 0.15 + t - 0.5 }, 0.0)),
            []
        );
        assert_eq!(found(|t| Point::new(0.5 * t - 0.5 * t * t, 0.0)), []);
    }

    #[test]
    fn no_impact_is_missed_where_frames_come_a_little_sooner_or_later() {
        // A puck that is struck back at 120 Hz: a line through as much as one frame from beyond the impact fits nothing.
        let rig = Rig::demo(Shape::Cylinder);
        for phase in 0..100 {
            let hit = 0.5 + f64::from(phase) / 12_000.0;
            let mut breaks = Breaks::new(&rig, rig.camera.noise);
            for i in 0..120_i64 {
                let t = i as f64 / 120.0 + 0.0003 * (2.1 * (i + 7 * i64::from(phase)) as f64).sin();
                breaks.see(&Sample {
                    stamp: (t * 1e9) as i64,
                    x: if t < hit {
                        -1.5 * (t - hit)
                    } else {
                        2.7 * (t - hit)
                    },
                    y: 0.2 * t,
                });
            }
            let flights = breaks.take(true);
            let begun: Vec<f64> = flights
                .iter()
                .filter_map(|(flight, _)| Some(1e-9 * flight.begun?.stamp as f64))
                .collect();
            assert!(
                matches!(begun[..], [at] if (at - hit).abs() < 0.001),
                "{hit}: {begun:?}"
            );
        }
    }

    #[test]
    fn noise_that_goes_on_from_frame_to_frame_turns_nothing_round() {
        // At 240 Hz, a slide in errors of 1.5 mm that last for some frames: more than the rig file says.
        let rig = Rig::demo(Shape::Cylinder);
        let slide = |t: f64| 0.5 * t.min(0.4) - 0.6 * t.min(0.4).powi(2);
        let turned = |noise: f64, seed: u32| {
            let wave = |i: i64, k: f64| (i as f64 * k + f64::from(seed)).sin();
            let wobble = |i: i64| 0.0013 * (wave(i, 0.19) + wave(i, 0.37));
            let frames = (0..150_i64).map(|i| {
                Sample::at(
                    i * 1_000_000_000 / 240,
                    Point::new(slide(i as f64 / 240.0) + wobble(i), wobble(i + 1000)),
                )
            });
            turned_round(&rig, noise, frames).is_some()
        };
        let count = |noise: f64| (0..20).filter(|seed| turned(noise, *seed)).count();
        assert_eq!(count(0.0015), 0);
        assert!(count(rig.camera.noise) > 0);
    }

    #[test]
    fn what_is_struck_from_rest_was_not_turned_round() {
        // Such noise before a strike, twice what the rig file says.
        let rig = Rig::demo(Shape::Cylinder);
        let slide = |t: f64| 0.7 * t.clamp(0.0, 0.4) - 0.8 * t.clamp(0.0, 0.4).powi(2);
        let turned = |before: &dyn Fn(f64) -> f64, seed: u32| {
            let wave = |i: i64, k: f64| (i as f64 * k + f64::from(seed)).sin();
            let wobble = |i: i64| 0.001 * (wave(i, 0.19) + wave(i, 0.37));
            let frames = (0..300_i64).map(|i| {
                let t = i as f64 / 240.0 - 0.5;
                Sample::at(
                    i * 1_000_000_000 / 240,
                    Point::new(
                        if t < 0.0 { before(t) } else { slide(t) } + wobble(i),
                        wobble(i + 1000),
                    ),
                )
            });
            turned_round(&rig, rig.camera.noise, frames.take(160)).is_some()
        };
        let count =
            |before: &dyn Fn(f64) -> f64| (0..20).filter(|seed| turned(before, *seed)).count();
        assert_eq!(count(&|_| 0.0), 0);
        // What comes to the same place as slowly as shows, is.
        assert_eq!(count(&|t| -0.25 * t), 20);
    }
}
