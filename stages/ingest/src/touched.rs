//! Strikes by the tip's touch: flights that it began, on an object that moved before or rested.
//!
//! Round bodies push one another along the line of their centres, by the part of their relative velocity that lies along it. So the
//! command of such a strike is that part, its angle that line's, both by the tip's measured state; what the object had before stays
//! with it ([`values::Conditions::moving`]). A box is pushed in the direction of the relative velocity.

use logs::Sample;
use values::{Command, Delivered, End, Point, RejectReason, Rig, Shape, Track};

use crate::arm::{Meeting, TouchDelay, touch_delay};
use crate::bounces::{Break, FRAMES, Flight, TIME, Touch};
use crate::order::{seconds, since};
use crate::rejection::{Detail, Rejection};
use crate::robust::{mean_near_median, median, median_point};
use crate::slide::{Frame, held, held_until, is_rest, outliers, reaches_fence};

/// Least number of frames of a track.
const FEWEST: usize = 8;
/// Motion (m) beside noise, in the time before (s), below which an object rests: its strikes are found from rest to rest.
const RESTS: f64 = 0.0025;
const BEFORE: f64 = 0.3;
/// Distance aside, in parts of both radii, beyond which a tip that meets an object only grazes it.
const GRAZES: f64 = 0.85;
/// Least part of its unbraked way that a sliding object goes: a constant brake leaves half of it.
const SLIDES: f64 = 0.25;
/// Time, in s, before the end of a slide in which what ends it may have taken hold of the object.
const HOLD: f64 = 0.03;
/// Time, in s, in which a rest is seen, and the distance from one place that it allows, in deviations of the camera's noise.
const REST: f64 = 0.25;
const REST_NOISE: f64 = 4.0;

/// A strike that a touch showed.
#[derive(Debug)]
pub(crate) struct TouchedStrike {
    pub(crate) command: Command,
    /// Velocity of the object before the touch, in m/s; none where it rested.
    pub(crate) moving: Option<Point>,
    /// Velocity that the touch added, in m/s.
    pub(crate) launch: Point,
    pub(crate) initial: Point,
    pub(crate) stop: Point,
    pub(crate) track: Track,
    /// Stamp of its first frame, in ns.
    pub(crate) first: i64,
    /// Time from the impact to the first frame, in s.
    pub(crate) gap: f64,
}

impl TouchedStrike {
    /// What the tip delivered along the line on which it pushes.
    pub(crate) fn delivered(&self) -> Delivered {
        Delivered {
            tip_speed: self.command.speed,
            tip_angle: self.command.angle,
            contact: -self.gap,
            pushed_again: false,
        }
    }
}

/// A flight that the tip began, and the frames before it.
pub(crate) struct TouchedFlight {
    /// Index in the log.
    pub(crate) index: u32,
    pub(crate) flight: Flight,
    pub(crate) before: Vec<Sample>,
    pub(crate) begun: Break,
    pub(crate) touch: Touch,
}

impl TouchedFlight {
    /// The last of the frames before, for as long as rest is looked for.
    pub(crate) fn last_of(before: &[Sample]) -> Vec<Sample> {
        let Some(last) = before.last() else {
            return Vec::new();
        };
        let from = before.partition_point(|frame| since(frame.stamp, last.stamp) > BEFORE);
        before[from..].to_vec()
    }

    /// Delay of the camera behind the tip's measured place. Of an object that moved the place of the impact is known as well, a little worse; a tip
    /// that hardly came nearer then tells no time.
    pub(crate) fn delay(&self, rig: &Rig) -> Option<TouchDelay> {
        /// Least speed of the tip towards the object, in m/s.
        const NEARS: f64 = 0.2;
        let place = rested(&self.before, rig.camera.noise).unwrap_or(self.begun.bounce.place);
        let delay = touch_delay(&self.touch.states, place, (self.begun.stamp, 0.0), rig)?;
        (delay.speed > NEARS).then_some(delay)
    }

    /// Where tip and object met, of round bodies, which push one another along the line of their centres; the camera's stamps lie so far behind the
    /// tip's, in s.
    pub(crate) fn meeting(
        &self,
        camera_delay: f64,
        found: &TouchedStrike,
        rig: &Rig,
    ) -> Option<Meeting> {
        let touch = self.touch.earlier(self.begun.stamp, camera_delay);
        (found.launch.norm() > 0.0).then(|| Meeting {
            tip: touch.position,
            velocity: touch.velocity,
            moved: None,
            object: found.initial,
            pushed: Some(found.launch * (1.0 / found.launch.norm())),
            earlier: camera_delay,
            at: seconds(self.begun.stamp),
            command: found.command,
            delay: self.delay(rig).map(|delay| delay.seconds),
            delivered: None,
        })
    }
}

