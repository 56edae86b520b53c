//! From rest to rest: when an object begins to move, and where it first comes to rest.
//!
//! - *Rest before*: the frames of the half second before the command rises lie within noise of one place.
//! - *First motion*: the first frame that is surely away (8 noise deviations or 5 mm, and stays so) is followed back to the
//!   first frame that left the level of the frames right before it; where a line through the frames that follow meets
//!   that level yet earlier, a frame that lies between counts too. The track's zero is the stamp of that frame: the
//!   impact lies between the frame before and it.
//! - *First rest*: the first quarter second whose frames lie within noise of one place and do not drift; what comes later,
//!   such as a hand that puts the object back, is never looked at.
//! - *Other ends*: a slide that meets a fence or a hand on its way, or leaves the table, is a track up to there, without a stop.

mod contact;
mod frames;
mod held;
mod motion;
mod pushed;
mod rest;
mod stopped;
mod tolerances;

use logs::Sample;
use values::{End, Point, RejectReason, Track};

pub(crate) use self::contact::reaches_fence;
pub(crate) use self::frames::{Frame, Frames, outliers};
pub(crate) use self::held::{held, held_until};
use self::motion::first_motion;
pub(crate) use self::rest::{NOISIER, is_rest, lies_still};
use self::rest::{initial, rest_after, rest_before};
pub(crate) use self::stopped::stood;
use self::tolerances::{FRAMES_AFTER, GAP_LATER, REST_BEFORE, SURELY_AWAY_NOISE};
use crate::bounces::{Bounce, turned_round};
use crate::grazes::graze;
use crate::lost::is_jump;
use crate::order::since;
use crate::rejection::{Detail, Rejection};

/// Ratio of a frame's speed to the slide's first from which it is another's doing: a slide only slows down.
const FASTER: f64 = 2.0;
/// Frames in which a slide is fastest: contact may last for some.
const BEGINNING: usize = 10;
/// Time, in s, after its command fell back and the object began to move by which the arm has let go of it.
const LETS_GO: f64 = 0.1;
/// Least number of frames of a track that does not end at rest.
pub(crate) const FEWEST_CENSORED: usize = 8;
/// Greatest share of a slide's frames that may be missing.
const MOST_MISSING: f64 = 0.6;

/// What the centroids around one command show.
#[derive(Debug)]
pub(crate) struct Slide {
    /// Stamp of the first frame in motion, in ns.
    pub(crate) first_motion: i64,
    pub(crate) initial: Point,
    pub(crate) stop: Point,
    pub(crate) track: Track,
    /// Frames that jumped away and back, left out of the track.
    pub(crate) outliers: usize,
    /// What led the object along, or turned it aside, on its way; none where nothing did.
    pub(crate) grazed: Option<Bounce>,
    /// Seconds from the frame before first motion to it.
    pub(crate) gap: f64,
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
        // Off the table, it left: its track ends before.
        (Ok(found), Some(_)) if found.slide.track.end == End::LeftView => Ok(found.slide),
        // A cause that explains the other.
        (_, Some(unusable)) => Err(unusable),
    }
}

struct StrikeSummary {
    slide: Slide,
    /// Time of the last frame that was used, in s.
    end: f64,
}

