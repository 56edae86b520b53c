//! Slides that no strike began, such as a hand's push: what a table does to an object shows in them as well.
//!
//! Only where the tip's measured place shows that the arm was far away all the while. A slide begins once the object has been let go. A
//! hand that carries an object to a place is no slide: it slows down for as long as it sped up, and not as a table brakes, which is as hard
//! at the beginning as at the end. Whether a slide agrees with those that strikes began is asked where it is to teach.

use std::collections::VecDeque;

use logs::Sample;
use values::{Command, Conditions, Point, Rig, Shape, Split, Strike, Track};

use crate::arm::State;
use crate::identity::slide_id;
use crate::order::{seconds, since};
use crate::robust::{median_point, spread};
use crate::slide::is_rest;
use crate::touched::{place, seen, without_outliers};

/// Time, in s, that an object must lie still to be at rest: some frames longer than [`seen`] needs, which is to find the rest in the motion. Distance
/// from one place within which it lies still: in deviations of the camera's noise, and in m.
const REST: f64 = 0.35;
const REST_NOISE: f64 = 4.0;
const STILL: f64 = 0.002;
/// Time between frames, in s, beyond which they show no motion; and longest time of a slide, in s.
const GAP: f64 = 0.07;
const LONGEST: f64 = 20.0;
/// Time, in s, to both sides of a frame over which speeds are taken; and least speed, in m/s, of an object that was pushed.
const HALF: f64 = 0.025;
const SLOWEST: f64 = 0.15;
/// Latest time, in s, of letting go after the object has come within this part of its highest speed.
const LET_GO: f64 = 0.04;
const NEAR_PEAK: f64 = 0.98;
/// Least number of frames and least way, in m, of a slide.
const FEWEST: usize = 12;
const SHORTEST: f64 = 0.05;
/// Greatest share of the way, and of the time, of the slide that an object goes before it is fastest: what a hand carries goes about as far.
const PUSHED: f64 = 0.5;
/// Greatest root mean square of frames about a parabola, in m and in deviations of the camera's noise.
const STRAIGHT: f64 = 0.0005;
const STRAIGHT_NOISE: f64 = 1.25;
/// Greatest change of a slide's braking from its middle to its ends, and from the middle to both ends alike: as a part of it, or in standard errors,
/// of which the first counts only where it is known to better than the last number. A hand that takes something from here to there brakes from
/// nothing to twice its mean, or there and back.
const EVEN: f64 = 0.5;
const ARCHED: f64 = 0.7;
const EVEN_ERRORS: f64 = 3.0;
const EVEN_KNOWN: f64 = 0.5;
/// Deceleration (m/s²) below which, as on an air table, frames do not tell how it changes.
const HARDLY: f64 = 0.5;
/// Greatest deceleration, or acceleration, by a table, in m/s².
const BRAKES: f64 = 10.0;
const SPEEDS_UP: f64 = 0.3;
/// Least distance in m, beside both radii, of a tip that is far away, and greatest time in s between the states that tell it.
const FAR: f64 = 0.03;
const STATES: f64 = 0.1;
/// Greatest number of motions that wait for the arm's states.
const MOST_WAITING: usize = 50;

/// Finds slides that no strike began in a stream of centroids, from rest on.
pub(crate) struct Pushes {
    noise: f64,
    is_possible: bool,
    phase: Phase,
    /// The motion in hand, with the rest before it.
    run: Vec<Sample>,
    /// Motions that have ended.
    ended: VecDeque<Vec<Sample>>,
    tips: VecDeque<State>,
    /// Motions that were taken for a hand's carrying.
    carried: u64,
    /// Times in s of slides of which no state tells where the arm was.
    untold: Vec<f64>,
}

enum Phase {
    Unknown,
    Rests(Point),
    Moves,
}

/// What a motion that has ended was.
enum Motion {
    Slide(Box<Strike>),
    /// A slide from this time (s) on, of a log that does not tell where the arm is.
    Untold(f64),
    /// No slide, and the arm was far away.
    Carried,
    /// Too little to tell, or the arm's.
    Other,
}

