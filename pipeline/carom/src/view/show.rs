//! The file: what stands still, then strike after strike.

use std::path::Path;

use durable::write;
use foxglove::messages::{FrameTransform, FrameTransforms, Log, log};
use logs::write::CopyWriter;
use rayon::prelude::*;
use serde::Serialize;
use values::{Interval, Obstacle, Point, Rig, Strike};
use world::{Simulated, Simulator, World, WorldError};

use super::draw::{Drawing, Ink, circle, outline, turned, vector};
use super::effects::effects;
use super::images::Images;
use super::messages::{self, AFTER, BEFORE, Message, Motion, TABLE, nanoseconds, timestamp};
use crate::Error;
use crate::beside::simulate;

/// The measured track, and the worlds' by their models' names.
const MEASURED: &str = "measured";
const SYSID: &str = "sysid";
const EFFECT: &str = "effect";
/// Strikes that are simulated side by side before they are written.
const BATCH: usize = 64;
/// Height of lines and arrows above the table, in m.
const LINES: f64 = 0.003;
/// Length in m of the arrow of a command of 1 m/s.
const COMMAND: f64 = 0.15;
/// Seconds between frames where a track has but one, or where they are as near as that.
const FRAME: f64 = 1.0 / 60.0;
const LEAST_FRAME: f64 = 1e-3;

fn ink(name: &str) -> Ink {
    Ink(match name {
        SYSID => [0.94, 0.60, 0.32, 1.0],
        EFFECT => [0.45, 0.65, 0.96, 1.0],
        _ => [0.93, 0.95, 0.97, 1.0],
    })
}

/// What a file shows.
#[derive(Debug, Default, Serialize)]
pub struct Shown {
    pub strikes: usize,
    pub images: usize,
    /// How long a player plays, in s.
    pub duration: f64,
}

/// Writes strikes, in this order, as they were measured and as the worlds have them; the second has effects. The first message has the
/// first strike's stamp.
pub fn show(
    path: &Path,
    rig: &Rig,
    worlds: &[&World],
    strikes: &[&Strike],
    images: &Images,
) -> Result<Shown, Error> {
    let start = strikes
        .first()
        .map_or(0.0, |strike| strike.t_start.max(0.0));
    let names = [SYSID, EFFECT].into_iter();
    let simulators = names
        .zip(worlds)
        .map(|(name, world)| Ok((name, Simulator::new(rig, world)?)))
        .collect::<Result<Vec<_>, WorldError>>()
        .map_err(Error::failed)?;
    let mut now = BEFORE;
    write(path, |file| {
        let mut file = CopyWriter::without_profile(file).map_err(Error::failed)?;
        let mut still = standing(rig, worlds, nanoseconds(start))?;
        still.extend(images.camera(nanoseconds(start))?);
        for message in still {
            message.write(&mut file)?;
        }
        for batch in strikes.chunks(BATCH) {
            let played: Vec<Played> = batch
                .par_iter()
                .map(|strike| Played::of(strike, &simulators))
                .collect();
            for played in &played {
                let mut messages = played.messages(rig, start + now)?;
                messages.extend(images.messages(played.strike, nanoseconds(start + now))?);
                messages.sort_by_key(Message::stamp);
                for message in messages {
                    message.write(&mut file)?;
                }
                let end = played.frames().last().copied().unwrap_or(0.0);
                now += end + AFTER + BEFORE;
            }
        }
        file.finish().map(drop).map_err(Error::failed)
    })?;
    Ok(Shown {
        strikes: strikes.len(),
        images: images.count(),
        duration: now - BEFORE,
    })
}

/// The table, the effects on it, and the objects, each in a frame of its own that moves.
fn standing(rig: &Rig, worlds: &[&World], stamp: u64) -> Result<Vec<Message>, Error> {
    let mut messages = Vec::new();
    messages.extend(table(rig).messages("/carom/table", TABLE, stamp)?);
    if let Some(world) = worlds.iter().find(|world| !world.effects.is_empty()) {
        let (drawing, sentences) = effects(rig, world).map_err(Error::failed)?;
        messages.extend(drawing.messages("/carom/effects", TABLE, stamp)?);
        for sentence in sentences {
            messages.push(said(stamp, sentence)?);
        }
    }
    for name in [MEASURED, SYSID, EFFECT].into_iter().take(1 + worlds.len()) {
        let mut drawing = Drawing::default();
        drawing.solid(rig.object.solid, ink(name).covering(0.5));
        messages.extend(drawing.messages(&format!("/carom/{name}/object"), name, stamp)?);
    }
    Ok(messages)
}

