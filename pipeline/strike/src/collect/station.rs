//! What strikes in a collection: an arm and a camera, or the embedded rig.

use std::path::Path;
#[cfg(feature = "sim")]
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use values::Point;
#[cfg(feature = "sim")]
use values::Rig;

use super::error::CollectError;
use super::request::CollectEvent;
use crate::epoch::Epoch;
use crate::last_stop::Memory;
use crate::robot::arm::{Arm, Guarded};
use crate::watched::strike_and_keep;
use crate::{Live, LiveError, Plan, Received, Resting, RobotError, Samples, StrikeRecord, Watched};
#[cfg(feature = "sim")]
use crate::{SimRobot, TruthSource, execute};

/// Time between two looks at the object.
const TICK: Duration = Duration::from_millis(50);
/// Time without a look after which the program counts as suspended: whoever was told to step back can no longer tell when the arm moves.
const HELD: Duration = Duration::from_secs(1);

/// What a strike recorded for its log.
#[derive(Clone, Debug, Default)]
pub struct Recorded {
    /// The robot's samples, and the camera's of a robot that has one of its own.
    pub samples: Samples,
    /// Messages of live topics.
    pub received: Vec<Received>,
    /// A warning for the operator.
    pub warning: Option<String>,
    /// Where the tip passed through the place of an object that was not moved: what that tells.
    pub unmoved: Option<&'static str>,
}

/// A strike that was not made, or not finished.
#[derive(Debug)]
pub struct Unfinished {
    /// What was recorded until then; none where nothing was.
    pub recorded: Option<Recorded>,
    /// Why.
    pub error: RobotError,
}

/// An object, and something that strikes it.
pub trait Station {
    /// Tells the station how many strikes were made before.
    fn goes_on(&mut self, _strikes: usize) {}

    /// Bytes that the messages of a strike may come to.
    fn room(&self) -> u64;

    /// Waits until the object lies ready, wherever that is; `requested` is where it would best lie, in m. Reports what it waits for.
    fn object(
        &mut self,
        requested: Point,
        report: &mut dyn FnMut(CollectEvent),
    ) -> Result<Resting, CollectError>;

    /// Whether a hand puts the object back, which may put it where nothing can be struck.
    fn is_by_hand(&self) -> bool;

    /// Strikes it.
    fn strike(&mut self, plan: &Plan) -> Result<Recorded, Box<Unfinished>>;

    /// Tells the station that the strike's record was written, or that a person was told why not.
    fn recorded(&mut self) {}
}

/// The embedded rig, whose object lies where the request wants it.
#[cfg(feature = "sim")]
pub struct SimStation {
    rig: Rig,
    truth: Option<PathBuf>,
    strikes: usize,
}

#[cfg(feature = "sim")]
impl SimStation {
    /// The rig of a `truth.json`, or the demo's.
    pub fn new(rig: &Rig, truth: Option<PathBuf>) -> Self {
        Self {
            rig: rig.clone(),
            truth,
            strikes: 0,
        }
    }
}

#[cfg(feature = "sim")]
impl Station for SimStation {
    fn goes_on(&mut self, strikes: usize) {
        self.strikes = strikes;
    }

    fn is_by_hand(&self) -> bool {
        false
    }

    fn room(&self) -> u64 {
        0
    }

    fn object(
        &mut self,
        requested: Point,
        _: &mut dyn FnMut(CollectEvent),
    ) -> Result<Resting, CollectError> {
        Ok(Resting::at(requested))
    }

    fn strike(&mut self, plan: &Plan) -> Result<Recorded, Box<Unfinished>> {
        let source = self
            .truth
            .as_deref()
            .map_or(TruthSource::Demo, TruthSource::File);
        let mut robot = SimRobot::open(&self.rig, source, self.strikes, None).map_err(|error| {
            Box::new(Unfinished {
                recorded: None,
                error,
            })
        })?;
        recorded(execute(&mut robot, plan), Vec::new())
    }
}

/// An arm, claimed for the whole collection, and a camera's live topics.
pub struct ArmStation<D: Arm> {
    robot: Guarded<D>,
    live: Arc<Live>,
    interrupted: Arc<AtomicBool>,
    /// How long the object lies still before the arm moves.
    pause: Duration,
    memory: Memory,
    /// The object as it was seen ready.
    ready: Option<Resting>,
    /// Both clocks as read after the strike before.
    before: Option<Epoch>,
}