impl Pushes {
    /// A finder of slides of the rig's object; it finds none of a box or a ball: how a box turns is not known, and a ball that is let go may roll or
    /// slide.
    pub(crate) fn new(rig: &Rig) -> Self {
        Self {
            noise: rig.camera.noise,
            is_possible: rig.object.shape() == Shape::Cylinder,
            phase: Phase::Unknown,
            run: Vec::new(),
            ended: VecDeque::new(),
            tips: VecDeque::new(),
            carried: 0,
            untold: Vec::new(),
        }
    }

    /// Takes a centroid, in order of stamps.
    pub(crate) fn see(&mut self, sample: &Sample) {
        if !self.is_possible {
            return;
        }
        let too_late = |from: Option<&Sample>, time: f64| {
            from.is_some_and(|from| since(from.stamp, sample.stamp) > time)
        };
        if too_late(self.run.last(), GAP) || too_late(self.run.first(), LONGEST) {
            self.end();
        }
        self.run.push(*sample);
        let reach = STILL + REST_NOISE * self.noise;
        match self.phase {
            Phase::Rests(rest) if place(sample).distance(rest) <= reach => {
                self.phase = Phase::Rests(rest + (place(sample) - rest) * 0.05);
                if too_late(self.run.first(), 4.0 * REST) {
                    self.keep_rest();
                }
            }
            Phase::Rests(_) => self.phase = Phase::Moves,
            Phase::Moves | Phase::Unknown => {
                if let Some(rest) = self.rest() {
                    if matches!(self.phase, Phase::Moves) {
                        self.wait(self.run.clone());
                    }
                    self.keep_rest();
                    self.phase = Phase::Rests(rest);
                }
            }
        }
    }

    /// Place at which the last frames lie still; none where they move.
    fn rest(&self) -> Option<Point> {
        let last = self.run.last()?;
        let from = self.resting_from(last);
        let first = self.run.get(from)?;
        let is_near = place(first).distance(place(last)) <= STILL + REST_NOISE * self.noise;
        if from == 0 || !is_near || self.run.len() < from + 4 {
            return None;
        }
        let points: Vec<Point> = self.run[from..].iter().map(place).collect();
        is_rest(&points, REST_NOISE * self.noise, self.noise).then(|| median_point(&points))
    }

    fn resting_from(&self, last: &Sample) -> usize {
        let is_before = |frame: &Sample| since(frame.stamp, last.stamp) > REST;
        self.run.partition_point(is_before)
    }

    fn keep_rest(&mut self) {
        if let Some(last) = self.run.last().copied() {
            self.run.drain(..self.resting_from(&last));
        }
    }

    fn wait(&mut self, run: Vec<Sample>) {
        if self.ended.len() >= MOST_WAITING {
            self.ended.pop_front();
        }
        self.ended.push_back(run);
    }

    /// Nothing is seen for a while, or for ever.
    fn end(&mut self) {
        let run = std::mem::take(&mut self.run);
        if matches!(self.phase, Phase::Moves) {
            self.wait(run);
        }
        self.phase = Phase::Unknown;
    }

    /// Takes a state of the arm, in order of stamps.
    pub(crate) fn tip(&mut self, state: &State) {
        if !self.is_possible || !state.position.is_finite() {
            return;
        }
        self.tips.push_back(*state);
        let is_old = |first: &State| since(first.stamp, state.stamp) > 2.0 * LONGEST;
        while self.tips.front().is_some_and(is_old) {
            self.tips.pop_front();
        }
    }

    /// Slides of motions that have ended; those of which it is not yet known where the tip was only at the end of the data.
    pub(crate) fn take(&mut self, log: &str, rig: &Rig, at_end: bool) -> Vec<Strike> {
        if at_end {
            self.end();
        }
        let mut slides = Vec::new();
        while let Some(run) = self.ended.front() {
            let tip = self.tips.back().map(|tip| tip.stamp);
            let is_known = run.last().map(|last| last.stamp) <= tip;
            if !(at_end || is_known) {
                break;
            }
            match self.motion(run, log, rig) {
                Motion::Slide(slide) => slides.push(*slide),
                Motion::Untold(from) => self.untold.push(from),
                Motion::Carried => self.carried += 1,
                Motion::Other => {}
            }
            self.ended.pop_front();
        }
        slides
    }

    /// Number of motions since the last call that were taken for a hand's carrying.
    pub(crate) fn take_carried(&mut self) -> u64 {
        std::mem::take(&mut self.carried)
    }

