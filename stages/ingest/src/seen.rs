//! What a log shows of commands and of motions, each on its own, before one is judged by the other: what a check of frames and clocks
//! needs, whatever became of the strikes.

use std::collections::VecDeque;

use logs::Sample;
use serde::{Deserialize, Serialize};
use values::{Point, Rig, Strike, Track};

use crate::arm::{Meeting, TouchDelay};
use crate::bounces::{self, Bounce, Hit};
use crate::episode::{Episode, is_finite, speed};
use crate::lost::is_out_of_reach;
use crate::order::{seconds, since};
use crate::plateau::plateau;
use crate::pushes::Parabola;
use crate::robust::{median, median_point, spread};

/// Commands and motions of one log, each in order of time; times are in s on the log's clocks, as it is read.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Seen {
    /// Rises and falls of the command.
    pub commands: Vec<CommandSeen>,
    /// Motions of the object, from rest.
    pub motions: Vec<MotionSeen>,
    /// Frames in which the object was seen.
    pub frames: u64,
    /// Frames in which the object was not seen: without numbers, at zero, or where no object gets, as trackers write that see nothing.
    pub lost: u64,
    /// Frames in which the object was seen farther from where the frame before saw it than any object gets.
    #[serde(default)]
    pub jumps: u64,
    /// How often another object, at rest, was seen for a while, and then the object again.
    #[serde(default)]
    pub bursts: u64,
    /// Frames of a resting object.
    #[serde(default)]
    pub resting: u64,
    /// Of these, such that lie where the one before the last did, and far from the last.
    #[serde(default)]
    pub alternating: u64,
    /// How far from the last these lie together, in m.
    #[serde(default)]
    pub alternating_by: f64,
    /// Standard deviation of a resting centroid's coordinate, in m, one a rest.
    pub noise: Vec<f64>,
    /// Velocities, in m/s, that the frames of a resting object show over the time in which a bounce is seen: both coordinates of one a rest.
    #[serde(default)]
    pub stirs: Vec<f64>,
    /// Where the object was turned round, or deflected, by something else than the tip.
    #[serde(default)]
    pub bounces: Vec<Bounce>,
    /// Time from the tip's touching the object, by its measured place, to the object's first motion, one a strike.
    pub delays: Vec<TouchDelay>,
    /// Time, in s, by which the arm's measured speed lies behind the commanded one, one a strike.
    #[serde(default)]
    pub behind: Vec<f64>,
    /// Distance of both centres where the tip seems to have pushed the object.
    #[serde(default)]
    pub hits: Vec<Hit>,
    /// Where the tip was, by its measured place, as the object began to move, one a strike from rest.
    #[serde(default)]
    pub meetings: Vec<Meeting>,
    /// Ratio of an object's speed a while after a strike to its speed right after it.
    #[serde(default)]
    pub gathered: Vec<f64>,
    /// Half the variance, in s², of the times over which an object's places seem to be smeared as it begins to move, one a strike.
    #[serde(default)]
    pub smeared: Vec<f64>,
    /// Ratio of an object's speed a twentieth of a second after it began to move to that between its first frames, one a strike.
    #[serde(default)]
    pub risen: Vec<f64>,
    /// How many times as slow the camera's stamps go as the arm's do, by the recorder's clock, with the standard error.
    #[serde(default)]
    pub slow: Option<[f64; 2]>,
    /// Slides that no strike began.
    #[serde(default)]
    pub slides: Vec<Strike>,
    /// Whether no command is logged, and what the arm did stands for it.
    #[serde(default)]
    pub is_by_state: bool,
}

/// One rise and fall of the command.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CommandSeen {
    /// Time, in s, at which the command left rest.
    pub rise: f64,
    /// Time, in s, at which it was at rest again.
    pub fall: f64,
    /// Speed of its plateau, in m/s; its highest where it holds none.
    pub speed: f64,
    /// Direction of its plateau, in rad.
    pub angle: f64,
}

/// One motion of the object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MotionSeen {
    /// Time, in s, at which the object was first seen away from its rest.
    pub start: f64,
    /// Where it rested, in m.
    pub from: Point,
    /// Its velocity in the first tenth of a second, in m/s.
    pub velocity: Point,
    /// Its speed as it began to move, in m/s: what brakes it changes it less than it does `velocity`, and noise more.
    #[serde(default)]
    pub at_first: f64,
}

