//! What the arm delivered, from its measured state: velocity of the tip at contact, the moment of contact, a second push.
//!
//! A state is logged at 50 Hz or more, with noise, and a plateau may last for one sample. So the command's own profile is laid
//! through the states before contact (a factor, a turn and a delay, by least squares); what the states differ from it near contact,
//! as far as it stands out of their noise, is added. A tip meets the object on the plateau: where the object is seen to move a little after the
//! arm began to brake, the camera is late.

use logs::Sample;
use serde::{Deserialize, Serialize};
use values::{Command, Delivered, Point, Rig, Track};

use crate::order::{Stamped, seconds, since};
use crate::robust::median;

/// One measured state of the tip.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State {
    pub(crate) stamp: i64,
    /// Measured velocity of the tip, in m/s.
    pub(crate) velocity: Point,
    /// Measured position of the tip, in m; NaN where it was not logged.
    pub(crate) position: Point,
}

impl State {
    /// The measured velocity in the form of a command.
    pub(crate) fn as_command(&self) -> Sample {
        Sample::at(self.stamp, self.velocity)
    }
}

impl Stamped for State {
    fn stamp(&self) -> i64 {
        self.stamp
    }
}

/// How long after the tip's touch, by its measured place, an object was seen to move.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TouchDelay {
    /// The delay, in s.
    pub seconds: f64,
    /// Speed of the tip meanwhile, in m/s.
    pub speed: f64,
}

/// Where the tip was, by its measured place, when an object was seen to move that had rested.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Meeting {
    /// Place of the tip's centre, in m.
    pub tip: Point,
    /// The tip's measured velocity, in m/s.
    pub velocity: Point,
    /// The tip's velocity, in m/s, from its places right before; none where it moved too little in them to tell.
    pub moved: Option<Point>,
    /// Place of the object's centre, in m.
    pub object: Point,
    /// Direction of the change of the object's velocity, of length 1; none where the object rested, and the tip's heading stands for it.
    #[serde(default)]
    pub pushed: Option<Point>,
    /// By how much earlier than the camera's stamp says the tip was looked up, in s.
    #[serde(default)]
    pub earlier: f64,
    /// The camera's stamp, in s.
    #[serde(default)]
    pub at: f64,
    /// What was commanded, or what the arm did where no command is logged.
    pub command: Command,
    /// Time, in s, since the tip touched the object, by its measured place; none where that does not tell.
    #[serde(default)]
    pub delay: Option<f64>,
    /// Speed that the arm delivered, as a part of the commanded one; none where its state does not tell.
    #[serde(default)]
    pub delivered: Option<f64>,
}

impl Meeting {
    /// Direction from the tip's centre to the object's, of length 1, in the camera's frame, about which the arm's is turned by so much (rad).
    pub fn towards(&self, turn: f64) -> Point {
        self.pushed
            .unwrap_or_else(|| self.velocity.rotated(turn) * (1.0 / self.velocity.norm()))
    }
}

/// What is known of a strike when the arm is asked.
pub(crate) struct LaunchContext<'a> {
    /// Commands from rise to fall.
    pub(crate) commands: &'a [Sample],
    /// Speed and direction of the commands' plateau.
    pub(crate) command: Command,
    /// Stamp of first motion, in ns, and seconds from the frame before to it.
    pub(crate) first_motion: i64,
    pub(crate) gap: f64,
    pub(crate) initial: Point,
    pub(crate) track: &'a Track,
    /// Standard deviation of a centroid's coordinate, in m.
    pub(crate) noise: f64,
}

/// Time, in s, before the command rises from which states are used.
const BEFORE: f64 = 0.05;
/// Least number of states up to contact.
const FEWEST_STATES: usize = 4;
/// Greatest number of states that are used.
const MOST_STATES: usize = 400;
/// Greatest time, in s, from contact to the nearest state: 50 Hz with one missing, and some.
const NEAREST: f64 = 0.05;
/// Time, in s, over which a tip's velocity is taken from its places.
const WAY: f64 = 0.04;
/// Share of the command that an arm must deliver at the least; with less it was not seen to strike.
const LEAST_SHARE: f64 = 0.1;
/// Ratio of a state's speed to the command's from which the state is no measurement.
const IMPLAUSIBLE: f64 = 5.0;