    /// Times in s of slides since the last call, in a log that does not tell where the arm is: strikes' and others.
    pub(crate) fn take_untold(&mut self) -> Vec<f64> {
        std::mem::take(&mut self.untold)
    }

    /// Classifies one motion.
    fn motion(&self, run: &[Sample], log: &str, rig: &Rig) -> Motion {
        let all = without_outliers(run, self.noise);
        if let Some((slide, until)) = self.slide(&all, log, rig) {
            if self.tips.is_empty() {
                return Motion::Untold(slide.t_start);
            }
            if self.is_far(&all[..until], rig) {
                return Motion::Slide(Box::new(slide));
            }
        }
        let is_fast = (0..all.len()).any(|at| speed(&all, at) >= SLOWEST);
        let goes = all.first().zip(all.last());
        let goes = goes.map_or(0.0, |(first, last)| place(first).distance(place(last)));
        match is_fast && goes >= SHORTEST && self.is_far(&all, rig) {
            true => Motion::Carried,
            false => Motion::Other,
        }
    }

    /// The slide of one motion, if it is one, as what no strike began, and the number of frames up to its end.
    fn slide(&self, all: &[Sample], log: &str, rig: &Rig) -> Option<(Strike, usize)> {
        let begin = all.first()?.stamp;
        let resting = all.partition_point(|frame| since(begin, frame.stamp) < 0.5 * REST);
        let before: Vec<Point> = all[..resting].iter().map(place).collect();
        let noise = spread(&before).clamp(self.noise, 3.0 * self.noise);
        let speeds: Vec<f64> = (0..all.len()).map(|at| speed(all, at)).collect();
        let highest = speeds.iter().copied().fold(0.0, f64::max);
        let peak = speeds
            .iter()
            .position(|speed| *speed >= NEAR_PEAK * highest)?;
        let from = all.partition_point(|frame| since(all[peak].stamp, frame.stamp) < LET_GO);
        let (frames, end, stop) = seen(&all[from..], false, rig);
        let (first, last) = (frames.first()?, frames.last()?);
        let gone = place(first).distance(place(last));
        if highest < SLOWEST || frames.len() < FEWEST || gone < SHORTEST {
            return None;
        }
        let moves = (0..peak).rfind(|at| speeds[*at] < 0.1 * highest)?;
        let (begun, free) = (&all[moves], &all[peak]);
        let pushed = place(begun).distance(place(free));
        let pushed_for = since(begun.stamp, free.stamp);
        let slid = place(free).distance(place(last));
        let slid_for = since(free.stamp, last.stamp);
        if pushed > PUSHED * slid || pushed_for > PUSHED * slid_for {
            return None;
        }
        let track = Track {
            t: frames
                .iter()
                .map(|frame| since(first.stamp, frame.stamp))
                .collect(),
            x: frames.iter().map(|frame| frame.x).collect(),
            y: frames.iter().map(|frame| frame.y).collect(),
            yaw: None,
            end,
        };
        let parabola = Parabola::through(&track);
        let ahead = parabola.velocity * (1.0 / parabola.velocity.norm().max(1e-12));
        let along = parabola.acceleration.dot(ahead);
        let is_slide = parabola.misfit <= STRAIGHT + STRAIGHT_NOISE * noise
            && (-BRAKES..SPEEDS_UP).contains(&along)
            && is_braked_evenly(&track, ahead, noise)
            && !track.is_pushed_again();
        if !is_slide {
            return None;
        }
        let slide = Strike {
            id: slide_id(frames),
            log: log.into(),
            t_start: seconds(first.stamp),
            conditions: Conditions {
                session: log.into(),
                is_unstruck: true,
                ..Conditions::default()
            },
            track,
            split: Split::Train,
            ..Strike::bare(
                Command::new(parabola.velocity.norm(), parabola.velocity.bearing()),
                parabola.place,
                stop.unwrap_or(place(last)),
            )
        };
        Some((slide, from + frames.len()))
    }