/// By how much (s) the camera's stamps lie behind the tip's, where these touches surely show that they do.
pub(crate) fn camera_delay(delays: &[TouchDelay]) -> Option<f64> {
    /// Least number of touches that tell a delay, least delay in s, and its least size in standard errors.
    const FEWEST_TOUCHES: usize = 6;
    const LEAST: f64 = 0.003;
    const SURE: f64 = 3.0;
    let seconds = || {
        delays
            .iter()
            .map(|delay| delay.seconds)
            .filter(|s| s.is_finite())
    };
    let middle = median(seconds());
    let spread = 1.4826 * median(seconds().map(|s| (s - middle).abs()));
    let error = 1.2533 * spread / (delays.len() as f64).sqrt();
    let is_sure = delays.len() >= FEWEST_TOUCHES && middle.abs() > (SURE * error).max(LEAST);
    is_sure.then_some(middle)
}

/// The touches that tell one delay, of all that were about the moments at which objects were pushed, where that is too long for touches to be
/// seen at their time.
pub(crate) fn far_away(touches: &[TouchDelay]) -> Option<Vec<TouchDelay>> {
    /// Time, in s, within which touches tell one delay, and the delay from which the tip is no longer where it touched.
    const ONE: f64 = 0.04;
    const LONG: f64 = 0.03;
    const FEWEST_TOUCHES: usize = 6;
    let mut touches = touches.to_vec();
    touches.sort_by(|one, other| one.seconds.total_cmp(&other.seconds));
    let until = |from: usize| touches.partition_point(|t| t.seconds < touches[from].seconds + ONE);
    let from = (0..touches.len()).max_by_key(|from| until(*from) - from)?;
    let together = &touches[from..until(from)];
    let is_far = median(together.iter().map(|touch| touch.seconds)).abs() > LONG;
    let is_most = together.len() >= FEWEST_TOUCHES && 2 * together.len() > touches.len();
    (is_far && is_most).then(|| together.to_vec())
}

/// Where the object rested before, if it did: `before` are the frames that came before the impact. A frame or two show no rest.
fn rested(before: &[Sample], noise: f64) -> Option<Point> {
    let (first, last) = (before.first()?, before.last()?);
    if before.len() < FRAMES || since(first.stamp, last.stamp) < TIME {
        return None;
    }
    let points: Vec<Point> = TouchedFlight::last_of(before).iter().map(place).collect();
    let third = points.len().div_ceil(3);
    let drift =
        median_point(&points[..third]).distance(median_point(&points[points.len() - third..]));
    (drift <= RESTS + noise).then(|| mean_near_median(&points, REST_NOISE * noise))
}

pub(crate) fn place(frame: &Sample) -> Point {
    Point::new(frame.x, frame.y)
}

/// The strike of a flight that the tip began; the camera's stamps lie so far behind the tip's, in s.
pub(crate) fn strike(
    touched: &TouchedFlight,
    camera_delay: f64,
    rig: &Rig,
) -> Result<TouchedStrike, Rejection> {
    let TouchedFlight {
        flight,
        before,
        begun,
        touch,
        ..
    } = touched;
    let touch = &touch.earlier(begun.stamp, camera_delay);
    let rest = rested(before, rig.camera.noise);
    let initial = rest.unwrap_or(begun.bounce.place);
    let moving = match rest {
        Some(_) => None,
        None => Some(begun.bounce.before),
    };
    let command = command(touch, initial, moving.unwrap_or_default(), rig)?;
    let cleaned = without_outliers(&flight.frames, rig.camera.noise);
    let (frames, end, stop) = seen(&cleaned, flight.is_broken, rig);
    if frames.len() < FEWEST {
        let frames = frames.len();
        let detail = Detail::EndsAfterImpact { frames };
        return Err(Rejection::new(RejectReason::NoRestAfter, detail));
    }
    let (first, last) = (&frames[0], &frames[frames.len() - 1]);
    let gone = place(first).distance(place(last));
    let freely = begun.bounce.after.norm() * since(first.stamp, last.stamp);
    if end != End::Rest && gone < SLIDES * freely {
        let detail = Detail::HeldOrPushed {
            gone,
            unbraked: freely,
        };
        return Err(Rejection::new(RejectReason::NoRestAfter, detail));
    }
    let first = first.stamp;
    let track = Track {
        t: frames
            .iter()
            .map(|frame| since(first, frame.stamp))
            .collect(),
        x: frames.iter().map(|frame| frame.x).collect(),
        y: frames.iter().map(|frame| frame.y).collect(),
        yaw: None,
        end,
    };
    Ok(TouchedStrike {
        command,
        moving,
        launch: begun.bounce.after - moving.unwrap_or_default(),
        initial,
        stop: stop.unwrap_or_else(|| track.point(track.len() - 1)),
        track,
        first,
        gap: since(begun.stamp, first),
    })
}

