//! Simulated tracks beside measured ones.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use values::{Command, Point, Rig, Shape, Strays, Strike};
use world::{
    Shift, Simulated, Simulator, World, WorldError,
    launch::{self, launches},
    planar::{Deviation, Frames, Planar, StrikeInput},
};

use crate::scatter::{ANGLE, CLOCK, FRICTION, Nuisances, SPEED, VarianceComponents};

/// Parameters that planar form knows; the impact depends on the others, or they are the air's.
const PLANAR: &[&str] = &["friction", "restitution", "torsional_friction", "inertia_z"];

/// Time, in s, by which a track is simulated beyond its end: differences by the clock look there.
const MARGIN: f64 = 0.05;

/// Greatest deviation of a launch from its command that counts as scatter, in standard deviations of how a box's launches scatter, and its own least
/// and greatest values, relative and in rad; a round object's is the least: more is a gap of the world.
const LAUNCH_SCATTER: f64 = 2.5;
const LEAST_LAUNCH: f64 = 0.03;
const GREATEST_LAUNCH: f64 = 0.12;
/// Greatest deviation, relative and in rad, of the start of a slide that no strike began.
const UNSTRUCK_LAUNCH: f64 = 0.5;

/// Where strikes are simulated: in MuJoCo, or in planar form, which follows it to a tenth of a millimetre in a twentieth of
/// the time.
pub(crate) struct StrikeSimulator<'a> {
    pub(crate) rig: &'a Rig,
    pub(crate) strikes: &'a [&'a Strike],
    /// How each object leaves the tip around its command; none in MuJoCo.
    launches: Option<Vec<launch::Launch>>,
    /// Whether a box's own deviations are scatter as far as its launches scatter, and are those of its way where the tip slips.
    pub(crate) is_by_way: bool,
}

impl<'a> StrikeSimulator<'a> {
    /// A simulator in MuJoCo.
    pub(crate) fn mujoco(rig: &'a Rig, strikes: &'a [&'a Strike]) -> Self {
        Self {
            rig,
            strikes,
            launches: None,
            is_by_way: false,
        }
    }

    /// A simulator in planar form, near a world. `None` where it does not know what is free, for a ball, for a world with effects, and where an
    /// object does not leave the tip.
    pub(crate) fn planar(
        rig: &'a Rig,
        world: &World,
        strikes: &'a [&'a Strike],
        free: &[String],
    ) -> Result<Option<Self>, WorldError> {
        let is_known = free.iter().all(|name| PLANAR.contains(&name.as_str()));
        if !is_known || rig.object.shape() == Shape::Sphere || !world.effects.is_empty() {
            return Ok(None);
        }
        let commanded = strikes.iter().map(|strike| strike.commanded());
        let launches: Option<Vec<_>> = launches(rig, world, commanded)?.into_iter().collect();
        Ok(launches.map(|launches| Self {
            rig,
            strikes,
            launches: Some(launches),
            is_by_way: false,
        }))
    }

    /// With deviations by a box's way, or by the command.
    pub(crate) fn by_way(mut self, is_by_way: bool) -> Self {
        self.is_by_way = is_by_way && !self.rig.object.shape().is_round();
        self
    }

    /// Whether MuJoCo simulates.
    pub(crate) fn is_mujoco(&self) -> bool {
        self.launches.is_none()
    }

    /// Whether deviations from the derivatives' linear prediction are simulated and taken off: planar form is quick enough for it, a ball rolls so far
    /// that they count, and no other form knows a box whose tip slips.
    pub(crate) fn goes_beyond(&self) -> bool {
        !self.is_mujoco() || self.is_by_way || self.rig.object.shape() == Shape::Sphere
    }

    /// MuJoCo's simulations that one pass over the strikes takes.
    pub(crate) fn simulations(&self) -> u64 {
        match self.launches {
            Some(_) => 0,
            None => self.strikes.len() as u64,
        }
    }

    /// Simulates every strike in this world with this launch.
    pub(crate) fn simulate(&self, world: &World, launch: Launch) -> Result<Batch, WorldError> {
        let tracks = match &self.launches {
            None => self.in_mujoco(world, launch)?,
            Some(launches) => self.in_planar_form(world, launch, launches)?,
        };
        Ok(Batch { tracks, launch })
    }

