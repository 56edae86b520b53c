//! What strikes in a collection: an arm and a camera, or the embedded rig.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use values::{Point, Rig};

use super::error::CollectError;
use crate::robot::xarm::{Ports, XArm};
use crate::{
    Live, LiveError, Plan, Received, RobotError, Samples, SimRobot, StrikeRecord, TruthSource,
    execute,
};

/// An object that was put back lies farther than this, in m, from where it stopped.
const PUT_BACK: f64 = 0.02;
/// It is waited for so long to come to rest after a strike.
const AFTER: Duration = Duration::from_secs(15);
/// How often it is looked at.
const TICK: Duration = Duration::from_millis(50);

/// What a strike recorded for its log.
#[derive(Clone, Debug, Default)]
pub struct Recorded {
    /// The robot's samples, and the camera's of a robot that has one of its own.
    pub samples: Samples,
    /// Messages of live topics.
    pub received: Vec<Received>,
    /// A warning for the operator.
    pub warning: Option<String>,
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
    /// How many strikes were made before, and where (m) the last usable one left the object.
    fn goes_on(&mut self, strikes: usize, last_stop: Option<Point>);

    /// Waits until the object lies ready, wherever that is; `requested` is where it would best lie. In m. Reports what it waits for.
    fn object(
        &mut self,
        requested: Point,
        report: &mut dyn FnMut(String),
    ) -> Result<Point, CollectError>;

    /// Whether a hand puts the object back, which may put it where nothing can be struck.
    fn is_by_hand(&self) -> bool;

    /// Strikes it.
    fn strike(&mut self, plan: &Plan) -> Result<Recorded, Box<Unfinished>>;
}

/// The embedded rig, whose object lies where the request wants it.
pub struct SimStation {
    rig: Rig,
    truth: Option<PathBuf>,
    strikes: usize,
}

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

impl Station for SimStation {
    fn goes_on(&mut self, strikes: usize, _: Option<Point>) {
        self.strikes = strikes;
    }

    fn is_by_hand(&self) -> bool {
        false
    }

    fn object(
        &mut self,
        requested: Point,
        _: &mut dyn FnMut(String),
    ) -> Result<Point, CollectError> {
        Ok(requested)
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

/// An xArm7 and a camera's live topics. Each strike connects to the arm anew.
pub struct ArmStation {
    name: String,
    ports: Ports,
    live: Arc<Live>,
    interrupted: Arc<AtomicBool>,
    /// The object lies still for so long before the arm moves.
    pause: Duration,
    stopped_at: Option<Point>,
}

impl ArmStation {
    /// The object must lie still for `pause` before the arm moves: time to step back. `interrupted` ends the waiting, and stops
    /// the arm.
    pub fn new(
        name: &str,
        ports: Ports,
        live: Live,
        pause: Duration,
        interrupted: Arc<AtomicBool>,
    ) -> Self {
        Self {
            name: name.into(),
            ports,
            live: Arc::new(live),
            interrupted,
            pause,
            stopped_at: None,
        }
    }

    /// Whether the object lies where its last strike left it.
    fn is_where_it_stopped(&self, place: Point) -> bool {
        self.stopped_at
            .is_some_and(|stop| stop.distance(place) < PUT_BACK)
    }
}

impl Station for ArmStation {
    fn goes_on(&mut self, _: usize, last_stop: Option<Point>) {
        self.stopped_at = self.stopped_at.or(last_stop);
    }

    fn is_by_hand(&self) -> bool {
        true
    }

    fn object(&mut self, _: Point, report: &mut dyn FnMut(String)) -> Result<Point, CollectError> {
        let mut still: Option<(Point, Instant)> = None;
        loop {
            if self.interrupted.load(Ordering::Relaxed) {
                return Err(LiveError::NotAtRest("it was interrupted by a signal".into()).into());
            }
            match self.live.at_rest() {
                Ok(rest) if self.is_where_it_stopped(rest.point) => {
                    still = None;
                    report("it lies within 2 cm of where it stopped: put it elsewhere".into());
                }
                Ok(rest) => {
                    let (place, since) = *still.get_or_insert((rest.point, Instant::now()));
                    if self.live.is_still_at(place).is_err() {
                        still = None;
                    } else if since.elapsed() >= self.pause {
                        return Ok(rest.point);
                    } else {
                        report("the arm moves in a moment: step back".into());
                    }
                }
                Err(LiveError::NotAtRest(why)) => {
                    still = None;
                    report(why);
                }
                Err(error) => return Err(error.into()),
            }
            thread::sleep(TICK);
        }
    }

    fn strike(&mut self, plan: &Plan) -> Result<Recorded, Box<Unfinished>> {
        let begun: Arc<Mutex<Option<Instant>>> = Arc::default();
        let (live, since, place) = (self.live.clone(), begun.clone(), plan.from);
        let check = move || {
            live.is_still_at(place)
                .map_err(|error| format!("failed to {error}"))?;
            live.record();
            *since.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
            Ok(())
        };
        let outcome = XArm::connect(&self.name, self.ports, plan.rig(), self.interrupted.clone())
            .map(|arm| arm.with_last_check(check))
            .and_then(|mut arm| execute(&mut arm, plan));
        let begun = *begun.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(begun) = begun else {
            return recorded(outcome, Vec::new());
        };
        let rest = self.live.wait_for_stop(begun, AFTER, &self.interrupted);
        let (received, left_out) = self.live.recorded();
        // Where it was not seen to stop, its log says so; wherever it lies then, it is to be put back.
        self.stopped_at = rest.ok().map(|rest| rest.point);
        recorded(outcome, received).map(|recorded| Recorded {
            warning: recorded.warning.or(left_out),
            ..recorded
        })
    }
}

/// What is kept of a strike's outcome.
fn recorded(
    outcome: Result<Option<StrikeRecord>, RobotError>,
    received: Vec<Received>,
) -> Result<Recorded, Box<Unfinished>> {
    match outcome {
        Ok(Some(struck)) => Ok(Recorded {
            samples: struck.samples,
            received,
            warning: struck.warning,
        }),
        Ok(None) => Ok(Recorded::default()),
        Err(error) => {
            let kept = error.samples().map(|samples| Recorded {
                samples: samples.clone(),
                received,
                warning: None,
            });
            Err(Box::new(Unfinished {
                recorded: kept,
                error,
            }))
        }
    }
}
