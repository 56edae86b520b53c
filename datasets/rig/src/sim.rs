//! The rig as a robot: it takes a command, strikes, and returns what a log of the strike would hold.

use std::path::Path;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use values::{Command, Point, Rig};

use crate::disturbance::Disturbance;
use crate::noise::Levels;
use crate::random::{Purpose, random};
use crate::slide::Lying;
use crate::strike::{PreparedRig, StrikeOutcome};
use crate::{
    CameraTruth, Hidden, RigSimError, Samples, Stamped, StateSample, StrikeIndex, StrikeTruth,
    Truth,
};

/// The log's clock starts here: a fixed date, since nothing here reads a clock; in ns since 1970.
const ORIGIN: u64 = 1_700_000_000_000_000_000;
/// From the start of one session to that of the next, in ns.
const DAY: u64 = 86_400_000_000_000;
/// From the start of one strike's recording to that of the next, at the least, in s.
const PAUSE: f64 = 5.0;
/// Rest that is recorded before the arm starts and after the object stops, in s.
const REST: f64 = 0.6;
/// Commands a second, in Hz.
const COMMAND_RATE: f64 = 250.0;

/// One strike as it was recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// What goes into a log.
    pub samples: Samples,
    /// Where the camera sees the object before, without noise, in m.
    pub initial: Point,
    /// Where the camera sees it come to rest, without noise, in m.
    pub stop: Point,
    /// How the object is seen turned at each centroid, in rad; empty where poses are not logged.
    pub yaws: Vec<f64>,
    /// What really happened.
    pub truth: StrikeTruth,
}

/// A rig that strikes one command after another. The same truth, seed and number of strikes before give the same recording.
#[derive(Clone, Debug)]
pub struct Sim {
    prepared: PreparedRig,
    index: StrikeIndex,
    start: u64,
    log_state: bool,
    log_pose: bool,
}

impl Sim {
    /// A rig with this hidden in place of the demo's mixture. Errors if the rig file lacks a size of its object.
    pub fn new(rig: &Rig, hidden: Hidden, seed: u64) -> Result<Self, RigSimError> {
        Self::from(Truth {
            hidden,
            ..Truth::demo(rig, seed)
        })
    }

    /// The demo's rig, mixture included: what `--robot sim` strikes.
    pub fn default_for(rig: &Rig, seed: u64) -> Result<Self, RigSimError> {
        Self::from(Truth::demo(rig, seed))
    }

    /// The rig that a `truth.json` describes.
    pub fn from_truth(path: &Path) -> Result<Self, RigSimError> {
        Self::from(Truth::load(path)?)
    }

    /// The rig of this truth; strikes noted in it are forgotten.
    pub fn from(truth: Truth) -> Result<Self, RigSimError> {
        let prepared = PreparedRig::new(Truth {
            strikes: Vec::new(),
            ..truth
        })?;
        Ok(Self {
            prepared,
            index: StrikeIndex::default(),
            start: ORIGIN,
            log_state: false,
            log_pose: false,
        })
    }

    /// Continues as if this many strikes had been made: an executor that runs anew must not repeat its last strike.
    pub fn after(mut self, strikes: usize) -> Self {
        self.index.order = strikes;
        self.start += strikes as u64 * nanoseconds(PAUSE);
        self
    }

    /// Also logs the measured state of the striker.
    pub fn logging_state(mut self) -> Self {
        self.log_state = true;
        self
    }

    /// Also records how the object is seen turned.
    pub fn logging_pose(mut self) -> Self {
        self.log_pose = true;
        self
    }

    /// Starts the next session, a day later.
    pub fn next_session(&mut self) {
        self.index.session += 1;
        self.start = ORIGIN + self.index.session as u64 * DAY;
    }

    /// Goes on in this session, on its own day.
    pub fn in_session(mut self, session: usize) -> Self {
        self.index.session = session;
        self.start = ORIGIN + session as u64 * DAY + self.index.order as u64 * nanoseconds(PAUSE);
        self
    }