    /// Whether the tip's measured places show that it was far away all the while.
    fn is_far(&self, frames: &[Sample], rig: &Rig) -> bool {
        let reach = rig.object.solid.reach() + rig.striker.radius + FAR;
        let (Some(first), Some(last)) = (frames.first(), frames.last()) else {
            return false;
        };
        let mut known_until = first.stamp;
        let from = self.tips.partition_point(|tip| tip.stamp < first.stamp);
        for tip in self.tips.range(from..) {
            if since(known_until, tip.stamp) > STATES {
                return false;
            }
            known_until = tip.stamp;
            if tip.stamp > last.stamp {
                return true;
            }
            let at = frames.partition_point(|frame| frame.stamp <= tip.stamp);
            if place(&frames[at.max(1) - 1]).distance(tip.position) < reach {
                return false;
            }
        }
        since(known_until, last.stamp) <= STATES
    }
}

/// Speed at a frame, in m/s, over a frame to both sides at the least: where frames are missing, no speed of zero is feigned.
fn speed(frames: &[Sample], at: usize) -> f64 {
    let now = frames[at].stamp;
    let from = frames.partition_point(|frame| since(frame.stamp, now) > HALF);
    let to = frames.partition_point(|frame| since(now, frame.stamp) <= HALF);
    let first = &frames[from.min(at.saturating_sub(1))];
    let last = &frames[to.max(at + 2).min(frames.len()) - 1];
    let time = since(first.stamp, last.stamp);
    if time <= 0.0 {
        return 0.0;
    }
    place(first).distance(place(last)) / time
}

/// Whether what brakes an object along its way is as even as a table: neither from little to much, as in the second half of a hand's carry,
/// nor most in the middle. By a polynomial of the fourth degree over the frames' times, whose terms are orthogonal.
fn is_braked_evenly(track: &Track, ahead: Point, noise: f64) -> bool {
    let duration = track.t[track.len() - 1];
    let late: Vec<f64> = track.t.iter().map(|t| 2.0 * t / duration - 1.0).collect();
    let product = |one: &[f64], other: &[f64]| -> f64 {
        one.iter().zip(other).map(|(one, other)| one * other).sum()
    };
    let mut terms: Vec<Vec<f64>> = vec![vec![1.0; track.len()]];
    while let (Some(last), true) = (terms.last(), terms.len() < 5) {
        let mut next: Vec<f64> = last.iter().zip(&late).map(|(p, s)| p * s).collect();
        for term in &terms {
            let share = product(&next, term) / product(term, term);
            next.iter_mut().zip(term).for_each(|(p, q)| *p -= share * q);
        }
        terms.push(next);
    }
    let gone: Vec<f64> = (0..track.len())
        .map(|i| track.point(i).dot(ahead))
        .collect();
    // Each with its standard error.
    let part = |power: usize| {
        let square = product(&terms[power], &terms[power]);
        (
            product(&gone, &terms[power]) / square,
            noise / square.sqrt(),
        )
    };
    let ((braked, _), (change, error), (arch, arch_error)) = (part(2), part(3), part(4));
    // Second derivatives by the scaled time: of the square 2, of the cube 6 at an end, of the fourth power 8 beyond its mean.
    let [change, error] = [change, error].map(|part| 3.0 * part.abs() / braked.abs());
    let [arch, arch_error] = [arch, arch_error].map(|part| 4.0 * part.abs() / braked.abs());
    let is_known = error < EVEN_KNOWN || 8.0 * braked.abs() < HARDLY * duration * duration;
    is_known
        && change <= EVEN.max(EVEN_ERRORS * error)
        && arch <= ARCHED.max(EVEN_ERRORS * arch_error)
}

/// A parabola through places over time, by least squares.
pub(crate) struct Parabola {
    /// Place and velocity at time zero, in m and m/s.
    pub(crate) place: Point,
    pub(crate) velocity: Point,
    /// Acceleration, in m/s².
    pub(crate) acceleration: Point,
    /// Root mean square of a coordinate about it, in m.
    misfit: f64,
}