impl CommandSeen {
    /// The command of an episode; none for a blip, and for one that is cut or not finite.
    pub(crate) fn of(episode: &Episode, rig: &Rig) -> Option<Self> {
        let finite: Vec<&Sample> = episode.commands.iter().filter(|c| is_finite(c)).collect();
        if episode.is_blip() || finite.is_empty() {
            return None;
        }
        let sum = finite.iter().fold(Point::default(), |sum, command| {
            sum + Point::new(command.x, command.y)
        });
        let known = plateau(&episode.commands, rig).ok();
        let highest = finite.iter().map(|c| speed(c)).fold(0.0, f64::max);
        Some(Self {
            rise: seconds(episode.start()),
            fall: seconds(episode.end()),
            speed: known.map_or(highest, |command| command.speed),
            angle: known.map_or(sum.bearing(), |command| command.angle),
        })
    }
}

/// Least time between frames, in s: faster ones are thinned out.
const INTERVAL: f64 = 0.003;
/// Time, in s, that an object must lie still to be at rest.
const REST: f64 = 0.25;
/// Least number of frames that show a rest.
const REST_FRAMES: usize = 5;
/// Greatest distance from one place of an object that lies still, in m and in deviations of the camera's noise.
const STILL: f64 = 0.002;
const STILL_NOISE: f64 = 4.0;
/// Distance from a rest at which an object is surely away, in m and in deviations; and the number of frames that show it.
const AWAY: f64 = 0.005;
const AWAY_NOISE: f64 = 8.0;
const AWAY_FRAMES: usize = 4;
/// Time over which a launch is seen, in s, or over as many frames.
const LAUNCH: f64 = 0.1;
const LAUNCH_FRAMES: usize = 4;

/// A tip lets go of an object within this time, in s; speeds are looked at from then on, and this long after it began to move, each over some time.
const LET_GO: f64 = 0.012;
const LATER: f64 = 0.07;
const LATER_TIME: f64 = 0.025;
/// Time between the frames that show the first speed at the least, and times, in s, after an object began to move, of a later one: a filter of 15 ms
/// and more has then all but caught up.
const AT_FIRST: f64 = 0.01;
const RISEN: f64 = 0.045;
const RISEN_TIME: f64 = 0.03;

/// Times, in s, after an object began to move between which it surely slides, and the end of its way, in m, in which it may come to rest.
const SLIDES: std::ops::Range<f64> = 0.07..0.28;
const COMES_TO_REST: f64 = 0.01;

/// The mean speed from this time of a track on, over some time, with the moments of its ends; none for a track of few frames.
fn speed_of(track: &Track, from: f64, time: f64) -> Option<(f64, [f64; 2])> {
    let first =
        |from: f64| Some(track.t.partition_point(|t| *t < from)).filter(|i| *i < track.len());
    let from = first(from)?;
    let to = first(track.t[from] + time)?;
    let ends = [track.t[from], track.t[to]];
    let gone = track.point(from).distance(track.point(to));
    Some((gone / (ends[1] - ends[0]), ends))
}

/// Ratio of the object's speed a while after it began to move to its speed at first: a table only slows it down. None for a track of few frames.
pub(crate) fn gathered(track: &Track) -> Option<f64> {
    let speed = |from: f64, time: f64| speed_of(track, from, time).map(|(speed, _)| speed);
    let ratio = speed(LATER, LATER_TIME)? / speed(LET_GO, LET_GO)?;
    ratio.is_finite().then_some(ratio)
}

/// Ratio of the object's speed when a filter has caught up to its speed between its first frames. None for a track of few frames.
pub(crate) fn risen(track: &Track) -> Option<f64> {
    let speed = |from: f64, time: f64| speed_of(track, from, time).map(|(speed, _)| speed);
    let ratio = speed(RISEN, RISEN_TIME)? / speed(0.0, AT_FIRST)?;
    ratio.is_finite().then_some(ratio)
}