    fn in_mujoco(&self, world: &World, launch: Launch) -> Result<Vec<SimulatedStrike>, WorldError> {
        Simulator::new(self.rig, world)?
            .map(self.strikes, |worker, strike| {
                let command = launch.of(strike.command);
                let last = strike.track.t.last().copied().unwrap_or(0.0);
                let until = launch.delay + MARGIN + last;
                let (initial, conditions) = (strike.initial, &strike.conditions);
                let simulated = worker.strike_until(initial, command, conditions, until)?;
                Ok(SimulatedStrike::Whole(simulated))
            })
            .into_iter()
            .collect()
    }

    fn in_planar_form(
        &self,
        world: &World,
        launch: Launch,
        launches: &[launch::Launch],
    ) -> Result<Vec<SimulatedStrike>, WorldError> {
        let planar = Planar::new(self.rig, world, &[])?;
        let deviation = Deviation {
            delay: launch.delay,
            ..Deviation::default()
        };
        self.strikes
            .par_iter()
            .zip(launches)
            .map(|(strike, near)| {
                let command = launch.of(strike.command);
                // A table that hardly brakes brings nothing to rest in good time: frames are all that count.
                let input = StrikeInput {
                    command,
                    to_rest: false,
                    ..StrikeInput::from(*strike)
                };
                planar
                    .strike(&input, near, &deviation)
                    .map(SimulatedStrike::Frames)
                    .ok_or(WorldError::Diverged {
                        speed: command.speed,
                        angle: command.angle,
                        why: "it has not come to rest within 20 s",
                    })
            })
            .collect()
    }
}

impl StrikeSimulator<'_> {
    /// For each strike, the difference in m between its frames simulated with a launch, a clock and a friction of its own, and where the derivatives
    /// by these put them: a slide is linear in none of them, and scatter would bias what is common to all. A launch counts up to what is scatter, a
    /// clock up to a frame; beyond these they stay linear. The launch of a slide that no strike began is not known beforehand, and counts in full.
    /// None where the simulator does not go beyond the derivatives.
    pub(crate) fn beyond_slopes(
        &self,
        world: &World,
        launch: Launch,
        guesses: &[Nuisances],
        components: &VarianceComponents,
        slopes: &[DMatrix<f64>],
    ) -> Result<Option<Vec<DVector<f64>>>, WorldError> {
        if !self.goes_beyond() {
            return Ok(None);
        }
        let planar = Planar::new(self.rig, world, &[])?;
        let simulator = Simulator::new(self.rig, world)?;
        let frame = 1.0 / self.rig.camera.rate;
        let beyond = self.strikes.par_iter().enumerate().map(|(i, strike)| {
            let (guess, slopes) = (&guesses[i], &slopes[i]);
            let command = launch.of(strike.command);
            let within = |place: usize| {
                let scatter = LAUNCH_SCATTER * components.nuisance[place];
                let most = match strike.conditions.is_unstruck {
                    true => UNSTRUCK_LAUNCH,
                    false if !self.is_by_way => LEAST_LAUNCH,
                    false => scatter.clamp(LEAST_LAUNCH, GREATEST_LAUNCH),
                };
                guess[place].clamp(-most, most)
            };
            let own = Nuisances::from_column_slice(&[
                within(SPEED),
                within(ANGLE),
                guess[CLOCK].clamp(-frame, frame),
                0.0,
                0.0,
                guess[FRICTION],
            ]);
            let frames = |own: Nuisances| {
                let delay = launch.delay + own[CLOCK];
                let (gain, heading, friction) = (own[SPEED].ln_1p(), own[ANGLE], own[FRICTION]);
                let Some(launches) = &self.launches else {
                    let shift = Shift {
                        friction,
                        gain,
                        heading: 0.0,
                    };
                    let times = &strike.track.t;
                    let until = times.last()? + delay + MARGIN;
                    let shifted = simulator.shifted(shift);
                    let simulated = shifted
                        .worker()
                        .strike_until(strike.initial, command, &strike.conditions, until)
                        .ok()?;
                    let turned =
                        |at: Point| strike.initial + (at - strike.initial).rotated(heading);
                    let at: Vec<_> = times
                        .iter()
                        .map(|t| turned(simulated.at(t + delay)))
                        .collect();
                    return Some(stack(&at));
                };
                let input = StrikeInput {
                    command,
                    to_rest: false,
                    ..StrikeInput::from(*strike)
                };
                let deviation = Deviation {
                    speed: gain,
                    angle: heading,
                    delay,
                    friction,
                    ..Deviation::default()
                };
                Some(stack(&planar.strike(&input, &launches[i], &deviation)?.at))
            };
            let linear = slopes * own;
            match frames(own).zip(frames(Nuisances::zeros())) {
                Some((there, here)) => there - here - linear,
                None => DVector::zeros(linear.len()),
            }
        });
        Ok(Some(beyond.collect()))
    }
}

