//! Strikes on an object that moves: a flight that the tip's touch began.
//!
//! Round bodies push one another along the line of their centres, by the part of their relative velocity that lies along it. So the
//! command of such a strike is that part, its angle that line's, both by the tip's measured state; what the object had before stays
//! with it ([`values::Conditions::moving`]). A box is pushed in the direction of the relative velocity.

use logs::Sample;
use values::{Command, End, Point, RejectReason, Rig, Shape, Track};

use crate::bounces::{Break, Flight, Touch};
use crate::rejection::Rejection;
use crate::robust::median_point;
use crate::slide::{is_rest, reaches_fence};
use crate::time::since;

/// A track needs as many frames.
const FEWEST: usize = 8;
/// An object that moves less than this (m) beside noise in the time before (s) rests: its strikes are found from rest to rest.
const RESTS: f64 = 0.0025;
const BEFORE: f64 = 0.3;
/// A tip that meets an object farther aside, in parts of both radii, only grazes it.
const GRAZES: f64 = 0.85;
/// Rest is seen in this time, in s, and this near to one place, in deviations of the camera's noise.
const REST: f64 = 0.25;
const REST_NOISE: f64 = 4.0;

/// A strike on an object that moves.
#[derive(Debug)]
pub(crate) struct MovingStrike {
    pub(crate) command: Command,
    /// The object's velocity before, in m/s.
    pub(crate) moving: Point,
    pub(crate) initial: Point,
    pub(crate) stop: Point,
    pub(crate) track: Track,
    /// Stamp of its first frame, in ns.
    pub(crate) first: i64,
    /// Seconds from the impact to it.
    pub(crate) gap: f64,
}

/// Whether the object rested before: `before` are the frames that came before the impact.
pub(crate) fn rested(before: &[Sample], noise: f64) -> bool {
    let Some(last) = before.last() else {
        return false;
    };
    let from = before.partition_point(|frame| since(frame.stamp, last.stamp) > BEFORE);
    let points: Vec<Point> = before[from..].iter().map(place).collect();
    let third = points.len().div_ceil(3);
    let drift =
        median_point(&points[..third]).distance(median_point(&points[points.len() - third..]));
    drift <= RESTS + noise
}

fn place(frame: &Sample) -> Point {
    Point::new(frame.x, frame.y)
}

/// The strike of a flight that the tip began.
pub(crate) fn strike(
    flight: &Flight,
    begun: &Break,
    touch: &Touch,
    rig: &Rig,
) -> Result<MovingStrike, Rejection> {
    let initial = begun.bounce.place;
    let moving = begun.bounce.before;
    let command = command(touch, initial, moving, rig)?;
    let (frames, end, stop) = seen(flight, rig);
    if frames.len() < FEWEST {
        let detail = format!(
            "{} frames after the impact the object meets something, or is seen no more: too few to tell anything",
            frames.len()
        );
        return Err(Rejection::new(RejectReason::NoRestAfter, detail));
    }
    let first = frames[0].stamp;
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
    Ok(MovingStrike {
        command,
        moving,
        initial,
        stop: stop.unwrap_or_else(|| track.point(track.len() - 1)),
        track,
        first,
        gap: since(begun.stamp, first),
    })
}

/// The tip's velocity beside the object's, along the line on which it pushes.
fn command(touch: &Touch, initial: Point, moving: Point, rig: &Rig) -> Result<Command, Rejection> {
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
        let detail = format!(
            "the tip meets the moving object {:.0} mm beside its centre, at {speed:.2} m/s: it only grazes it",
            1e3 * aside * reach
        );
        return Err(Rejection::new(RejectReason::NoMotion, detail));
    }
    Ok(Command {
        speed: speed * (1.0 - aside * aside).sqrt(),
        angle: along.rotated(aside.asin()).bearing(),
    })
}

/// The frames that are the slide's, what ends them, and where it rests if it does.
fn seen<'a>(flight: &'a Flight, rig: &Rig) -> (&'a [Sample], End, Option<Point>) {
    let all = &flight.frames[..];
    let off = all
        .iter()
        .position(|frame| !rig.table.contains(place(frame)))
        .map(|at| (at, End::LeftView));
    let met = (0..all.len())
        .find(|at| {
            let before = [at.checked_sub(2), at.checked_sub(1)];
            reaches_fence(
                rig,
                before.map(|i| i.map(|i| place(&all[i]))),
                place(&all[*at]),
            )
        })
        .map(|at| (at, End::Contact));
    let ended = match flight.is_broken {
        true => (all.len(), End::Contact),
        false => (all.len(), End::LeftView),
    };
    let rests = rests(all, rig.camera.noise);
    let rest = rests.map(|(at, _)| (at, End::Rest));
    let (at, end) = [off, met, rest]
        .into_iter()
        .flatten()
        .fold(
            ended,
            |first, other| if other.0 < first.0 { other } else { first },
        );
    let stop = rests.filter(|_| end == End::Rest).map(|(_, stop)| stop);
    (&all[..at], end, stop)
}

/// From which frame on it rests, and where.
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