/// Half the variance, in s², of the times over which an object's places are smeared as it begins to move, out of the rest at `initial` that ended some
/// `gap` s before: the area between its way and that of a sudden start, which its slide tells, by its speed. A filter follows little by little,
/// and an impact takes some ms. None for a track that tells little of the slide.
pub(crate) fn smeared(track: &Track, initial: Point, gap: f64) -> Option<f64> {
    const FEWEST: usize = 5;
    let last = track.point(track.len().checked_sub(1)?);
    let comes = |i: &usize| track.point(*i).distance(last) < COMES_TO_REST;
    let rests = (0..track.len()).find(comes)?;
    let [from, to] = [SLIDES.start, SLIDES.end].map(|t| track.t.partition_point(|one| *one <= t));
    let to = to.min(rests);
    if to < from + FEWEST {
        return None;
    }
    let slide = Parabola::through(&Track {
        t: track.t[from..to].to_vec(),
        x: track.x[from..to].to_vec(),
        y: track.y[from..to].to_vec(),
        ..track.clone()
    });
    let ahead = track.point(to - 1) - initial;
    let ahead = ahead * (1.0 / ahead.norm().max(1e-12));
    let (place, speed) = (
        (slide.place - initial).dot(ahead),
        slide.velocity.dot(ahead),
    );
    let bend = 0.5 * slide.acceleration.dot(ahead);
    // The time at which the slide, continued, began, and its speed then.
    let square = speed * speed - 4.0 * bend * place;
    let began = -2.0 * place / (speed + square.max(0.0).sqrt());
    let at_first = speed + 2.0 * bend * began;
    let beside = |i: usize| {
        let t = track.t[i];
        let sudden = if t > began {
            place + (speed + bend * t) * t
        } else {
            0.0
        };
        let before = if i > 0 { track.t[i - 1] } else { -gap };
        ((track.point(i) - initial).dot(ahead) - sudden) * 0.5 * (track.t[i + 1] - before)
    };
    let smeared = (0..from).map(beside).sum::<f64>() / at_first;
    (square > 0.0 && at_first > 0.0 && smeared.is_finite()).then_some(smeared)
}

/// Finds motions in a stream of centroids.
pub(crate) struct Watch {
    noise: f64,
    /// The frames of the last rest time.
    recent: VecDeque<(i64, Point)>,
    state: State,
    last: Option<i64>,
    /// The last frame, and the place in the one before it.
    before: Option<(i64, Point)>,
    twice_before: Option<Point>,
}

/// Distance in m from which a frame that lies where the one before the last did is another camera's.
const ALTERNATES: f64 = 0.002;

enum State {
    Unknown,
    Rests(Point),
    /// Frames since it left a rest.
    Leaves(Point, Vec<(i64, Point)>),
    Moves,
}

impl Watch {
    pub(crate) fn new(rig: &Rig) -> Self {
        Self {
            noise: rig.camera.noise,
            recent: VecDeque::new(),
            state: State::Unknown,
            last: None,
            before: None,
            twice_before: None,
        }
    }

    /// Takes a finite centroid, in order of stamps.
    pub(crate) fn take(&mut self, sample: &Sample, seen: &mut Seen) {
        let (stamp, point) = (sample.stamp, Point::new(sample.x, sample.y));
        let before = self.before.replace((stamp, point));
        let jumps = before.is_some_and(|before| is_out_of_reach(before, (stamp, point)));
        seen.jumps += u64::from(jumps);
        let twice_before =
            std::mem::replace(&mut self.twice_before, before.map(|(_, place)| place));
        if let (State::Rests(_), Some((_, last)), Some(other)) = (&self.state, before, twice_before)
        {
            let apart = point.distance(last);
            let alternates = !jumps
                && apart > ALTERNATES.max(AWAY_NOISE * self.noise)
                && point.distance(other) < 0.5 * apart;
            seen.resting += 1;
            seen.alternating += u64::from(alternates);
            seen.alternating_by += if alternates { apart } else { 0.0 };
        }
        if self.last.is_some_and(|last| since(last, stamp) < INTERVAL) {
            return;
        }
        self.last = Some(stamp);
        self.recent.push_back((stamp, point));
        while self
            .recent
            .front()
            .is_some_and(|(first, _)| since(*first, stamp) > REST)
        {
            self.recent.pop_front();
        }
        let away = AWAY.max(AWAY_NOISE * self.noise);
        self.state = match std::mem::replace(&mut self.state, State::Unknown) {
            State::Rests(place) if point.distance(place) > away => {
                State::Leaves(place, vec![(stamp, point)])
            }
            // Trackers wander slowly: the place follows.
            State::Rests(place) => State::Rests(place + (point - place) * 0.05),
            State::Leaves(place, _) if point.distance(place) <= away => State::Rests(place),
            State::Leaves(place, mut frames) => {
                frames.push((stamp, point));
                let is_launched = frames.len() >= AWAY_FRAMES.max(LAUNCH_FRAMES)
                    && since(frames[0].0, stamp) >= LAUNCH;
                if is_launched {
                    seen.motions.push(MotionSeen {
                        start: seconds(frames[0].0),
                        from: place,
                        velocity: velocity(&frames),
                        at_first: speed_at_first(&frames),
                    });
                    State::Moves
                } else {
                    State::Leaves(place, frames)
                }
            }
            moving @ (State::Unknown | State::Moves) => match self.rest() {
                Some((place, noise)) => {
                    seen.noise.push(noise);
                    seen.stirs
                        .extend(self.stir().into_iter().flat_map(|v| [v.x, v.y]));
                    State::Rests(place)
                }
                None => moving,
            },
        };
    }