/// What the arm delivered, and how long after its plateau the object was seen to move, in s; `None` where the states do not determine it.
pub(crate) fn delivered(states: &[State], context: &LaunchContext<'_>) -> Option<(Delivered, f64)> {
    let contact = contact(context);
    let start = context.commands.first()?.stamp;
    let moment = since(start, context.first_motion) + contact;
    let timed: Vec<(f64, State)> = states
        .iter()
        .filter(|state| {
            state.velocity.is_finite()
                && state.velocity.norm() < IMPLAUSIBLE * context.command.speed
        })
        .map(|state| (since(start, state.stamp), *state))
        .collect();
    let after = timed.partition_point(|(t, _)| *t <= moment);
    let from = timed.partition_point(|(t, _)| *t < -BEFORE);
    // The first state after contact, too: between it and the last one before lies the moment.
    let before = timed.get(from..(after + 1).min(timed.len()))?;
    let nearest = before
        .iter()
        .map(|(t, _)| (t - moment).abs())
        .fold(f64::INFINITY, f64::min);
    if before.len() < FEWEST_STATES || nearest > NEAREST {
        return None;
    }
    let thinned: Vec<(f64, Point)> = before
        .iter()
        .rev()
        .step_by(before.len().div_ceil(MOST_STATES))
        .map(|(t, state)| (*t, state.velocity))
        .rev()
        .collect();
    let (velocity, late) = velocity_at(&thinned, moment, context);
    let (tip_speed, tip_angle) = (velocity.norm(), velocity.bearing());
    if !velocity.is_finite() || tip_speed < LEAST_SHARE * context.command.speed {
        return None;
    }
    let pushed_again = reaches_again(&timed, moment, velocity, contact, context);
    let delivered = Delivered {
        tip_speed,
        tip_angle,
        contact,
        pushed_again,
    };
    Some((delivered, late))
}

/// By how much (s) the arm's measured speed lies behind the commanded one; `None` where no state of the time shows that speed. Only as far as states
/// are there: half a second before the command, and after what it began.
pub(crate) fn behind(states: &[State], commands: &[Sample]) -> Option<f64> {
    /// Lags that are tried, in s, and the time beside the command in which an arm that follows it rests.
    const FARTHEST: f64 = 1.0;
    const STEP: f64 = 0.004;
    const BESIDE: f64 = 0.1;
    /// Least correlation of both speeds, and least number of states.
    const ALIKE: f64 = 0.97;
    const FEWEST: usize = 6;
    let start = commands.first()?.stamp;
    let lasts = since(start, commands.last()?.stamp);
    let commands = Commands::new(commands);
    let finite = states.iter().filter(|state| state.velocity.is_finite());
    let speeds = finite.map(|state| (since(start, state.stamp), state.velocity.norm()));
    let speeds: Vec<(f64, f64)> = speeds.collect();
    let (first, last) = (speeds.first()?.0, speeds.last()?.0);
    let alike = |lag: f64| -> f64 {
        let (from, to) = (lag - BESIDE, lag + lasts + BESIDE);
        let at = |time: f64| speeds.partition_point(|(t, _)| *t < time);
        let within = &speeds[at(from)..at(to)];
        if within.len() < FEWEST || from < first || to > last {
            return 0.0;
        }
        let (mut product, mut command, mut state) = (0.0, 0.0, 0.0);
        for (t, speed) in within {
            let commanded = commands.at(t - lag).norm();
            product += commanded * speed;
            command += commanded * commanded;
            state += speed * speed;
        }
        product / (command * state).sqrt().max(f64::MIN_POSITIVE)
    };
    let steps = (FARTHEST / STEP) as i32;
    let found: Vec<f64> = (-steps..=steps)
        .map(|i| alike(STEP * f64::from(i)))
        .collect();
    let best = (0..found.len()).max_by(|a, b| found[*a].total_cmp(&found[*b]))?;
    (found[best] > ALIKE).then(|| STEP * (best as f64 - f64::from(steps)))
}