    /// Session and number of strikes so far.
    pub fn index(&self) -> StrikeIndex {
        self.index
    }

    /// The truth that it was made from.
    pub fn truth(&self) -> &Truth {
        &self.prepared.truth
    }

    pub(crate) fn prepared(&self) -> &PreparedRig {
        &self.prepared
    }

    /// How the object is turned (rad) that is put down for the next strike where the camera sees it at `initial` (m), as the camera sees it;
    /// none of a rig whose objects are all put down straight.
    pub fn next_yaw(&self, initial: Point) -> Option<f64> {
        let yaw = self.next_true_yaw();
        (yaw != 0.0).then(|| self.prepared.truth.see_yaw(initial, yaw, self.index))
    }

    fn next_true_yaw(&self) -> f64 {
        let truth = &self.prepared.truth;
        let levels = truth.noise.levels();
        if levels.yaw_scatter == 0.0 {
            return 0.0;
        }
        Disturbance::new(levels, truth.seed, self.index).yaw
    }

    /// Lays the object where the camera sees it at `initial` (m) and strikes. The arm aims at the object's true centre.
    pub fn strike(&mut self, initial: Point, command: Command) -> Recording {
        self.strike_lying(initial, self.next_true_yaw(), command)
    }

    /// Strikes an object that the camera sees turned by `yaw` (rad).
    pub fn strike_turned(&mut self, initial: Point, yaw: f64, command: Command) -> Recording {
        let turned = self.prepared.truth.see_yaw(initial, yaw, self.index) - yaw;
        self.strike_lying(initial, yaw - turned, command)
    }

    fn strike_lying(&mut self, initial: Point, yaw: f64, command: Command) -> Recording {
        let truth = &self.prepared.truth;
        let centre = truth.rig.camera.centre;
        let index = self.index;
        let levels = truth.noise.levels();
        let mut disturbance = Disturbance::new(levels, truth.seed, index);
        let from = truth.hidden.unsee(initial, centre, index);
        let delivered = self.launch(command, from, &levels, &disturbance);
        let lying = Lying { at: from, yaw };
        let outcome = self
            .prepared
            .strike(lying, delivered, index, disturbance.friction);

        let profile = Profile::new(command, truth.rig.robot.acceleration);
        let impact = REST + profile.impact(delivered.speed.max(1e-3));
        let end = (impact + outcome.rest_time()).max(REST + profile.duration()) + REST;
        let stamp = |time: f64| self.start + nanoseconds(time);

        let frames = film(
            &truth.camera,
            (truth.rig.camera.rate, truth.rig.camera.noise),
            (0.0, end),
            &mut self.random(Purpose::Camera),
            &mut disturbance,
            |time| truth.hidden.see(outcome.at(time - impact), centre, index),
        );
        let mut seen_yaw = |time: f64| {
            truth.see_yaw(outcome.at(time), outcome.yaw(time), index) + disturbance.yaw_error()
        };
        let yaws = match self.log_pose {
            true => frames
                .iter()
                .map(|frame| seen_yaw(frame.exposed - impact))
                .collect(),
            false => Vec::new(),
        };
        let stamped = |time: f64, at: Point| Stamped::at(stamp(time), at);
        let ticks = || (0..=(end * COMMAND_RATE) as u32).map(|tick| f64::from(tick) / COMMAND_RATE);
        let samples = Samples {
            centroids: frames
                .iter()
                .map(|frame| stamped(frame.time.max(0.0), frame.centroid))
                .collect(),
            commands: ticks()
                .map(|time| stamped(time, profile.velocity(time - REST)))
                .collect(),
            states: if self.log_state {
                let state = |time: f64| {
                    // The arm follows the commanded profile at the share of speed that it delivers.
                    let share = delivered.speed / command.speed;
                    let done = profile.distance(time - REST) - profile.distance(impact - REST);
                    let at = from + Point::polar(share * done - outcome.gap, delivered.angle);
                    let velocity =
                        Point::polar(share * profile.speed(time - REST), delivered.angle);
                    StateSample {
                        stamp: stamp(time),
                        position: at.into(),
                        velocity: velocity.into(),
                    }
                };
                ticks().map(state).collect()
            } else {
                Vec::new()
            },
        };
        let recording = Recording {
            samples,
            initial,
            stop: truth.see(outcome.stop(), index),
            yaws,
            truth: StrikeTruth {
                session: self.index.session,
                order: self.index.order,
                initial: from,
                command,
                delivered,
                impact: stamp(impact),
                rest_time: outcome.rest_time(),
                stop: outcome.stop(),
                friction: (disturbance.friction != 1.0).then_some(disturbance.friction),
                yaw: (yaw != 0.0).then_some(yaw),
            },
        };
        self.index.order += 1;
        self.start += nanoseconds(PAUSE.max(end + 1.0));
        recording
    }