    /// The velocity that the last frames show over the time in which a bounce is seen.
    fn stir(&self) -> Option<Point> {
        let (last, _) = self.recent.back()?;
        let spans = |at: &usize| {
            let time = since(self.recent[*at].0, *last);
            self.recent.len() - at >= bounces::FRAMES && time >= bounces::TIME
        };
        let from = (0..self.recent.len()).rev().find(spans)?;
        let frames: Vec<(i64, Point)> = self.recent.range(from..).copied().collect();
        Some(line_velocity(&frames))
    }

    /// Place at which the last frames lie still, and their noise, in m; none where they move.
    fn rest(&self) -> Option<(Point, f64)> {
        let (first, last) = (self.recent.front()?, self.recent.back()?);
        if self.recent.len() < REST_FRAMES || since(first.0, last.0) < 0.8 * REST {
            return None;
        }
        let reach = STILL + STILL_NOISE * self.noise;
        // The last frame alone tells a moving object at once.
        if first.1.distance(last.1) > reach {
            return None;
        }
        let points: Vec<Point> = self.recent.iter().map(|(_, point)| *point).collect();
        let middle = median_point(&points);
        let near = points
            .iter()
            .filter(|p| p.distance(middle) <= reach)
            .count();
        let half = points.len() / 2;
        let drift = median_point(&points[..half]).distance(median_point(&points[half..]));
        (5 * near >= 4 * points.len() && drift <= STILL).then(|| (middle, spread(&points)))
    }
}

/// The slope of lines through frames, but for those in which something else was tracked.
fn velocity(frames: &[(i64, Point)]) -> Point {
    /// Farther than this from where the others were is no noise, in m.
    const ELSEWHERE: f64 = 0.02;
    let start = frames[0].0;
    let pairs = || (0..frames.len()).flat_map(|i| (0..i).map(move |j| (frames[i], frames[j])));
    let slope = |of: fn(Point) -> f64| {
        median(pairs().map(|((t, p), (s, q))| (of(p) - of(q)) / since(s, t)))
    };
    let middle = Point::new(slope(|p| p.x), slope(|p| p.y));
    let origin = |(t, p): &(i64, Point)| *p - middle * since(start, *t);
    let origins: Vec<Point> = frames.iter().map(origin).collect();
    let usual = median_point(&origins);
    let near = frames.iter().zip(&origins);
    let near = near.filter(|(_, origin)| origin.distance(usual) <= ELSEWHERE);
    let near: Vec<(i64, Point)> = near.map(|(frame, _)| *frame).collect();
    if near.len() < LAUNCH_FRAMES {
        return middle;
    }
    line_velocity(&near)
}

/// The speed at the first of a launch's frames, in m/s, by the parabola that they follow.
fn speed_at_first(frames: &[(i64, Point)]) -> f64 {
    let mut track = Track::default();
    for (stamp, point) in frames {
        track.t.push(since(frames[0].0, *stamp));
        track.x.push(point.x);
        track.y.push(point.y);
    }
    Parabola::through(&track).velocity.norm()
}

fn line_velocity(frames: &[(i64, Point)]) -> Point {
    let n = frames.len() as f64;
    let at = |frame: &(i64, Point)| since(frames[0].0, frame.0);
    let mean_t = frames.iter().map(at).sum::<f64>() / n;
    let mean = frames.iter().fold(Point::default(), |sum, f| sum + f.1) * (1.0 / n);
    let (slope, square) = frames
        .iter()
        .fold((Point::default(), 0.0), |(slope, square), frame| {
            let t = at(frame) - mean_t;
            (slope + (frame.1 - mean) * t, square + t * t)
        });
    slope * (1.0 / square)
}