fn said(stamp: u64, text: String) -> Result<Message, Error> {
    let log = Log {
        timestamp: timestamp(stamp),
        level: log::Level::Info.into(),
        message: text,
        name: "carom".into(),
        ..Log::default()
    };
    Message::new("/carom/log", stamp, &log)
}

/// A strike beside its simulations.
struct Played<'a> {
    strike: &'a Strike,
    /// By model: the track, and how long before the first frame the tip touched the object, in s. A world in which nothing comes to rest has
    /// none.
    simulated: Vec<(&'static str, Simulated, f64)>,
}

impl<'a> Played<'a> {
    fn of(strike: &'a Strike, simulators: &[(&'static str, Simulator)]) -> Self {
        let simulated = simulators.iter().filter_map(|(name, simulator)| {
            let (simulated, before) = simulate(strike, simulator)?;
            Some((*name, simulated, before))
        });
        Self {
            strike,
            simulated: simulated.collect(),
        }
    }

    /// Times of frames in s since first motion: the track's own, and on at their distance until all rest.
    fn frames(&self) -> Vec<f64> {
        let mut times = self.strike.track.t.clone();
        let last = times.last().copied().unwrap_or(0.0);
        let steps = times.len().saturating_sub(1);
        let step = (last - times.first().copied().unwrap_or(0.0)) / steps.max(1) as f64;
        let step = if step > LEAST_FRAME { step } else { FRAME };
        let rests = self.simulated.iter();
        let rests = rests.map(|(_, simulated, before)| simulated.rest_time - before);
        let all_rest = rests.fold(last, f64::max);
        // One more at least: the measured object then is where it stopped, not where it was seen last.
        let more = ((all_rest - last) / step).ceil().max(1.0) as u32;
        times.extend((1..=more).map(|more| last + f64::from(more) * step));
        times
    }

    /// Where the measured object is: at its start before the first frame, at the track's end after the last.
    fn measured(&self, frame: usize) -> (Point, f64) {
        let track = &self.strike.track;
        let Some(last) = track.len().checked_sub(1) else {
            return (self.strike.initial, 0.0);
        };
        let yaw = track.yaw.as_ref();
        let yaw = yaw.and_then(|yaw| yaw.track.get(frame.min(last)).copied());
        if frame > last && self.strike.has_stop() {
            return (self.strike.stop, yaw.unwrap_or(0.0));
        }
        (track.point(frame.min(last)), yaw.unwrap_or(0.0))
    }

    /// How far from the measured stop, or from the track's end, a world has the object then, in m.
    fn error(&self, name: &str) -> Option<f64> {
        let of = |(_, simulated, before): &(&str, Simulated, f64)| {
            let end = self.end(simulated, *before);
            end.distance(self.strike.stop)
        };
        self.simulated.iter().find(|(of, ..)| *of == name).map(of)
    }

    /// Where a world has the object in the end: at rest, or when the track ends otherwise.
    fn end(&self, simulated: &Simulated, before: f64) -> Point {
        match self.strike.track.t.last() {
            Some(last) if !self.strike.has_stop() => simulated.at(last + before),
            _ => simulated.stop,
        }
    }

    /// All messages of the strike, whose first motion is at `at` (s).
    fn messages(&self, rig: &Rig, at: f64) -> Result<Vec<Message>, Error> {
        let begin = nanoseconds(at - BEFORE);
        let mut messages = vec![
            Message::new("/carom/strike", begin, &self.facts())?,
            said(begin, self.sentence())?,
        ];
        messages.extend(
            self.draw_measured(rig)
                .messages("/carom/measured", TABLE, begin)?,
        );
        for (name, simulated, before) in &self.simulated {
            let drawing = self.draw_simulated(rig, name, simulated, *before);
            messages.extend(drawing.messages(&format!("/carom/{name}"), TABLE, begin)?);
        }
        // At rest before.
        let yaw = self.strike.conditions.yaw.unwrap_or(0.0);
        let at_rest = |name| (name, self.strike.initial, yaw);
        let names = std::iter::once(MEASURED).chain(self.simulated.iter().map(|(name, ..)| *name));
        messages.push(transforms(names.map(at_rest), begin)?);
        let times = self.frames();
        for frame in 0..times.len() {
            let stamp = nanoseconds(at + times[frame]);
            let (place, turned) = self.measured(frame);
            let simulated = self.simulated.iter();
            let simulated = simulated
                .map(|(name, simulated, before)| (*name, simulated.at(times[frame] + before), yaw));
            let all = std::iter::once((MEASURED, place, turned)).chain(simulated);
            messages.push(transforms(all, stamp)?);
            messages.push(Message::new(
                "/carom/motion",
                stamp,
                &self.motion(&times, frame),
            )?);
        }
        Ok(messages)
    }

    fn facts(&self) -> messages::Strike {
        let strike = self.strike;
        messages::Strike {
            strike_id: strike.id.clone(),
            log: strike.log.clone(),
            index: strike.index,
            session: strike.conditions.session.clone(),
            split: strike.split.name().into(),
            t_start: strike.t_start,
            speed: strike.command.speed,
            angle: strike.command.angle,
            x0: strike.initial.x,
            y0: strike.initial.y,
            xf: strike.stop.x,
            yf: strike.stop.y,
            end: strike.track.end.name().into(),
            sysid_error: self.error(SYSID),
            effect_error: self.error(EFFECT),
        }
    }

    /// One line that says which strike it is and how far the worlds are off.
    fn sentence(&self) -> String {
        let strike = self.strike;
        let mut sentence = format!(
            "strike {} of {}: {:.3} m/s at {:.3} rad, {}",
            strike.id,
            strike.log,
            strike.command.speed,
            strike.command.angle,
            match strike.split {
                values::Split::Test => "held out",
                _ => "learnt from",
            }
        );
        for (name, said) in [(SYSID, "identified"), (EFFECT, "with effects")] {
            if let Some(error) = self.error(name) {
                sentence += &format!("; {said} {:.1} mm off", 1e3 * error);
            }
        }
        sentence
    }

    fn motion(&self, times: &[f64], frame: usize) -> Motion {
        let last = times.len() - 1;
        let (a, b) = (frame.saturating_sub(1), (frame + 1).min(last));
        let speed = |from: Point, to: Point| {
            let passed = times[b] - times[a];
            (passed > 0.0).then(|| from.distance(to) / passed)
        };
        let of = |name: &str| self.simulated.iter().find(|(of, ..)| *of == name);
        let at = |name: &str, frame: usize| {
            of(name).map(|(_, simulated, before)| simulated.at(times[frame] + before))
        };
        let is_seen = b < self.strike.track.len();
        let measured = |frame| self.measured(frame).0;
        let is_known = frame < self.strike.track.len() || self.strike.has_stop();
        let residual = |name| {
            at(name, frame)
                .filter(|_| is_known)
                .map(|p| p.distance(measured(frame)))
        };
        let speeds = |name| speed(at(name, a)?, at(name, b)?);
        Motion {
            t: times[frame],
            measured_speed: speed(measured(a), measured(b)).filter(|_| is_seen),
            sysid_speed: speeds(SYSID),
            effect_speed: speeds(EFFECT),
            sysid_residual: residual(SYSID),
            effect_residual: residual(EFFECT),
        }
    }

    /// The track, the command, and the object's outline where it stopped.
    fn draw_measured(&self, rig: &Rig) -> Drawing {
        let (strike, mut drawing) = (self.strike, Drawing::default());
        let ink = ink(MEASURED);
        let track = &strike.track;
        let seen = (0..track.len()).map(|frame| track.point(frame));
        let points: Vec<Point> = std::iter::once(strike.initial).chain(seen).collect();
        drawing.line(&points, LINES, ink);
        let command = Point::polar(COMMAND * strike.command.speed, strike.command.angle);
        let tip = strike.initial - command;
        drawing.arrow(
            tip,
            strike.initial,
            rig.object.solid.half_height(),
            ink.covering(0.6),
        );
        if strike.has_stop() {
            let turned = track.yaw.as_ref().and_then(|yaw| yaw.track.last().copied());
            let outline = outline(rig.object.solid, strike.stop, turned.unwrap_or(0.0));
            drawing.line(&outline, LINES, ink);
        }
        let high = Point::new(
            0.5 * (rig.table.x.low + rig.table.x.high),
            rig.table.y.high + 0.05,
        );
        drawing.text(high, 0.03, ink, self.sentence());
        drawing
    }

    /// A world's track, the outline where it ends, and an arrow from there to the measured stop.
    fn draw_simulated(&self, rig: &Rig, name: &str, simulated: &Simulated, before: f64) -> Drawing {
        let (ink, mut drawing) = (ink(name), Drawing::default());
        let last = simulated.track.len() - 1;
        let points: Vec<Point> = (0..=last)
            .filter(|sample| sample % 5 == 0 || *sample == last)
            .map(|sample| simulated.track.point(sample))
            .collect();
        drawing.line(&points, LINES, ink);
        let (end, yaw) = (
            self.end(simulated, before),
            self.strike.conditions.yaw.unwrap_or(0.0),
        );
        drawing.line(&outline(rig.object.solid, end, yaw), LINES, ink);
        drawing.arrow(end, self.strike.stop, 2.0 * LINES, ink);
        drawing
    }
}