impl<D: Arm> ArmStation<D> {
    /// The object must lie still for `pause` before the arm moves: time to step back. `interrupted` ends the waiting. The folder `memory`
    /// holds where the arm's last strike left the object.
    pub fn new(
        mut robot: Guarded<D>,
        live: Live,
        pause: Duration,
        interrupted: Arc<AtomicBool>,
        memory: &Path,
    ) -> Result<Self, CollectError> {
        let memory = Memory::open(memory, robot.serial())?;
        robot.resumes_from(memory.left());
        // Nobody is told to step back from an arm that is not as the rig file says.
        robot.is_set_up()?;
        Ok(Self {
            memory,
            robot,
            live: Arc::new(live),
            interrupted,
            pause,
            ready: None,
            before: None,
        })
    }
}

impl<D: Arm> Station for ArmStation<D> {
    fn is_by_hand(&self) -> bool {
        true
    }

    fn room(&self) -> u64 {
        self.live.room()
    }

    fn object(
        &mut self,
        _: Point,
        report: &mut dyn FnMut(CollectEvent),
    ) -> Result<Resting, CollectError> {
        if let Some(lost) = self.memory.lost() {
            report(CollectEvent::Lost(lost));
        }
        let mut still: Option<(Resting, Instant)> = None;
        let mut looked = (Instant::now(), Epoch::now());
        loop {
            // Held by `kill -STOP`, by a machine that stalls, or asleep, which one clock alone shows.
            if looked.0.elapsed() > HELD || looked.1.was_set().is_some() {
                still = None;
            }
            looked = (Instant::now(), Epoch::now());
            if self.interrupted.load(Ordering::Relaxed) {
                return Err(CollectError::Interrupted);
            }
            // Nobody is told to step back from an arm that will not move.
            self.robot.is_free()?;
            match self.live.at_rest() {
                Ok(rest) if self.memory.is_at(rest.point) => {
                    still = None;
                    report(CollectEvent::Waiting(format!(
                        "it lies within 2 cm of where it stopped, or was first seen after that: put it elsewhere (as {} says)",
                        self.memory.path().display()
                    )));
                }
                Ok(rest) => match still {
                    None => {
                        report(CollectEvent::StepBack(self.pause));
                        // From when it was told: a terminal may have held it back.
                        still = Some((rest, Instant::now()));
                        looked = (Instant::now(), Epoch::now());
                    }
                    Some((before, _)) if self.live.is_still(&before).is_err() => still = None,
                    Some((_, since)) if since.elapsed() >= self.pause => {
                        self.ready = Some(rest);
                        return Ok(rest);
                    }
                    Some(_) => {}
                },
                Err(LiveError::NotAtRest(why)) => {
                    still = None;
                    report(CollectEvent::Waiting(why));
                }
                Err(error) => return Err(error.into()),
            }
            thread::sleep(TICK);
        }
    }

    fn strike(&mut self, plan: &Plan) -> Result<Recorded, Box<Unfinished>> {
        let rest = self.ready.take().unwrap_or(Resting::at(plan.from));
        let watched = Watched::new(self.live.clone(), rest);
        let (outcome, seen) = strike_and_keep(
            &mut self.robot,
            plan,
            Some(&watched),
            &mut self.memory,
            &self.interrupted,
        );
        let set = self
            .before
            .replace(plan.epoch().anew())
            .and_then(|before| before.was_set_between());
        let (received, warning, unmoved) = seen.map_or_else(Default::default, |seen| {
            (seen.received, seen.warning, seen.unmoved)
        });
        recorded(outcome, received).map(|recorded| Recorded {
            warning: [recorded.warning.or(warning), set]
                .into_iter()
                .flatten()
                .reduce(|one, other| format!("{one}; {other}")),
            unmoved,
            ..recorded
        })
    }

    fn recorded(&mut self) {
        self.memory.recorded();
    }
}

/// The part of a strike's outcome that is kept.
fn recorded(
    outcome: Result<Option<StrikeRecord>, RobotError>,
    received: Vec<Received>,
) -> Result<Recorded, Box<Unfinished>> {
    match outcome {
        Ok(Some(struck)) => Ok(Recorded {
            samples: struck.samples,
            received,
            warning: struck.warning,
            unmoved: None,
        }),
        Ok(None) => Ok(Recorded::default()),
        Err(error) => {
            let kept = error.samples().map(|samples| Recorded {
                samples: samples.clone(),
                received,
                ..Recorded::default()
            });
            Err(Box::new(Unfinished {
                recorded: kept,
                error,
            }))
        }
    }
}