impl Seen {
    /// Standard deviation of a velocity that the frames of a resting object show, in m/s; none where nothing rested.
    pub(crate) fn stirring(&self) -> Option<f64> {
        let middle = median(self.stirs.iter().map(|v| v.abs()));
        middle.is_finite().then_some(1.4826 * middle)
    }

    /// Median over the rests of the standard deviation of a coordinate, in m; none where nothing rested.
    pub fn noise_at_rest(&self) -> Option<f64> {
        let noise = median(self.noise.iter().copied());
        noise.is_finite().then_some(noise)
    }
}

#[cfg(test)]
mod tests {
    use values::Shape;

    use super::*;

    #[test]
    fn a_filter_smears_the_beginning_and_an_impact_does_not() {
        // From the touch on, seen at 60 Hz through a filter of this time constant (s), if any.
        let seen = |filter: f64| {
            let (speed, braking, period) = (0.8, 2.0, 1.0 / 60.0);
            let at = |t: f64| speed * t - 0.5 * braking * t * t;
            let gain = if filter > 0.0 {
                1.0 - f64::exp(-period / filter)
            } else {
                1.0
            };
            let mut place = 0.0;
            let mut track = Track::default();
            for i in 0..23 {
                place += gain * (at(0.01 + period * f64::from(i)) - place);
                track.t.push(period * f64::from(i));
                track.x.push(place);
                track.y.push(0.0);
            }
            smeared(&track, Point::default(), period).expect("enough frames")
        };
        assert!(seen(0.0).abs() < 2e-5, "{}", seen(0.0));
        for filter in [0.02, 0.03] {
            let tells = (2.0 * seen(filter)).sqrt();
            assert!((tells / filter - 1.0).abs() < 0.2, "{filter}: {tells}");
        }
    }

    #[test]
    fn a_frame_in_which_something_else_is_tracked_tells_no_velocity() {
        let frames = |astray: usize| -> Vec<(i64, Point)> {
            (0..7)
                .map(|i| {
                    let t = i as f64 / 60.0;
                    let at = Point::new(0.3 + 0.8 * t - t * t, 0.2 * t);
                    let elsewhere = Point::new(0.9, -0.5);
                    ((t * 1e9) as i64, if i == astray { elsewhere } else { at })
                })
                .collect()
        };
        let whole = velocity(&frames(9));
        assert_eq!(whole, line_velocity(&frames(9)));
        for astray in 0..7 {
            let off = velocity(&frames(astray)).distance(whole);
            assert!(off < 0.03, "{astray}: {off}");
        }
    }

    #[test]
    fn a_tracker_that_sees_two_objects_jumps_and_one_that_sees_a_fast_one_does_not() {
        let rig = Rig::demo(Shape::Cylinder);
        let jumps = |other: i64| {
            let (mut watch, mut seen) = (Watch::new(&rig), Seen::default());
            for i in 0..120_i64 {
                // A puck of 5 m/s.
                let t = i as f64 / 120.0;
                let x = if i % other == 0 { 0.1 } else { 5.0 * t };
                let sample = Sample::at((t * 1e9) as i64, Point::new(x, 0.0));
                watch.take(&sample, &mut seen);
            }
            seen.jumps
        };
        assert_eq!(jumps(1000), 0);
        assert!((70..=80).contains(&jumps(3)), "{}", jumps(3));
    }

    #[test]
    fn a_motion_is_seen_with_its_launch_and_rests_are_not() {
        let rig = Rig::demo(Shape::Cylinder);
        let (mut watch, mut seen) = (Watch::new(&rig), Seen::default());
        for i in 0..300_i64 {
            let t = i as f64 / 60.0;
            let gone = |start: f64| {
                let t = (t - start).clamp(0.0, 0.4);
                0.8 * t - t * t
            };
            let wobble = 0.0003 * (i as f64 * 2.3).sin();
            watch.take(
                &Sample::at(
                    (t * 1e9) as i64,
                    Point::new(0.3 + gone(1.0) + wobble, gone(3.0) - wobble),
                ),
                &mut seen,
            );
        }
        let [along, aside] = &seen.motions[..] else {
            panic!("{seen:?}");
        };
        assert!((along.start - 1.0).abs() < 0.05 && (aside.start - 3.0).abs() < 0.05);
        assert!(along.velocity.bearing().abs() < 0.05);
        assert!((aside.velocity.bearing() - 1.571).abs() < 0.05);
        assert!((0.6..0.8).contains(&along.velocity.norm()), "{along:?}");
    }
}