impl Parabola {
    /// The parabola by polynomials that are orthogonal over the frames' times, of which there are four at the least.
    pub(crate) fn through(track: &Track) -> Self {
        let n = track.len() as f64;
        let mean = track.t.iter().sum::<f64>() / n;
        let power = |k: i32| track.t.iter().map(|t| (t - mean).powi(k)).sum::<f64>();
        let (skew, square) = (power(3) / power(2), power(2) / n);
        let basis = |t: f64| {
            let late = t - mean;
            [1.0, late, late * late - skew * late - square]
        };
        let [mut sums, mut weights] = [[Point::default(); 3], [Point::default(); 3]];
        for (i, t) in track.t.iter().enumerate() {
            for (k, value) in basis(*t).into_iter().enumerate() {
                sums[k] = sums[k] + track.point(i) * value;
                weights[k].x += value * value;
            }
        }
        let [level, slope, bend] = [0, 1, 2].map(|k| sums[k] * (1.0 / weights[k].x));
        let at = |t: f64| {
            let [one, late, square] = basis(t);
            level * one + slope * late + bend * square
        };
        let off = track.t.iter().enumerate();
        let squares: f64 = off
            .map(|(i, t)| track.point(i).distance(at(*t)).powi(2))
            .sum();
        Self {
            place: at(0.0),
            velocity: slope + bend * (-2.0 * mean - skew),
            acceleration: bend * 2.0,
            misfit: (squares / (2.0 * n - 6.0)).sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is found in one motion along x at 60 Hz with a noise of half a millimetre, the tip resting at this x.
    fn found(tip: f64, x: impl Fn(f64) -> f64) -> Vec<Strike> {
        found_and_carried(tip, x).0
    }

    /// What is found in one motion along x at 60 Hz (see `found`), and how many motions were taken for a hand carrying the object.
    fn found_and_carried(tip: f64, x: impl Fn(f64) -> f64) -> (Vec<Strike>, u64) {
        let rig = Rig::demo(Shape::Cylinder);
        let mut pushes = Pushes::new(&rig);
        for i in 0..240_i64 {
            let (stamp, t) = (i * 16_666_667, i as f64 / 60.0);
            let wobble = |k: f64| 0.0007 * ((i * i) as f64 * k).sin();
            pushes.tip(&State {
                stamp,
                velocity: Point::default(),
                position: Point::new(tip, 0.0),
            });
            pushes.see(&Sample::at(
                stamp,
                Point::new(0.3 + x(t - 0.5) + wobble(1.1), wobble(2.3)),
            ));
        }
        let slides = pushes.take("a.mcap", &rig, true);
        (slides, pushes.take_carried())
    }

    /// A hand pushes for 0.12 s and lets go; the table brakes with 2 m/s².
    fn push(t: f64) -> f64 {
        let pushed = t.clamp(0.0, 0.12);
        let slid = (t - 0.12).clamp(0.0, 0.42);
        3.5 * pushed * pushed + 0.84 * slid - slid * slid
    }

    #[test]
    fn a_hands_push_is_a_free_slide_from_where_it_is_let_go() {
        let slides = found(0.0, push);
        let [slide] = &slides[..] else {
            panic!("{slides:?}");
        };
        assert!(slide.conditions.is_unstruck && slide.has_stop());
        let gone = slide.t_start - 0.5 - 0.12;
        assert!((0.0..0.1).contains(&gone), "{gone}");
        let released = 0.84 - 2.0 * gone;
        assert!((slide.command.speed - released).abs() < 0.02, "{slide:?}");
        assert!((slide.stop.x - 0.3 - push(9.0)).abs() < 0.001);
        let braked = slide.deceleration().expect("seen");
        assert!((braked - 2.0).abs() < 0.2, "{braked}");
    }

    #[test]
    fn what_an_arm_is_near_to_and_what_a_hand_carries_are_none() {
        assert_eq!(found(0.28, push), []);
        // In half a second, as smooth as a hand may be.
        let carry = |t: f64| {
            let s = (t / 0.5).clamp(0.0, 1.0);
            0.25 * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
        };
        assert_eq!(found(0.0, carry), []);
        // Pushed on half-way.
        let twice = |t: f64| push(t) + 0.5 * (t - 0.3).clamp(0.0, 0.5);
        assert_eq!(found(0.0, twice), []);
        assert_eq!(found(0.0, |_| 0.0), []);
    }

    /// What part of its way a carry has gone after a part of its time: its speed a half-cosine, of the least jerk, or a trapezoid that slows
    /// down half-way for an approach.
    fn carries() -> [fn(f64) -> f64; 4] {
        let trapezoid = |s: f64| {
            // Speeds of 0, 1, 1, 0.2, 0.2 and 0 at these times.
            let knots = [
                (0.0, 0.0),
                (0.15, 1.0),
                (0.45, 1.0),
                (0.6, 0.2),
                (0.92, 0.2),
                (1.0, 0.0),
            ];
            let area = |until: f64| -> f64 {
                let parts = knots.windows(2).map(|pair| {
                    let ((from, first), (to, last)) = (pair[0], pair[1]);
                    let time = (until - from).clamp(0.0, to - from);
                    time * (first + 0.5 * (last - first) * time / (to - from))
                });
                parts.sum()
            };
            area(s) / area(1.0)
        };
        [
            |s| 0.5 - 0.5 * (std::f64::consts::PI * s).cos(),
            |s| s * s * (3.0 - 2.0 * s),
            |s| s * s * s * (10.0 - 15.0 * s + 6.0 * s * s),
            trapezoid,
        ]
    }

    /// What is found in one motion along x at 60 Hz in a camera's noise of 0.7 mm, some tenths of the frames lost as it moves.
    fn noisy(seed: u64, lost: f64, x: impl Fn(f64) -> f64) -> (Vec<Strike>, u64) {
        let rig = Rig::demo(Shape::Cylinder);
        let mut pushes = Pushes::new(&rig);
        let mut state = seed;
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / (1_u64 << 31) as f64
        };
        for i in 0..240_i64 {
            let (stamp, t) = (i * 16_666_667, i as f64 / 60.0 - 0.5);
            pushes.tip(&State {
                stamp,
                velocity: Point::default(),
                position: Point::new(-0.3, 0.0),
            });
            let is_lost = uniform() < lost && t > 0.0 && x(t) < x(9.0);
            // Of many equal parts, as good as normal.
            let mut wobble = || 0.0007 * ((0..12).map(|_| uniform()).sum::<f64>() - 6.0);
            let seen = Sample::at(stamp, Point::new(0.3 + x(t) + wobble(), wobble()));
            if !is_lost {
                pushes.see(&seen);
            }
        }
        let slides = pushes.take("a.mcap", &rig, true);
        (slides, pushes.take_carried())
    }

    #[test]
    fn carries_of_every_kind_are_none_and_are_counted() {
        let (mut all, mut told, mut slides) = (0, 0, Vec::new());
        for carry in carries() {
            for i in 0..16 * 9 * 4_u32 {
                let (time, way) = (f64::from(i % 16), f64::from(i / 16 % 9));
                let (time, way) = (0.5 + 0.1 * time, 0.1 + 0.05 * way);
                let lost = if i < 16 * 9 * 2 { 0.0 } else { 0.3 };
                let x = |t: f64| way * carry((t / time).clamp(0.0, 1.0));
                let (found, carried) = noisy(u64::from(i), lost, x);
                (all, told) = (all + 1, told + carried);
                slides.extend(found.iter().filter_map(Strike::deceleration));
            }
        }
        // What is left is one so slow that noise makes its speed: no table of these logs brakes so little.
        assert!(250 * slides.len() <= all, "{slides:?} of {all}");
        assert!(slides.iter().all(|braked| *braked < 1.0), "{slides:?}");
        // The others are hardly faster than noise, or have too few frames.
        assert!(10 * told > 8 * all as u64, "{told} of {all}");
    }

    #[test]
    fn pushes_that_let_go_are_found_on_tables_that_brake_much_and_little() {
        for (brakes, speed) in [(1.5, 0.7), (1.5, 0.9), (2.5, 1.0), (2.5, 1.2), (3.5, 1.3)] {
            let push = |t: f64| {
                let (pushed, slid) = (t.clamp(0.0, 0.12), (t - 0.12).clamp(0.0, speed / brakes));
                0.5 * speed / 0.12 * pushed * pushed + (speed - 0.5 * brakes * slid) * slid
            };
            let found = (0..100).flat_map(|seed| noisy(seed, 0.0, push).0);
            let braked: Vec<f64> = found.filter_map(|slide| slide.deceleration()).collect();
            assert!(braked.len() >= 90, "{brakes} {speed}: {}", braked.len());
            let middle = crate::robust::median(braked);
            assert!((middle / brakes - 1.0).abs() < 0.03, "{brakes}: {middle}");
        }
    }
}