fn find_among(frames: &Frames<'_>) -> Result<StrikeSummary, Rejection> {
    let rest = rest_before(frames)?;
    let first = first_motion(frames, &rest)?;
    let initial = initial(frames, &rest, first)?;
    let rested = rest_after(frames, &rest, first);
    let until = rested
        .as_ref()
        .map_or(frames.frames.len(), |(arrival, ..)| *arrival);
    // What comes to rest at a fence has touched it.
    let rests = rested.as_ref().map_or(until, |(arrival, _, last)| {
        (arrival + FRAMES_AFTER).min(*last)
    });
    let met = contact::met(frames, first, rests).map(|end| (end, End::Contact));
    let left = frames.left_table(first, until);
    // What is seen no more for so long went somewhere.
    let lost = (first + FEWEST_CENSORED..until).find(|at| is_lost_before(frames, *at));
    let left = left.into_iter().chain(lost).map(|end| (end, End::LeftView));
    // An impact may last for some frames. What creeps on until it is taken away was never seen to slide to a rest.
    let is_whole = rested
        .as_ref()
        .is_ok_and(|(arrival, ..)| carried(frames, first, *arrival, rest.noise).is_ok());
    let slides = (first + BEGINNING).min(until);
    let looked_at = &frames.frames[slides..held_until(&frames.frames, until)];
    let shape = frames.rig.object.shape();
    let held = held(looked_at, shape).map(|at| slides + at);
    let turned = turned(frames, first, until, rest.noise);
    let stopped = |rest_at: usize, stop: Point| {
        let all = &frames.frames[first..];
        let at = stopped::stopped(all, rest_at - first, stop, rest.noise, shape)?;
        Some(first + at)
    };
    let caught = rested.as_ref().ok();
    let caught = caught.and_then(|(arrival, stop, _)| stopped(*arrival, *stop));
    // A hand may hold it for a moment only.
    let carried_on = stopped::carried_on(&frames.frames[first..until]);
    let carried_on =
        carried_on.map(|(at, stands)| stopped(first + at, stands).unwrap_or(first + at));
    let let_go = frames.frames[first].t.max(frames.fall) + LETS_GO;
    let let_go = frames.at(let_go).clamp(first, until);
    let sliding = &frames.frames[let_go..until];
    let ahead = sliding.first().map_or(initial, |frame| frame.point) - initial;
    let pushed = pushed::pushed(sliding, ahead, rest.noise, shape).map(|push| {
        let at = let_go + push.at;
        // A hand may have held it before.
        let held = push.stands.and_then(|stands| stopped(at, stands));
        held.unwrap_or(at)
    });
    let by_hand = |at: usize| is_whole.then_some((at, End::Contact));
    let taken = held
        .into_iter()
        .chain(turned)
        .chain(caught)
        .chain(carried_on);
    let taken = taken.filter_map(by_hand);
    let ends = met.into_iter().chain(left).chain(taken);
    let unpushed = ends.min_by_key(|(end, _)| *end);
    let pushed = pushed.and_then(by_hand);
    let ended = unpushed.into_iter().chain(pushed);
    let ended = ended.min_by_key(|(end, _)| *end);
    let (arrival, stop, last, end_of_track) = match ended {
        Some((end, why)) => {
            if end < first + FEWEST_CENSORED {
                let frames = end - first;
                let detail = Detail::EndsTooSoon { frames };
                return Err(Rejection::new(RejectReason::NoRestAfter, detail));
            }
            (end - 1, frames.frames[end - 1].point, end, why)
        }
        None => {
            let (arrival, stop, last) = rested?;
            (arrival, stop, last, End::Rest)
        }
    };
    missing(frames, first, arrival, last)?;
    carried(frames, first, arrival, rest.noise)?;
    let end = match end_of_track {
        End::Rest => (arrival + FRAMES_AFTER).min(last),
        End::Contact | End::LeftView => last,
    };
    let track = track(&frames.frames[first..end], end_of_track);
    // What leads it along may be a fence. What was turned round, or caught, has ended there.
    let along = unpushed.map_or(until, |(end, _)| end);
    let grazed = match unpushed {
        Some((_, End::Contact)) => None,
        _ if along > end => graze(
            &self::track(&frames.frames[first..along], end_of_track),
            frames.rig.camera.noise,
        ),
        _ => graze(&track, frames.rig.camera.noise),
    };
    let start = &frames.frames[first];
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
        grazed,
        gap: start.t - frames.frames[first.saturating_sub(1)].t,
    };
    Ok(StrikeSummary { slide, end })
}

/// The track of these frames, which begin with first motion.
fn track(frames: &[Frame], end: End) -> Track {
    let after = |frame: &Frame| since(frames[0].stamp, frame.stamp);
    Track {
        t: frames.iter().map(after).collect(),
        x: frames.iter().map(|frame| frame.point.x).collect(),
        y: frames.iter().map(|frame| frame.point.y).collect(),
        yaw: None,
        end,
    }
}

/// The first frame that may have been turned round on its way to `until`, by a fence that is not known, a corner or a hand.
fn turned(frames: &Frames<'_>, first: usize, until: usize, noise: f64) -> Option<usize> {
    let all = &frames.frames;
    let looked_at = &all[first..held_until(all, until)];
    let samples = looked_at
        .iter()
        .map(|frame| Sample::at(frame.stamp, frame.point));
    let after = turned_round(frames.rig, noise, samples)?;
    // The frame before may be its last, or the first of what comes after.
    let at = looked_at.partition_point(|frame| frame.stamp < after);
    Some(first + at.saturating_sub(1))
}

/// Whether too much time without a frame lies before this one to follow a slide through it.
fn is_lost_before(frames: &Frames<'_>, at: usize) -> bool {
    frames.frames[at].t - frames.frames[at - 1].t > GAP_LATER * frames.period
}

/// Frames that are missing where the slide cannot do without them.
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
    let gap = widest(first + 1, (arrival + FRAMES_AFTER).min(last));
    if gap > GAP_LATER * period {
        let detail = Detail::GapAfterMotion { gap, period };
        return Err(Rejection::new(RejectReason::FramesMissing, detail));
    }
    let there = arrival - first;
    let due = (all[arrival].t - all[first].t) / period;
    if (there as f64) < (1.0 - MOST_MISSING) * due - 1.0 {
        let detail = Detail::FramesMissing { there, due };
        return Err(Rejection::new(RejectReason::FramesMissing, detail));
    }
    Ok(())
}

/// A step far faster than the slide began: the object was taken away, or another was put there.
fn carried(frames: &Frames<'_>, first: usize, arrival: usize, noise: f64) -> Result<(), Rejection> {
    let all = &frames.frames;
    let step = |at: usize| all[at].point.distance(all[at - 1].point);
    // Stamps that are late by several ms bunch: two frames are a camera's period apart, whatever they say.
    let apart = |at: usize| (all[at].t - all[at - 1].t).max(frames.period);
    let speed = |at: usize| step(at) / apart(at);
    let fastest = (first + 1..arrival.min(first + BEGINNING) + 1)
        .map(speed)
        .fold(speed(first), f64::max);
    for at in first + 1..=arrival {
        let most = FASTER * fastest * apart(at) + SURELY_AWAY_NOISE * noise;
        let is_late = at >= first + BEGINNING;
        if (is_late && step(at) > most) || is_jump(step(at), apart(at), frames.rig) {
            let detail = Detail::Jumps {
                after: all[at].t - all[first].t,
                by: step(at),
            };
            return Err(Rejection::new(RejectReason::NoRestAfter, detail));
        }
    }
    Ok(())
}
