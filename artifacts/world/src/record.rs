//! What a simulated strike did, as the camera would see it.

use values::{Point, Track};

use crate::Simulator;

/// Seconds between samples of a track, about: a straight line between two is off by a thousandth of a millimetre.
const SAMPLE: f64 = 2e-3;

/// What a simulated strike did, as the camera would see it.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulated {
    /// Where the object comes to rest, in m.
    pub stop: Point,
    /// From touch (t = 0) to rest, every 2 ms or so, in s and m.
    pub track: Track,
    /// Seconds from touch to rest.
    pub rest_time: f64,
}

impl Simulated {
    /// Where the camera sees the object `t` seconds after touch: linear between steps, at rest before and after, in m.
    pub fn at(&self, t: f64) -> Point {
        let track = &self.track;
        let after = track.t.partition_point(|&time| time <= t);
        if after == 0 {
            track.point(0)
        } else if after == track.len() {
            self.stop
        } else {
            let (t0, t1) = (track.t[after - 1], track.t[after]);
            let share = (t - t0) / (t1 - t0);
            track.point(after - 1) * (1.0 - share) + track.point(after) * share
        }
    }
}

/// The track of a strike, as the camera would see it.
pub(crate) struct Record<'a> {
    simulator: &'a Simulator,
    track: Track,
}

impl<'a> Record<'a> {
    pub(crate) fn new(simulator: &'a Simulator, origin: Point) -> Self {
        let mut record = Self {
            simulator,
            track: Track::default(),
        };
        record.push(0.0, origin);
        record
    }

    fn push(&mut self, t: f64, point: Point) {
        let seen = self.simulator.observe(point);
        self.track.t.push(t);
        self.track.x.push(seen.x);
        self.track.y.push(seen.y);
    }

    /// Records a short step, which becomes a sample where the last one is old enough.
    pub(crate) fn step(&mut self, t: f64, point: Point) {
        let last = self.track.t.last().copied().unwrap_or(0.0);
        if t - last >= 0.999 * SAMPLE {
            self.push(t, point);
        }
    }

    /// Records a long step of constant acceleration.
    pub(crate) fn arc(
        &mut self,
        t: f64,
        duration: f64,
        from: Point,
        velocity: Point,
        acceleration: Point,
    ) {
        let samples = (duration / SAMPLE).ceil().max(1.0);
        for sample in 1..=samples as u32 {
            let later = duration * f64::from(sample) / samples;
            let point = from + velocity * later + acceleration * (0.5 * later * later);
            self.push(t + later, point);
        }
    }

    pub(crate) fn end(mut self, t: f64, stop: Point) -> Simulated {
        if self.track.t.last().is_some_and(|&last| last < t) {
            self.push(t, stop);
        }
        Simulated {
            stop: self.simulator.observe(stop),
            rest_time: t,
            track: self.track,
        }
    }
}