/// Where each object is, as the place of its frame on the table.
fn transforms<'a>(
    objects: impl Iterator<Item = (&'a str, Point, f64)>,
    stamp: u64,
) -> Result<Message, Error> {
    let transform = |(name, place, yaw): (&str, Point, f64)| FrameTransform {
        timestamp: timestamp(stamp),
        parent_frame_id: TABLE.into(),
        child_frame_id: name.into(),
        translation: vector([place.x, place.y, 0.0]),
        rotation: turned(yaw),
    };
    let transforms = FrameTransforms {
        transforms: objects.map(transform).collect(),
    };
    Message::new("/carom/transforms", stamp, &transforms)
}

const TOP: Ink = Ink([0.30, 0.33, 0.38, 1.0]);
const EDGE: Ink = Ink([0.60, 0.64, 0.70, 1.0]);
const FENCE: Ink = Ink([0.85, 0.75, 0.35, 1.0]);
const OBSTACLE: Ink = Ink([0.80, 0.30, 0.30, 0.5]);
/// Thickness of the table and height of what stands on it, in m.
const THICKNESS: f64 = 0.01;
const HEIGHT: f64 = 0.03;
/// Radius of the robot's base as it is drawn, in m.
const BASE: f64 = 0.06;

/// What does not move.
pub fn table(rig: &Rig) -> Drawing {
    let mut drawing = Drawing::default();
    let (x, y) = (rig.table.x, rig.table.y);
    block(
        &mut drawing,
        x,
        y,
        [-1.5 * THICKNESS, -0.5 * THICKNESS],
        TOP,
    );
    drawing.outline(&corners(x, y), 0.0, EDGE);
    for fence in &rig.table.fences {
        drawing.line(&[fence.from, fence.to], HEIGHT, FENCE);
    }
    for obstacle in &rig.robot.obstacles {
        match *obstacle {
            Obstacle::Box { x, y } => {
                drawing.outline(&corners(x, y), HEIGHT, OBSTACLE);
                block(&mut drawing, x, y, [0.0, HEIGHT], OBSTACLE);
            }
            Obstacle::Disc { centre, radius } => {
                drawing.line(&circle(centre, radius), HEIGHT, OBSTACLE);
                drawing.post([centre.x, centre.y, 0.5 * HEIGHT], radius, HEIGHT, OBSTACLE);
            }
        }
    }
    let base = rig.robot.base.unwrap_or_default();
    drawing.line(&circle(base, BASE), 0.0, EDGE);
    drawing
}

fn corners(x: Interval, y: Interval) -> [Point; 4] {
    [
        Point::new(x.low, y.low),
        Point::new(x.high, y.low),
        Point::new(x.high, y.high),
        Point::new(x.low, y.high),
    ]
}

/// A slab between two heights.
fn block(drawing: &mut Drawing, x: Interval, y: Interval, [low, high]: [f64; 2], ink: Ink) {
    let middle = |low: f64, high: f64| 0.5 * (low + high);
    drawing.slab(
        [
            middle(x.low, x.high),
            middle(y.low, y.high),
            middle(low, high),
        ],
        [x.high - x.low, y.high - y.low, high - low],
        ink,
    );
}
