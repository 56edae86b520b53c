//! The strikes of a diagnosis, prepared for fits: how each leaves the tip, which of its frames are used, and the noise by which
//! they are weighed.

use nalgebra::{DMatrix, DVector, SVector};
use values::{Point, Rig, Strike};
use world::{
    Base, Impact, Release, World, WorldError,
    effects::Effect,
    launch::{Launch, launches, launches_about},
    planar::{self, Deviation, Frames, Planar, Response},
};

use crate::{
    DiagnoseError, Thresholds,
    mixed::{ANGLE, NUISANCES, SPEED},
    model::{CLOCK, FRICTION, Model, RESTITUTION},
    noise::{self, FrameNoise, Whitening},
    usable::FEWEST,
    wander::{Path, paths},
};

/// Nuisances of one strike: see [`crate::mixed`].
pub(crate) type Nuisances = SVector<f64, NUISANCES>;

/// Strikes with their launches and noise.
#[derive(Clone)]
pub(crate) struct PreparedStrikes<'a> {
    pub(crate) rig: &'a Rig,
    pub(crate) thresholds: &'a Thresholds,
    pub(crate) strikes: Vec<&'a Strike>,
    pub(crate) launches: Vec<Launch>,
    base: Base,
    gyration: f64,
    /// Correlation ρ and jitter κ of the camera's noise.
    pub(crate) noise: FrameNoise,
    /// Each strike's frames.
    pub(crate) frames: Vec<noise::Frames>,
    /// What makes each strike's errors independent.
    pub(crate) whitenings: Vec<Whitening>,
    /// How a wander moves each strike's friction.
    pub(crate) paths: Vec<Path>,
    /// Motion of stops, in m, that is none by what places are rounded to.
    pub(crate) resolved: f64,
}

/// Motion of stops, in m, that is no gap where nothing scatters: simulators differ by some micrometres, and logs of one without noise show it.
pub(crate) const RESOLVED: f64 = 1e-4;
/// Share of another strike's launch speed below which an object does not count as launched.
const SLOWEST: f64 = 1e-3;

/// A strike's nuisances, as planar form takes them.
fn deviation(clock: f64, b: &Nuisances) -> Deviation {
    Deviation {
        speed: b[0],
        angle: b[1],
        delay: clock + b[2],
        rest: Point::new(b[3], b[4]),
        friction: b[5],
    }
}

/// What a tracker rounds its places to, in m: the step of which all are multiples apart. 0 where there is none.
fn rounding(strikes: &[&Strike]) -> f64 {
    /// Places nearer than this (m) are one; and the greatest part of a step by which a multiple may be missed.
    const ONE: f64 = 1e-7;
    const OFF: f64 = 0.01;
    let of_axis = |axis: fn(&Strike) -> &Vec<f64>| {
        let mut all: Vec<f64> = strikes.iter().flat_map(|s| axis(s)).copied().collect();
        all.sort_by(f64::total_cmp);
        all.dedup_by(|a, b| (*a - *b).abs() < ONE);
        let steps = || all.windows(2).map(|pair| pair[1] - pair[0]);
        let step = steps().fold(f64::INFINITY, f64::min);
        let is_multiple = |apart: f64| (apart / step - (apart / step).round()).abs() < OFF;
        (step.is_finite() && steps().all(is_multiple)).then_some(step)
    };
    let steps = [of_axis(|s| &s.track.x), of_axis(|s| &s.track.y)];
    steps.into_iter().flatten().fold(0.0, f64::max)
}

/// Measured coordinates: all x, then all y.
pub(crate) fn measured(strike: &Strike) -> DVector<f64> {
    DVector::from_iterator(
        2 * strike.track.len(),
        strike.track.x.iter().chain(&strike.track.y).copied(),
    )
}

/// Points as a column: all x, then all y.
pub(crate) fn stack(points: &[Point]) -> DVector<f64> {
    DVector::from_iterator(
        2 * points.len(),
        points.iter().map(|p| p.x).chain(points.iter().map(|p| p.y)),
    )
}