    /// What an object that rests at a point of the table (m) does when a tip meets it with this speed and angle, on a line that
    /// passes so far (m) to the left of its centre: for an arm that moves by itself. It counts as a strike.
    pub fn meet(&mut self, from: Point, tip: Command, aside: f64) -> StrikeOutcome {
        let truth = &self.prepared.truth;
        let levels = truth.noise.levels();
        let disturbance = Disturbance::new(levels, truth.seed, self.index);
        let delivered = self.launch(tip, from, &levels, &disturbance);
        let (index, friction) = (self.index, disturbance.friction);
        self.index.order += 1;
        self.prepared
            .strike_aside(from, delivered, aside, index, friction)
    }

    /// What the arm delivers this time for an object that lies here (m): effects, then scatter.
    fn launch(
        &self,
        command: Command,
        from: Point,
        levels: &Levels,
        disturbance: &Disturbance,
    ) -> Command {
        let mut random = self.random(Purpose::Launch);
        let [speed, angle]: [f64; 2] = std::array::from_fn(|_| StandardNormal.sample(&mut random));
        let truth = &self.prepared.truth;
        let delivered = truth.hidden.deliver(command, from, self.index);
        let robot = &truth.rig.robot;
        let growth = levels.launch_growth(
            (command.speed - robot.speed.low) / (robot.speed.high - robot.speed.low),
            command.angle.abs() / robot.angle.high.abs().max(robot.angle.low.abs()),
        );
        let [speed, angle] = [
            speed * disturbance.launch[0] * growth,
            angle * disturbance.launch[1] * growth,
        ];
        let scatter = truth.scatter;
        Command::new(
            (delivered.speed * (1.0 + scatter.speed * speed)).max(0.0),
            delivered.angle + scatter.angle * angle,
        )
    }

    fn random(&self, purpose: Purpose) -> ChaCha8Rng {
        random(self.prepared.truth.seed, purpose, self.index.order)
    }
}

fn nanoseconds(seconds: f64) -> u64 {
    (seconds * 1e9).round() as u64
}

/// Two stamps are at least this far apart, in s.
const SHORTEST_INTERVAL: f64 = 1e-4;

/// One frame: its stamp (s), when it was exposed (s), and what centroid was found (m).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub time: f64,
    pub exposed: f64,
    pub centroid: Point,
}