/// Distance, in m, of both centres at a touch: of a box, which may lie anyhow, that in the middle.
pub(crate) fn touching(rig: &Rig) -> f64 {
    let solid = &rig.object.solid;
    0.5 * (solid.reach() + solid.narrowest()) + rig.striker.radius
}

/// Time, in s, from the tip's touch, by its measured places, until the object moved; none where the places do not tell.
pub(crate) fn delay(
    states: &[State],
    context: &LaunchContext<'_>,
    rig: &Rig,
) -> Option<TouchDelay> {
    touch_delay(
        states,
        context.initial,
        (context.first_motion, contact(context)),
        rig,
    )
}

/// The delay of an object at rest at `initial` (m) that began to move so many seconds after a stamp.
pub(crate) fn touch_delay(
    states: &[State],
    initial: Point,
    (stamp, moves): (i64, f64),
    rig: &Rig,
) -> Option<TouchDelay> {
    let reach = touching(rig);
    let places = distances(states, initial, stamp);
    let Touching {
        touch,
        speed: at_touch,
        apart,
    } = touchings(&places, reach).next()?;
    // A reach that is stated wrongly is touched where the tip still speeds up: on its whole way from there it is as fast in the mean.
    let later = places.partition_point(|(t, _)| *t <= moves);
    let here = later
        .checked_sub(1)
        .and_then(|i| Some((places[i], *places.get(later)?)));
    let on_the_way = here.and_then(|((t, one), (next, other))| {
        let far = one + (other - one) * (moves - t) / (next - t) - reach;
        ((moves - touch).abs() > apart).then_some(-far / (moves - touch))
    });
    Some(TouchDelay {
        seconds: moves - touch,
        speed: on_the_way.filter(|speed| *speed > 0.0).unwrap_or(at_touch),
    })
}

/// When a tip came as near to an object as both radii reach.
pub(crate) struct Touching {
    /// Time of it, in s, and the tip's speed towards the object, in m/s.
    pub(crate) touch: f64,
    pub(crate) speed: f64,
    /// Time between the states about it, in s.
    apart: f64,
}

/// Distances (m) of the tip from a place, in time (s) since a stamp.
pub(crate) fn distances<'a>(
    states: impl IntoIterator<Item = &'a State>,
    place: Point,
    stamp: i64,
) -> Vec<(f64, f64)> {
    let placed = states.into_iter().filter(|s| s.position.is_finite());
    let far = placed.map(|s| (since(stamp, s.stamp), s.position.distance(place)));
    far.collect()
}

/// When the tip came nearer than this (m), by its distances.
pub(crate) fn touchings(distances: &[(f64, f64)], reach: f64) -> impl Iterator<Item = Touching> {
    let pairs = distances.windows(2);
    let nearer = pairs.filter(move |pair| pair[0].1 > reach && pair[1].1 <= reach);
    nearer.map(move |pair| {
        let apart = pair[1].0 - pair[0].0;
        let speed = (pair[0].1 - pair[1].1) / apart;
        Touching {
            touch: pair[0].0 + (pair[0].1 - reach) / speed,
            speed,
            apart,
        }
    })
}

/// Where tip and object were when the object began to move, which it did so long after the touch; none where the places do not tell.
pub(crate) fn meeting(
    states: &[State],
    context: &LaunchContext<'_>,
    delay: Option<TouchDelay>,
) -> Option<Meeting> {
    let moment = contact(context);
    let timed = |state: &State| since(context.first_motion, state.stamp) - moment;
    let placed: Vec<&State> = states.iter().filter(|s| s.position.is_finite()).collect();
    let after = placed.partition_point(|state| timed(state) <= 0.0);
    let (last, next) = (*placed.get(after.checked_sub(1)?)?, *placed.get(after)?);
    let (before, later) = (timed(last), timed(next));
    let share = -before / (later - before);
    let between = |one: Point, other: Point| one + (other - one) * share;
    let from = placed.partition_point(|state| timed(state) < before - WAY);
    let (first, went) = (placed[from], before - timed(placed[from]));
    let moved = (last.position - first.position) * (1.0 / went.max(1e-9));
    (later - before <= NEAREST).then(|| Meeting {
        tip: between(last.position, next.position),
        velocity: between(last.velocity, next.velocity),
        moved: (went > 0.5 * WAY).then_some(moved),
        object: context.initial,
        pushed: None,
        earlier: 0.0,
        at: seconds(context.first_motion),
        command: context.command,
        delay: delay.map(|delay| delay.seconds),
        delivered: None,
    })
}