/// Points as a column: all x, then all y.
fn stack(points: &[Point]) -> DVector<f64> {
    let (x, y) = (points.iter().map(|p| p.x), points.iter().map(|p| p.y));
    DVector::from_iterator(2 * points.len(), x.chain(y))
}

/// How every launch differs from its command: factor on speed, turn in rad, and how late its clock starts in s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Launch {
    pub(crate) speed_factor: f64,
    pub(crate) turn: f64,
    pub(crate) delay: f64,
}

impl Launch {
    /// Launches exactly as commanded.
    pub(crate) const EXACT: Self = Self {
        speed_factor: 1.0,
        turn: 0.0,
        delay: 0.0,
    };

    /// A command as this launch delivers it.
    pub(crate) fn of(self, command: Command) -> Command {
        Command {
            speed: command.speed * self.speed_factor,
            angle: command.angle + self.turn,
        }
    }
}

/// One simulated strike.
enum SimulatedStrike {
    /// A whole strike from touch to rest, by MuJoCo.
    Whole(Simulated),
    /// The object at the measured frames, by planar form, with the launch's delay in them.
    Frames(Frames),
}

/// The simulated strikes of one world, in the order of the strikes.
pub(crate) struct Batch {
    tracks: Vec<SimulatedStrike>,
    launch: Launch,
}

impl Batch {
    /// How every strike was launched.
    pub(crate) fn launch(&self) -> Launch {
        self.launch
    }

    /// Simulated centroids at a strike's frames, `later` s (of a millisecond or so) beyond the launch's delay: all x, then
    /// all y, in m.
    pub(crate) fn track(&self, index: usize, strike: &Strike, later: f64) -> DVector<f64> {
        let times = &strike.track.t;
        let n = times.len();
        let mut track = DVector::zeros(2 * n);
        for (i, t) in times.iter().enumerate() {
            let point: Point = match &self.tracks[index] {
                SimulatedStrike::Whole(simulated) => simulated.at(t + self.launch.delay + later),
                SimulatedStrike::Frames(frames) => frames.at[i] + frames.rate[i] * later,
            };
            track[i] = point.x;
            track[n + i] = point.y;
        }
        track
    }

    /// Measured minus simulated coordinates of one strike, in m.
    pub(crate) fn residual(&self, index: usize, strike: &Strike) -> DVector<f64> {
        measured(strike) - self.track(index, strike, 0.0)
    }

    /// Root mean square of measured minus simulated coordinates, in m.
    pub(crate) fn rms(&self, strikes: &[&Strike]) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for (i, strike) in strikes.iter().enumerate() {
            let residual = self.residual(i, strike);
            sum += residual.norm_squared();
            count += residual.len();
        }
        (sum / count.max(1) as f64).sqrt()
    }

    /// The first strikes, of which those whose tracks end far from where the others' do. `camera`: standard deviation of a centroid, in m.
    pub(crate) fn strays(&self, strikes: &[&Strike], camera: f64) -> Strays {
        let of = |(i, strike): (usize, &&Strike)| {
            let residual = self.residual(i, strike);
            let last = strike.track.len() - 1;
            let way = strike.track.point(last) - strike.initial;
            let ahead = way * way.norm().max(1e-9).recip();
            let off = Point::new(residual[last], residual[2 * last + 1]);
            let across = off.y * ahead.x - off.x * ahead.y;
            ([off.dot(ahead), across], way.norm())
        };
        let (errors, ways): (Vec<_>, Vec<_>) = strikes.iter().enumerate().map(of).unzip();
        Strays::of(&errors, &ways, camera)
    }
}

/// Measured centroids: all x, then all y, in m.
fn measured(strike: &Strike) -> DVector<f64> {
    DVector::from_iterator(
        2 * strike.track.len(),
        strike.track.x.iter().chain(&strike.track.y).copied(),
    )
}