/// Films from one time to another (s); `seen` is the centroid without noise at a time.
///
/// The stamp is that of the exposure, jitter included, as of a camera that is triggered by software and stamps in hardware.
/// Errors of stamps and noise of other kinds come from `disturbance`; stamps stay in order, as a driver gives them.
pub(crate) fn film(
    camera: &CameraTruth,
    (rate, noise): (f64, f64),
    (from, to): (f64, f64),
    random: &mut ChaCha8Rng,
    disturbance: &mut Disturbance,
    seen: impl Fn(f64) -> Point,
) -> Vec<Frame> {
    let period = 1.0 / rate;
    let phase: f64 = random.random();
    let count = ((to - from) / period - phase).max(0.0) as usize;
    let mut frames = Vec::with_capacity(count + 1);
    for k in 0..=count {
        // Every frame draws the same numbers whether or not it is lost, so that losing one changes no other.
        let [jitter, x, y]: [f64; 3] = std::array::from_fn(|_| StandardNormal.sample(random));
        let lost = random.random::<f64>() < camera.dropped;
        // Within half a period, lest two frames swap.
        let jitter = (jitter * camera.jitter).clamp(-0.45 * period, 0.45 * period);
        let time = from + (phase + k as f64) * period + jitter;
        let error = disturbance.frame(Point::new(x, y), noise, time);
        let late = disturbance.stamp_error();
        let exposed = time + disturbance.readout(seen(time));
        let there = seen(exposed);
        if lost || disturbance.loses(there, time) {
            continue;
        }
        let mut stamp = time;
        if disturbance.has_stamp_errors() {
            let last = frames.last().map_or(0.0, |frame: &Frame| frame.time);
            stamp = disturbance
                .reported_stamp(time + late)
                .max(last + SHORTEST_INTERVAL);
        }
        frames.push(Frame {
            time: stamp,
            exposed,
            centroid: disturbance.reported(there + error),
        });
    }
    frames
}

/// Distance, in m, before the impact at which the commanded speed is reached (paper, section 3.1).
const PRE_STRIKE: f64 = 0.010;
/// Distance, in m, beyond the impact over which the commanded speed is held, so that the plateau spans the impact even if the arm is slower than
/// commanded.
const FOLLOW_THROUGH: f64 = 0.010;

/// One commanded motion along a line; times in s from its start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Profile {
    command: Command,
    ramp: f64,
    plateau: f64,
}

impl Profile {
    pub(crate) fn new(command: Command, acceleration: f64) -> Self {
        Self {
            command,
            ramp: command.speed / acceleration,
            plateau: (PRE_STRIKE + FOLLOW_THROUGH) / command.speed,
        }
    }

    /// How long it lasts.
    pub(crate) fn duration(&self) -> f64 {
        2.0 * self.ramp + self.plateau
    }

    /// When the tip touches, if it moves at this speed (m/s) from the pre-strike position on, which it reaches in time.
    pub(crate) fn impact(&self, delivered_speed: f64) -> f64 {
        self.ramp + PRE_STRIKE / delivered_speed
    }

    /// Commanded speed at a time, in m/s.
    pub(crate) fn speed(&self, time: f64) -> f64 {
        let falling = time - self.ramp - self.plateau;
        let share = if time < self.ramp {
            time / self.ramp
        } else {
            1.0 - falling.max(0.0) / self.ramp
        };
        self.command.speed * share.clamp(0.0, 1.0)
    }

    /// Commanded velocity at a time, in m/s.
    pub(crate) fn velocity(&self, time: f64) -> Point {
        Point::polar(self.speed(time), self.command.angle)
    }

    /// Distance commanded from the start to a time, in m.
    pub(crate) fn distance(&self, time: f64) -> f64 {
        let rising = time.clamp(0.0, self.ramp);
        let flat = (time - self.ramp).clamp(0.0, self.plateau);
        let falling = (time - self.ramp - self.plateau).clamp(0.0, self.ramp);
        self.command.speed
            * (rising * rising / (2.0 * self.ramp) + flat + falling
                - falling * falling / (2.0 * self.ramp))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trapezoid_reaches_its_speed_ten_millimetres_before_the_blow() {
        let profile = Profile::new(Command::new(0.8, 0.0), 4.0);
        assert!((profile.speed(0.1) - 0.4).abs() < 1e-12);
        assert_eq!(profile.speed(profile.impact(0.8)), 0.8);
        assert!((profile.impact(0.8) - (0.2 + 0.0125)).abs() < 1e-12);
        assert!(profile.speed(profile.duration()).abs() < 1e-12);
        assert!((profile.distance(profile.duration()) - (0.16 + 0.02)).abs() < 1e-12);
    }
}
