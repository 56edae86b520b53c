//! What `--robot` names in a trial: which embedded rig strikes, or the version's own world in its place.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rig::{NotSim, Sim, SimChoice, StrikeIndex, Truth};
use store::Artifact;
use values::{Command, Conditions, Point};
use world::{Scatter, Shift, Simulator};

use crate::Error;

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TrialRobot {
    /// The embedded rig.
    Sim(SimChoice),
    /// The version's own identified world, with its scatter.
    World,
}

/// A name that is neither.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}; the version's own world is `world`")]
pub struct UnknownRobot(NotSim);

impl FromStr for TrialRobot {
    type Err = UnknownRobot;

    fn from_str(text: &str) -> Result<Self, UnknownRobot> {
        match text {
            "world" => Ok(Self::World),
            other => other.parse().map(Self::Sim).map_err(UnknownRobot),
        }
    }
}

/// What is struck, and where it comes from, for a person.
pub struct Opened {
    /// It, in the last session that was logged.
    pub table: Table,
    /// The name of that session's log; none where no strike of this rig was logged.
    pub session: Option<String>,
    /// Its truth, such as `artifacts/demo/rig/truth.json`, or that it is the version's world.
    pub origin: String,
}

impl Opened {
    /// The embedded rig for an artifact's rig, which continues where the demo's strikes ended, so that no launch repeats one that was
    /// learnt from; or the artifact's own world.
    pub fn open(
        choice: &TrialRobot,
        artifacts: &Path,
        artifact: &Artifact,
        seed: u64,
    ) -> Result<Self, Error> {
        match choice {
            TrialRobot::Sim(choice) => Self::rig(choice.truth(artifacts), artifacts, artifact, seed),
            TrialRobot::World => Ok(Self {
                table: Table::World(OwnWorld::of(artifact, seed)?),
                session: None,
                origin: "this version's own world: how well it solves and learns, and no evidence about reality".into(),
            }),
        }
    }

    fn rig(
        truth: Option<PathBuf>,
        artifacts: &Path,
        artifact: &Artifact,
        seed: u64,
    ) -> Result<Self, Error> {
        let path = truth.ok_or_else(|| {
            Error::input(format!(
                "strike the embedded rig: there is no truth.json in {0} or {0}/rig, so that these logs are no demo's, and the demo's rig says \
                 nothing of yours; name the folder of a truth.json with `--robot sim:FOLDER`, or strike the version's own world with \
                 `--robot world`",
                artifacts.display()
            ))
        })?;
        let truth = Truth::load(&path).map_err(Error::input)?;
        if truth.rig != artifact.rig {
            return Err(Error::input(format!(
                "strike in the rig of {}: it is another rig than the artifact's; name the folder of the right one, such as \
                 `--robot sim:FOLDER`",
                path.display()
            )));
        }
        let strikes = truth.strikes.len();
        let last = truth.strikes.last().map(|strike| strike.session);
        let sim = Sim::from(Truth { seed, ..truth }).map_err(Error::input)?;
        Ok(Self {
            table: Table::Rig(Box::new(sim.after(strikes).in_session(last.unwrap_or(0)))),
            session: last.map(rig::demo::session_name),
            origin: format!("the embedded rig of {}", path.display()),
        })
    }
}

/// A table with an arm, at a strike of a session.
#[derive(Clone)]
pub enum Table {
    Rig(Box<Sim>),
    /// A version's own world.
    World(OwnWorld),
}

impl Table {
    /// Which strike comes next.
    pub fn index(&self) -> StrikeIndex {
        match self {
            Self::Rig(sim) => sim.index(),
            Self::World(world) => world.index,
        }
    }

    /// This robot after so many strikes.
    pub fn after(self, strikes: usize) -> Self {
        match self {
            Self::Rig(sim) => Self::Rig(Box::new(sim.after(strikes))),
            Self::World(mut world) => {
                world.index.order = strikes;
                Self::World(world)
            }
        }
    }

    /// This robot in another session.
    pub fn in_session(self, session: usize) -> Self {
        match self {
            Self::Rig(sim) => Self::Rig(Box::new(sim.in_session(session))),
            Self::World(mut world) => {
                world.index.session = session;
                Self::World(world)
            }
        }
    }

    /// How a box that is put down there will stand, in rad; none where that is not tracked.
    pub fn next_yaw(&self, from: Point) -> Option<f64> {
        match self {
            Self::Rig(sim) => sim.next_yaw(from),
            Self::World(_) => None,
        }
    }

    /// Strikes, and gives where the object stops, in m; a box stands as it is put down, or by this yaw (rad).
    pub fn strike(&mut self, from: Point, yaw: Option<f64>, command: Command) -> Option<Point> {
        match (self, yaw) {
            (Self::Rig(sim), Some(yaw)) => Some(sim.strike_turned(from, yaw, command).stop),
            (Self::Rig(sim), None) => Some(sim.strike(from, command).stop),
            (Self::World(world), _) => world.strike(from, command),
        }
    }
}

/// A version's own world, whose strikes scatter as it says that they do.
#[derive(Clone)]
pub struct OwnWorld {
    simulator: Arc<Simulator>,
    scatter: Scatter,
    seed: u64,
    index: StrikeIndex,
}

impl OwnWorld {
    fn of(artifact: &Artifact, seed: u64) -> Result<Self, Error> {
        let model = artifact.manifest.provenance.default_model;
        let (world, _) = artifact
            .model(model)
            .ok_or_else(|| Error::input("find the artifact's default model"))?;
        let simulator = Simulator::new(&artifact.rig, &world).map_err(Error::input)?;
        let strikes = artifact.manifest.provenance.strikes;
        Ok(Self {
            simulator: Arc::new(simulator),
            scatter: world.scatter,
            seed,
            index: StrikeIndex {
                session: 0,
                order: strikes.map_or(0, |strikes| strikes.count),
            },
        })
    }

    /// None where the strike comes to no rest.
    fn strike(&mut self, from: Point, command: Command) -> Option<Point> {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(self.index.order as u64);
        let mut draw = |deviation: f64| {
            let normal: f64 = StandardNormal.sample(&mut random);
            deviation * normal
        };
        let own = self.simulator.shift();
        let table = self.simulator.shifted(Shift {
            friction: own.friction + draw(self.scatter.friction),
            gain: own.gain + draw(self.scatter.speed),
            heading: own.heading + draw(self.scatter.angle),
        });
        let conditions = Conditions {
            order: self.index.order as f64,
            ..Conditions::default()
        };
        self.index.order += 1;
        let simulated = table.worker().strike(from, command, &conditions).ok()?;
        Some(simulated.stop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_of_a_trial_is_the_embedded_rig_or_the_versions_world() {
        assert_eq!("world".parse(), Ok(TrialRobot::World));
        assert_eq!("sim".parse(), Ok(TrialRobot::Sim(SimChoice::default())));
        let error = "xarm:host".parse::<TrialRobot>().expect_err("no trial");
        assert!(error.to_string().contains("`world`"), "{error}");
    }
}