impl<'a> PreparedStrikes<'a> {
    /// Strikes with their launches, and the number left out because their object does not leave the tip.
    pub(crate) fn of(
        rig: &'a Rig,
        world: &World,
        usable: &'a [Strike],
        thresholds: &'a Thresholds,
    ) -> Result<(Self, usize), DiagnoseError> {
        let (strikes, launches): (Vec<&Strike>, Vec<_>) = usable
            .iter()
            .zip(launches(rig, world, usable.iter().map(Strike::commanded))?)
            .filter_map(|(strike, launch)| Some((strike, launch?)))
            .unzip();
        let pushed = usable.len() - strikes.len();
        if strikes.len() < FEWEST {
            return Err(DiagnoseError::NoFit {
                why: format!("in {pushed} strikes the object does not leave the tip"),
            });
        }
        Ok((Self::new(rig, strikes, launches, thresholds), pushed))
    }

    /// Strikes with their launches, under independent camera errors.
    pub(crate) fn new(
        rig: &'a Rig,
        strikes: Vec<&'a Strike>,
        launches: Vec<Launch>,
        thresholds: &'a Thresholds,
    ) -> Self {
        let frames: Vec<noise::Frames> = strikes
            .iter()
            .map(|strike| noise::Frames::new(strike, 1.0 / rig.camera.rate))
            .collect();
        let orders: Vec<f64> = strikes.iter().map(|s| s.conditions.order).collect();
        // Repeats of one command are rounded alike, at both ends of their ways.
        let resolved = RESOLVED.max(rounding(&strikes));
        Self {
            rig,
            thresholds,
            strikes,
            launches,
            paths: paths(&orders),
            resolved,
            base: Base::of(&rig.object),
            gyration: planar::gyration(rig),
            noise: FrameNoise::WHITE,
            whitenings: whitenings(&frames, FrameNoise::WHITE),
            frames,
        }
    }

    /// These strikes, their frames whitened anew for this camera noise.
    pub(crate) fn with_noise(mut self, noise: FrameNoise) -> Self {
        self.whitenings = whitenings(&self.frames, noise);
        self.noise = noise;
        self
    }

    /// These strikes with `frames` (frames kept, and speeds at them in m/s) in place of their own, whitened anew.
    pub(crate) fn with_frames(mut self, frames: Vec<noise::Frames>) -> Self {
        self.whitenings = whitenings(&frames, self.noise);
        self.frames = frames;
        self
    }

    /// These strikes restricted to the ones at `places`.
    pub(crate) fn only(&self, places: &[usize]) -> Self {
        Self {
            strikes: places.iter().map(|i| self.strikes[*i]).collect(),
            launches: places.iter().map(|i| self.launches[*i]).collect(),
            frames: places.iter().map(|i| self.frames[*i].clone()).collect(),
            whitenings: places.iter().map(|i| self.whitenings[*i].clone()).collect(),
            paths: places.iter().map(|i| self.paths[*i]).collect(),
            ..self.clone()
        }
    }

    /// Whether a strike's last place judges a model: its stop; where most do not come to rest, the end of its track.
    pub(crate) fn judges(&self, i: usize) -> bool {
        self.strikes[i].has_stop() || !Strike::most_rest(self.strikes.iter().copied())
    }

    /// Frames that are left out, over all strikes.
    pub(crate) fn frames_left_out(&self) -> usize {
        let each = self.frames.iter().flat_map(|frames| &frames.kept);
        each.filter(|kept| !**kept).count()
    }

    /// These strikes, each launch's parabola set around the impact that a fitted model predicts: far from its own impact a launch departs from
    /// MuJoCo. Launches are unchanged where some object would not leave the tip.
    pub(crate) fn about(&self, world: &World, model: &Model) -> Result<Self, WorldError> {
        let effects = model.effects(self.rig, &model.values)?;
        let impacts: Vec<Impact> = self
            .strikes
            .iter()
            .map(|strike| {
                let delivered = world::effects::deliver(
                    &effects,
                    strike.command,
                    strike.initial,
                    &strike.conditions,
                );
                Impact::of(
                    &effects,
                    model.values[RESTITUTION],
                    delivered,
                    &strike.conditions,
                )
            })
            .collect();
        let launches: Option<Vec<Launch>> = launches_about(self.rig, world, &impacts)?
            .into_iter()
            .collect();
        let mut about = self.clone();
        if let Some(launches) = launches {
            about.launches = launches;
        }
        Ok(about)
    }