/// The moment of contact in s on the track's clock: where a line through the first frames' distances meets the resting place,
/// but between the last frame at rest and a little after first motion.
fn contact(context: &LaunchContext<'_>) -> f64 {
    /// A slide is straight enough for a line over this time, in s, or over as many frames.
    const LINE: f64 = 0.07;
    const LINE_FRAMES: usize = 4;
    /// The line's end may lie this part of a frame after first motion, which noise may have shown too early.
    const AFTER: f64 = 0.25;
    let track = context.track;
    let count = track
        .t
        .partition_point(|t| *t < LINE)
        .max(LINE_FRAMES)
        .min(track.len());
    let distances: Vec<(f64, f64)> = (0..count)
        .map(|i| (track.t[i], track.point(i).distance(context.initial)))
        .collect();
    let (at_zero, slope) = line(&distances);
    let meets = -at_zero / slope;
    let (low, high) = (-context.gap, AFTER * context.gap);
    if meets.is_finite() && slope > 0.0 {
        meets.clamp(low, high)
    } else {
        0.5 * low
    }
}

/// Value at zero, and slope, of a line through values over times, by least squares.
fn line(points: &[(f64, f64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let mean = |value: fn(&(f64, f64)) -> f64| points.iter().map(value).sum::<f64>() / n;
    let (t, d) = (mean(|point| point.0), mean(|point| point.1));
    let squares: f64 = points.iter().map(|point| (point.0 - t).powi(2)).sum();
    let products = points.iter().map(|point| (point.0 - t) * (point.1 - d));
    let slope = products.sum::<f64>() / squares;
    (d - slope * t, slope)
}

/// The command's profile laid through states: velocity = factor · command(t − delay), the factor a turn and a share.
#[derive(Clone, Copy, Debug)]
struct Profile {
    factor: Point,
    delay: f64,
    /// Sum of squared differences, in m²/s².
    cost: f64,
}

/// Velocity of the tip at contact, in m/s, where the object was seen to move at a moment, and how long after its plateau that was, in s.
fn velocity_at(states: &[(f64, Point)], moment: f64, context: &LaunchContext<'_>) -> (Point, f64) {
    /// A camera is late by no more, in s, without `frames.camera_delay`.
    const LATE: f64 = 0.03;
    /// A residual this many deviations of its noise is a wrong measurement.
    const WRONG: f64 = 6.0;
    /// Size below which residuals are the rounding of a logged number.
    const ROUNDING: f64 = 1e-6;
    let commands = Commands::new(context.commands);
    let residuals = |profile: &Profile, states: &[(f64, Point)]| -> Vec<(f64, Point)> {
        states
            .iter()
            .map(|(t, v)| (*t, *v - profile.at(&commands, *t)))
            .collect()
    };
    let first = Profile::through(states, &commands);
    let deviation = 1.4826 * median(residuals(&first, states).iter().map(|(_, e)| e.norm()));
    let most = WRONG * deviation + ROUNDING;
    let kept: Vec<(f64, Point)> = states
        .iter()
        .zip(residuals(&first, states))
        .filter(|(_, (_, e))| e.norm() <= most)
        .map(|(state, _)| *state)
        .collect();
    let profile = if kept.len() >= FEWEST_STATES && kept.len() < states.len() {
        Profile::through(&kept, &commands)
    } else {
        first
    };
    let states = if kept.len() >= FEWEST_STATES {
        &kept[..]
    } else {
        states
    };
    let late = (moment - commands.plateau_end - profile.delay).max(0.0);
    let contact = moment - late.min(LATE);
    let beside = correction(&residuals(&profile, states), contact);
    (profile.at(&commands, contact) + beside, late)
}

impl Profile {
    /// The best delay and factor.
    fn through(states: &[(f64, Point)], commands: &Commands) -> Self {
        /// Delays that are tried, in s.
        const EARLIEST: f64 = -0.02;
        const STEP: f64 = 0.002;
        const STEPS: i32 = 85;
        let fits: Vec<Self> = (0..STEPS)
            .map(|i| Self::with_delay(states, commands, EARLIEST + STEP * f64::from(i)))
            .collect();
        let best = (0..fits.len())
            .min_by(|a, b| fits[*a].cost.total_cmp(&fits[*b].cost))
            .unwrap_or(0);
        if best == 0 || best + 1 == fits.len() {
            return fits[best];
        }
        // The vertex of the parabola through the best and its neighbours.
        let [before, here, after] = [best - 1, best, best + 1].map(|i| fits[i].cost);
        let bend = before - 2.0 * here + after;
        if bend <= 0.0 {
            return fits[best];
        }
        let shift = 0.5 * STEP * (before - after) / bend;
        let refined = Self::with_delay(states, commands, fits[best].delay + shift);
        if refined.cost < here {
            refined
        } else {
            fits[best]
        }
    }

    /// Least squares for the factor, at one delay.
    fn with_delay(states: &[(f64, Point)], commands: &Commands, delay: f64) -> Self {
        let pairs = || states.iter().map(|(t, v)| (commands.at(t - delay), *v));
        let (mut product, mut power) = (Point::default(), 0.0);
        for (command, velocity) in pairs() {
            product = product + times(velocity, conjugate(command));
            power += command.dot(command);
        }
        let factor = if power > 0.0 {
            product * (1.0 / power)
        } else {
            Point::default()
        };
        let cost = pairs()
            .map(|(command, velocity)| {
                let e = velocity - times(factor, command);
                e.dot(e)
            })
            .sum();
        Self {
            factor,
            delay,
            cost,
        }
    }

    fn at(&self, commands: &Commands, t: f64) -> Point {
        times(self.factor, commands.at(t - self.delay))
    }
}

/// Correction of the velocity at a moment from the residuals near it: a line through them where they stand out of their noise, nothing where they do
/// not (James and Stein's positive part, of a vector with two components).
fn correction(residuals: &[(f64, Point)], moment: f64) -> Point {
    /// Half the time over which residuals are used, in s, and in intervals between states.
    const WINDOW: f64 = 0.015;
    const WINDOW_STATES: f64 = 3.0;
    /// Median length of a vector of two normal components, in deviations of one: √(2 ln 2).
    const MEDIAN_LENGTH: f64 = 1.177_41;
    let pairs = || residuals.windows(2);
    let interval = median(pairs().map(|pair| pair[1].0 - pair[0].0));
    // Noise of a component, from one residual to the next.
    let steps = pairs().map(|pair| pair[1].1.distance(pair[0].1));
    let noise = median(steps) / (MEDIAN_LENGTH * 2f64.sqrt());
    let window = WINDOW.max(WINDOW_STATES * interval);
    let near: Vec<(f64, f64, Point)> = residuals
        .iter()
        .map(|(t, e)| (t - moment, *e))
        .map(|(t, e)| (1.0 - t.abs() / window, t, e))
        .filter(|(weight, ..)| *weight > 0.0)
        .collect();
    let sum = |of: &dyn Fn(f64, f64) -> f64| near.iter().map(|(w, t, _)| of(*w, *t)).sum::<f64>();
    let (w0, w1, w2) = (sum(&|w, _| w), sum(&|w, t| w * t), sum(&|w, t| w * t * t));
    let determinant = w0 * w2 - w1 * w1;
    // Weights of a line's value at the moment; of a mean, where there is no line.
    let weight = |w: f64, t: f64| {
        if near.len() > 2 && determinant > 1e-12 * w0 * w2 {
            w * (w2 - w1 * t) / determinant
        } else {
            w / w0
        }
    };
    let value = near
        .iter()
        .fold(Point::default(), |sum, (w, t, e)| sum + *e * weight(*w, *t));
    let variance = noise
        * noise
        * near
            .iter()
            .map(|(w, t, _)| weight(*w, *t).powi(2))
            .sum::<f64>();
    let length = value.dot(value);
    if length.is_nan() || length <= 2.0 * variance {
        return Point::default();
    }
    value * (1.0 - 2.0 * variance / length)
}

/// The tip is at the object within this, in m and in deviations of the camera's noise.
const REACH: f64 = 0.002;
const REACH_NOISE: f64 = 4.0;

/// Whether an arm whose state is not known went on pushing an object that came to rest there, by its command: the object was where the tip
/// was commanded to be when the plateau ended, and its slide since, followed back to the contact, would have begun behind its place.
pub(crate) fn pushes_on(context: &LaunchContext<'_>, stop: Point) -> bool {
    /// Part of the way commanded after contact by which an arm that delivers its command may be elsewhere. Of another arm it tells nothing.
    const NEAR: f64 = 0.03;
    /// A push leads a slide ahead of a free one by what it would have been braked by meanwhile; by these parts of it, as friction is even by half.
    const AHEAD: std::ops::Range<f64> = 0.5..2.0;
    /// Frames during the push, and of the slide after it, at the least; and part of the whole way up to which it slides.
    const PUSHED: usize = 2;
    const SLIDES: usize = 3;
    const GOES: f64 = 0.9;
    let Some(first) = context.commands.first() else {
        return false;
    };
    let contact = contact(context);
    let moment = since(first.stamp, context.first_motion) + contact;
    let pushed_for = Commands::new(context.commands).plateau_end - moment;
    let command = context.command;
    let ahead = Point::new(command.angle.cos(), command.angle.sin());
    let gone = |place: Point| (place - context.initial).dot(ahead);
    let whole = gone(stop);
    let frames = (0..context.track.len())
        .map(|i| (context.track.t[i] - contact, gone(context.track.point(i))));
    let (pushed, after): (Vec<_>, Vec<_>) = frames
        .filter(|(t, _)| *t >= 0.0)
        .partition(|(t, _)| *t <= pushed_for);
    // Under even braking the root of the way that is left falls evenly.
    let left: Vec<(f64, f64)> = after
        .into_iter()
        .filter(|(_, gone)| *gone < GOES * whole)
        .map(|(t, gone)| (t, (whole - gone).sqrt()))
        .collect();
    let Some(last) = pushed.last() else {
        return false;
    };
    if pushed.len() < PUSHED || left.len() < SLIDES {
        return false;
    }
    let (root, slope) = line(&left);
    let braked = slope.powi(2) * pushed_for.powi(2);
    let led = root.powi(2) - whole;
    let reach = REACH + REACH_NOISE * context.noise;
    let tip = command.speed * last.0;
    (last.1 - tip).abs() < reach + NEAR * tip
        && slope < 0.0
        && braked.min(led) > reach
        && AHEAD.contains(&(led / braked))
}

/// Whether the tip was at the object again, or still, when an impact is long over, and went on.
fn reaches_again(
    states: &[(f64, State)],
    moment: f64,
    velocity: Point,
    contact: f64,
    context: &LaunchContext<'_>,
) -> bool {
    /// Time, in s, after which an impact is over.
    const BLOW: f64 = 0.1;
    /// Share of its speed at contact below which an arm pushes no more.
    const PUSHES: f64 = 0.3;
    /// Number of frames in a row that show it.
    const FRAMES: usize = 3;
    let ahead = velocity * (1.0 / velocity.norm());
    let path = tip_path(states, moment, ahead);
    let reach = REACH + REACH_NOISE * context.noise;
    let track = context.track;
    let mut run = 0;
    for frame in 0..track.len() {
        let after = track.t[frame] - contact;
        let Some((tip, speed)) = path_at(&path, moment + after) else {
            continue;
        };
        let object = (track.point(frame) - context.initial).dot(ahead);
        let is_at_it = after > BLOW && object - tip < reach && speed > PUSHES * velocity.norm();
        run = if is_at_it { run + 1 } else { 0 };
        if run >= FRAMES {
            return true;
        }
    }
    false
}

/// How far the tip went ahead since contact, in m, and how fast it went ahead, at each state: by its positions, or where they were
/// not logged by its velocities.
fn tip_path(states: &[(f64, State)], moment: f64, ahead: Point) -> Vec<(f64, f64, f64)> {
    let has_positions = states.iter().all(|(_, state)| state.position.is_finite());
    let mut gone = 0.0;
    let mut path: Vec<(f64, f64, f64)> = Vec::with_capacity(states.len());
    for (t, state) in states {
        let speed = state.velocity.dot(ahead);
        if has_positions {
            gone = state.position.dot(ahead);
        } else if let Some((before, _, slower)) = path.last() {
            gone += 0.5 * (speed + slower) * (t - before);
        }
        path.push((*t, gone, speed));
    }
    let at_contact = path_at(&path, moment).map_or(0.0, |(gone, _)| gone);
    path.iter()
        .map(|(t, gone, speed)| (*t, gone - at_contact, *speed))
        .collect()
}

/// Place and speed at a time between two states.
fn path_at(path: &[(f64, f64, f64)], t: f64) -> Option<(f64, f64)> {
    let after = path.partition_point(|(at, ..)| *at <= t);
    let (from, to) = (path.get(after.checked_sub(1)?)?, path.get(after)?);
    let part = (t - from.0) / (to.0 - from.0);
    Some((
        from.1 + part * (to.1 - from.1),
        from.2 + part * (to.2 - from.2),
    ))
}

/// The commands of a strike as a function of time since the first, in s: lines between them, zero outside. Ramps go on to the plateau: a line
/// from the last command of a ramp to the first of the plateau would cut its corner, and of a plateau of one command most of it.
struct Commands {
    points: Vec<(f64, Point)>,
    /// Time, in s, of the last command of the plateau.
    plateau_end: f64,
}

impl Commands {
    fn new(commands: &[Sample]) -> Self {
        /// Commands of a plateau differ by no more than this part, by rounding.
        const ALIKE: f64 = 0.002;
        let start = commands.first().map_or(0, |command| command.stamp);
        let timed = commands.iter().map(|command| {
            (
                since(start, command.stamp),
                Point::new(command.x, command.y),
            )
        });
        let mut points: Vec<(f64, Point)> = timed.collect();
        let most = points.iter().map(|(_, v)| v.norm()).fold(0.0, f64::max);
        let is_on = |(_, v): &(f64, Point)| v.norm() >= (1.0 - ALIKE) * most;
        let ends = points
            .iter()
            .position(is_on)
            .zip(points.iter().rposition(is_on));
        let Some((first, last)) = ends else {
            return Self {
                points,
                plateau_end: 0.0,
            };
        };
        let plateau_end = points[last].0;
        // Where the ramp through two commands beside the plateau meets it, which lies between the nearer one and the plateau's own.
        let corner = |far: usize, near: usize, on: usize| {
            let ((t_far, far), (t_near, near), (t_on, on)) =
                (points[far], points[near], points[on]);
            let slope = (near.norm() - far.norm()) / (t_near - t_far);
            let t = t_near + (on.norm() - near.norm()) / slope;
            (t.is_finite() && (t - t_near) * (t_on - t) > 0.0).then_some((t, on))
        };
        let rise = (first >= 2)
            .then(|| corner(first - 2, first - 1, first))
            .flatten();
        let fall = (last + 2 < points.len())
            .then(|| corner(last + 2, last + 1, last))
            .flatten();
        points.extend(rise);
        points.extend(fall);
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self {
            points,
            plateau_end,
        }
    }

    fn at(&self, t: f64) -> Point {
        let after = self.points.partition_point(|(at, _)| *at <= t);
        match (after.checked_sub(1), self.points.get(after)) {
            (Some(before), Some((t_next, next))) => {
                let (t_last, last) = self.points[before];
                last + (*next - last) * ((t - t_last) / (t_next - t_last))
            }
            (Some(before), None) if self.points[before].0 >= t => self.points[before].1,
            _ => Point::default(),
        }
    }
}

/// Product of two vectors as complex numbers: a turn and a share of the second by the first.
fn times(a: Point, b: Point) -> Point {
    Point::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x)
}

fn conjugate(a: Point) -> Point {
    Point::new(a.x, -a.y)
}

#[cfg(test)]
mod tests;