/// The tip's velocity beside the object's, along the line on which it pushes.
pub(crate) fn command(
    touch: &Touch,
    initial: Point,
    moving: Point,
    rig: &Rig,
) -> Result<Command, Rejection> {
    let relative = touch.velocity - moving;
    let speed = relative.norm();
    let along = relative * (1.0 / speed.max(1e-12));
    let across = Point::new(-along.y, along.x);
    let reach = rig.object.solid.reach() + rig.striker.radius;
    let aside = match rig.object.shape() {
        Shape::Box => 0.0,
        Shape::Cylinder | Shape::Sphere => (initial - touch.position).dot(across) / reach,
    };
    if speed <= 0.0 || aside.abs() > GRAZES {
        let aside = aside * reach;
        let detail = Detail::Grazed { aside, speed };
        return Err(Rejection::new(RejectReason::NoMotion, detail));
    }
    Ok(Command::new(
        speed * (1.0 - aside * aside).sqrt(),
        along.rotated(aside.asin()).bearing(),
    ))
}

/// The frames that are the slide's, what ends them, and where it rests if it does.
pub(crate) fn seen<'a>(
    all: &'a [Sample],
    is_broken: bool,
    rig: &Rig,
) -> (&'a [Sample], End, Option<Point>) {
    let off = all
        .iter()
        .position(|frame| !rig.table.contains(place(frame)))
        .map(|at| (at, End::LeftView));
    let met = (0..all.len())
        .find(|at| {
            let seen = |at: usize| (since(all[0].stamp, all[at].stamp), place(&all[at]));
            let before = [at.checked_sub(2), at.checked_sub(1)];
            reaches_fence(rig, before.map(|i| i.map(seen)), seen(*at))
        })
        .map(|at| (at, End::Contact));
    let ended = match (is_broken, all.last()) {
        (true, Some(last)) => {
            // A hand takes hold before the velocity breaks.
            let held = |frame: &Sample| since(frame.stamp, last.stamp) > HOLD;
            (all.partition_point(held), End::Contact)
        }
        _ => (all.len(), End::LeftView),
    };
    let rests = rests(all, rig.camera.noise);
    let rest = rests.map(|(at, _)| (at, End::Rest));
    let slide = in_time(all);
    let until = rests.map_or(slide.len(), |(at, _)| held_until(&slide, at));
    let held = held(&slide[..until], rig.object.shape()).map(|at| (at, End::Contact));
    let (at, end) = [off, met, rest, held]
        .into_iter()
        .flatten()
        .fold(
            ended,
            |first, other| if other.0 < first.0 { other } else { first },
        );
    let stop = rests.filter(|_| end == End::Rest).map(|(_, stop)| stop);
    (&all[..at], end, stop)
}

/// Frames in time since the first one.
fn in_time(frames: &[Sample]) -> Vec<Frame> {
    let start = frames.first().map_or(0, |first| first.stamp);
    frames.iter().map(|s| Frame::of(s, start)).collect()
}

/// The frames but those that jump away for one frame, and those that repeat the one before while the object moves.
pub(crate) fn without_outliers(frames: &[Sample], noise: f64) -> Vec<Sample> {
    let marked = outliers(&in_time(frames), noise);
    let kept = frames.iter().zip(marked).filter(|(_, is_one)| !is_one);
    kept.map(|(frame, _)| *frame).collect()
}

/// Index of the frame from which on the object rests, and the place, in m; none where it does not.
fn rests(frames: &[Sample], noise: f64) -> Option<(usize, Point)> {
    (0..frames.len()).step_by(2).find_map(|from| {
        let until = from
            + frames[from..].partition_point(|frame| since(frames[from].stamp, frame.stamp) < REST);
        if until == frames.len() || until < from + 4 {
            return None;
        }
        let points: Vec<Point> = frames[from..until].iter().map(place).collect();
        is_rest(&points, REST_NOISE * noise, noise).then(|| (from, median_point(&points)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn touches_that_lie_together_tell_a_delay_and_others_none() {
        let touches = |late: f64, others: usize| -> Vec<TouchDelay> {
            let touch = |seconds| TouchDelay {
                seconds,
                speed: 0.6,
            };
            let together = (0..20).map(|i| touch(late + 0.003 * f64::from(i).sin()));
            let apart = (0..others).map(|i| touch(-0.5 + (0.618 * i as f64).fract()));
            together.chain(apart).collect()
        };
        for late in [-0.1, 0.06, 0.2] {
            let found = far_away(&touches(late, 8)).expect("a delay");
            let middle = median(found.iter().map(|touch| touch.seconds));
            assert!((middle - late).abs() < 0.005, "{late}: {middle}");
        }
        assert_eq!(far_away(&touches(0.02, 8)), None);
        assert_eq!(far_away(&touches(0.06, 60)), None);
        assert_eq!(far_away(&[]), None);
    }
}