    /// The planar world of a model at these values.
    pub(crate) fn planar<'e>(&self, values: &[f64], effects: &'e [Box<dyn Effect>]) -> Planar<'e> {
        Planar::of(
            [values[FRICTION], values[RESTITUTION]],
            self.base,
            self.gyration,
            effects,
        )
    }

    /// How one strike's object leaves the tip.
    pub(crate) fn release(&self, planar: &Planar<'_>, i: usize) -> Release {
        planar.release(&self.strikes[i].into(), &self.launches[i])
    }

    /// One strike's simulated frames; `None` where it does not come to rest.
    pub(crate) fn simulate(
        &self,
        planar: &Planar<'_>,
        i: usize,
        clock: f64,
        b: &Nuisances,
    ) -> Option<Frames> {
        planar.strike(
            &self.strikes[i].into(),
            &self.launches[i],
            &deviation(clock, b),
        )
    }

    /// One strike's simulated frames with their derivatives, integrated in steps no longer than `longest` (m); `None` where it does not come to rest.
    pub(crate) fn response(
        &self,
        planar: &Planar<'_>,
        i: usize,
        release: Release,
        clock: f64,
        b: &Nuisances,
        longest: f64,
    ) -> Option<Response<'a>> {
        planar.response(
            &self.strikes[i].into(),
            release,
            &deviation(clock, b),
            longest,
        )
    }

    /// Change of a strike's frames in another world.
    pub(crate) fn answer_of(
        &self,
        response: &Response<'_>,
        other: &Planar<'_>,
        i: usize,
        clock: f64,
        b: &Nuisances,
        column: &mut [f64],
    ) {
        let release = self.release(other, i);
        response.answer_of(other, &release, &deviation(clock, b), column);
    }

    /// Where each strike is seen last in a model's world; `None` where it does not come to rest.
    pub(crate) fn ends(&self, model: &Model) -> Result<Vec<Option<Point>>, WorldError> {
        let effects = model.effects(self.rig, &model.values)?;
        let planar = self.planar(&model.values, &effects);
        let end = |i| {
            let frames = self.simulate(&planar, i, model.values[CLOCK], &Nuisances::zeros())?;
            frames.at.last().copied()
        };
        Ok((0..self.strikes.len()).map(end).collect())
    }

    /// By how much the launch of one strike differs in other worlds, as its nuisances: a column for each world.
    pub(crate) fn relaunched(
        &self,
        here: &Planar<'_>,
        others: &[Planar<'_>],
        i: usize,
    ) -> DMatrix<f64> {
        let velocity = |planar: &Planar<'_>| self.release(planar, i).velocity;
        let from = velocity(here);
        let mut columns = DMatrix::zeros(NUISANCES, others.len());
        for (k, planar) in others.iter().enumerate() {
            let to = velocity(planar);
            let (dot, cross) = (from.dot(to), from.x * to.y - from.y * to.x);
            columns[(SPEED, k)] = (to.norm() / from.norm()).max(SLOWEST).ln();
            columns[(ANGLE, k)] = cross.atan2(dot);
        }
        columns
    }

    /// Whether a strike's track comes this near (m) to a point.
    pub(crate) fn passes(&self, i: usize, point: Point, radius: f64) -> bool {
        let strike = self.strikes[i];
        (0..strike.track.len()).any(|frame| strike.track.point(frame).distance(point) < radius)
            || strike.initial.distance(point) < radius
    }
}

fn whitenings(frames: &[noise::Frames], noise: FrameNoise) -> Vec<Whitening> {
    let each = frames.iter();
    each.map(|frames| Whitening::new(frames, noise)).collect()
}

#[cfg(test)]
mod tests {
    use values::{Command, Track};

    use super::*;

    #[test]
    fn what_places_are_rounded_to_is_seen_in_them() {
        let strike = |step: f64| {
            let place = |i: usize| 0.3 + 0.01 * (3.7 * i as f64).sin();
            let rounded = |i: usize| match step {
                0.0 => place(i),
                step => (place(i) / step).round() * step,
            };
            let at = Point::default();
            Strike {
                track: Track {
                    t: (0..40).map(|i| 0.01 * i as f64).collect(),
                    x: (0..40).map(rounded).collect(),
                    y: (40..80).map(rounded).collect(),
                    ..Track::default()
                },
                ..Strike::bare(Command::new(0.5, 0.0), at, at)
            }
        };
        for step in [1e-3, 5e-4] {
            assert!((rounding(&[&strike(step)]) / step - 1.0).abs() < 1e-6);
        }
        assert!(rounding(&[&strike(0.0)]) < 1e-4);
        assert_eq!(rounding(&[]), 0.0);
    }
}
