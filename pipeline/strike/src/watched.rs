//! A strike that a camera watches: the object is looked at before the tip goes down and before it strikes, and until it rests again.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use logs::write::Received;

use crate::last_stop::{LastStop, Memory};
use crate::live::{Live, LiveError, Resting};
use crate::robot::arm::{Arm, Guarded, Look, RunUp};
use crate::{Plan, RobotError, StrikeRecord, execute};

/// How long the object is waited for to be seen at rest: after a strike, and after one that was not finished.
const AFTER: Duration = Duration::from_secs(15);
const AFTER_FAILURE: Duration = Duration::from_secs(2);

/// Least distance in m from where it lay of an object that a strike has moved.
const MOVED: f64 = 0.003;

/// An object that was seen at rest, and is to be struck there.
#[derive(Debug)]
pub struct Watched {
    live: Arc<Live>,
    rest: Resting,
    begun: Arc<Mutex<Option<Instant>>>,
}

/// Strikes, and keeps where that left the object, and until [`Memory::recorded`] that the strike has no record: whatever ends this program meanwhile,
/// the object may have been struck, and unseen rest is no permission to strike it again. Where that cannot be kept nothing is struck. Also gives what
/// the camera saw, if one watches and the tip came down to strike; `is_over` ends the waiting for that.
pub fn strike_and_keep<D: Arm>(
    robot: &mut Guarded<D>,
    plan: &Plan,
    watched: Option<&Watched>,
    memory: &mut Memory,
    is_over: &AtomicBool,
) -> (Result<Option<StrikeRecord>, RobotError>, Option<Seen>) {
    if let Some(watched) = watched {
        robot.look_first(watched.look(robot.run_up()));
    }
    let before = (memory.stop(), memory.left());
    robot.resumes_from(memory.left());
    if let Err(error) = memory.begin(robot.low_height()) {
        return (Err(robot.not_ready(format!("failed to {error}"))), None);
    }
    let outcome = execute(robot, plan);
    let left = match &outcome {
        Err(_) if robot.has_moved() => robot.left(plan),
        _ => None,
    };
    let seen = watched.and_then(|watched| watched.ended(plan, outcome.is_ok(), is_over));
    let may_have_struck = match (&outcome, watched) {
        (_, Some(_)) => seen.is_some(),
        (Ok(_), None) => true,
        (Err(error), None) => error.samples().is_some(),
    };
    let stop = match &seen {
        _ if !may_have_struck => before.0,
        Some(Seen { rest: Ok(rest), .. }) => LastStop::At(rest.point),
        _ => LastStop::Unseen(None),
    };
    memory.left_at(match outcome {
        Ok(_) => None,
        // Where no report says it, it is where the strike was to be made.
        Err(_) if robot.has_moved() => left.as_ref().map(|(at, _)| *at).or(memory.left()),
        Err(_) => before.1,
    });
    // What cannot be kept of it leaves a file that says less: that it was not seen to stop.
    let _ = memory.keep(stop);
    let has_record = match &outcome {
        Ok(struck) => struck.is_some(),
        Err(error) => error.samples().is_some(),
    };
    if !has_record {
        memory.recorded();
    }
    let robot_moved = robot.has_moved();
    let outcome = outcome.map_err(|error| match (error, left) {
        (
            RobotError::Interrupted {
                robot,
                why,
                samples,
            },
            left,
        ) => {
            let told = match left {
                Some((_, told)) => format!("; {told}"),
                None if robot_moved => String::new(),
                None => "; nothing has moved".into(),
            };
            RobotError::Interrupted {
                robot,
                why: why + &told,
                samples,
            }
        }
        (error, _) => error,
    });
    (outcome, seen)
}

/// What the camera saw of a strike.
#[derive(Debug)]
pub struct Seen {
    /// Where the object came to rest.
    pub rest: Result<Resting, LiveError>,
    /// All messages, in order of time.
    pub received: Vec<Received>,
    /// What was left out of the messages, for want of memory or of one clock.
    pub warning: Option<String>,
    /// Where the tip passed through the place of an object that was not moved: what that tells.
    pub unmoved: Option<&'static str>,
}

impl Seen {
    /// What the camera did not see of a strike that was made: that the object moved, or came to rest.
    pub fn doubt(&self) -> Option<String> {
        match &self.rest {
            Ok(_) => self.unmoved.map(str::to_owned),
            Err(error) => Some(format!("after the strike: failed to {error}")),
        }
    }
}

const UNMOVED: &str = "the tip passed through where the camera saw the object, and it was not moved: if the tip passed beside it, the rig file \
                       does not say where the arm stands (robot.base, base_yaw, base_height), or the camera's frame is not the table's; if \
                       it passed over it, look at robot.strike_height; if through it, the tracker takes another thing for the object";

impl Watched {
    /// A watched object that was seen at rest.
    pub fn new(live: Arc<Live>, rest: Resting) -> Self {
        Self {
            live,
            rest,
            begun: Arc::default(),
        }
    }

    /// A check that the object still lies there. From the last look on, everything is recorded, and the arm is stopped if the object is moved before
    /// the tip can touch it.
    fn look(&self, run_up: RunUp) -> impl FnMut(Look) -> Result<(), String> + Send + use<> {
        let (live, rest, begun) = (self.live.clone(), self.rest, self.begun.clone());
        move |when| {
            live.is_still(&rest)
                .map_err(|error| format!("failed to {error}"))?;
            if when == Look::BeforeStrike {
                live.record();
                let run_up = run_up.clone();
                live.watch(rest, move |at, why| run_up.stop(at, why));
                *begun.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
            }
            Ok(())
        }
    }

    /// Waits until the object rests again; none where the strike was never looked at last. `is_struck` says that the strike was made as
    /// planned; `is_over` ends the waiting too.
    pub fn ended(&self, plan: &Plan, is_struck: bool, is_over: &AtomicBool) -> Option<Seen> {
        let begun = *self.begun.lock().unwrap_or_else(PoisonError::into_inner);
        let patience = if is_struck { AFTER } else { AFTER_FAILURE };
        let rest = self.live.wait_for_stop(begun?, patience, is_over);
        let (mut received, mut warning) = self.live.recorded(plan.epoch());
        // Stamps of two clocks in one log would be a strike that never was.
        if let Some(set) = plan.epoch().was_set() {
            received.clear();
            warning = Some(format!("{set}: they are left out of its log"));
        }
        let is_unmoved = |rest: &Resting| rest.point.distance(self.rest.point) < MOVED;
        let unmoved = is_struck && rest.as_ref().is_ok_and(is_unmoved);
        Some(Seen {
            rest,
            received,
            warning,
            unmoved: unmoved.then_some(UNMOVED),
        })
    }
}

#[cfg(test)]
mod tests {
    use values::Point;

    use super::*;

    #[test]
    fn a_strike_whose_object_was_not_moved_or_not_seen_to_rest_is_in_doubt() {
        let there = Resting::at(Point::new(0.6, 0.0));
        for (rest, unmoved, said) in [
            (Ok(there), None, None),
            (Ok(there), Some(UNMOVED), Some("was not moved")),
            (
                Err(LiveError::NotAtRest("gone".into())),
                None,
                Some("at rest: gone"),
            ),
        ] {
            let seen = Seen {
                rest,
                received: Vec::new(),
                warning: None,
                unmoved,
            };
            let doubt = seen.doubt();
            assert_eq!(doubt.is_some(), said.is_some(), "{doubt:?}");
            assert!(doubt.unwrap_or_default().contains(said.unwrap_or_default()));
        }
    }
}
