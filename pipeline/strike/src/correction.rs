//! What a residual adds to the world's command, and how far it may.

use std::sync::Arc;

use store::{LaunchMap, Networks, ResidualModel, TrainingExtent};
use values::{Command, Conditions, Interval, Point, Table};
use world::{Shift, Simulated, Simulator, SolveSettings, SolveStatus};

use crate::Reason;
use crate::limits::{self, BrokenLimit, refuse_if};

/// Distance beyond the commands learnt from up to which a launch map is asked, in half widths of their range: the arm's own scatter about its
/// outermost commands, and no more.
const BEYOND: f64 = 0.1;
/// Excess over what a residual adds on the strikes that it learnt from, up to which it may add, in half widths of that range. Between strikes and at
/// the trained region's edge it goes on smoothly; one that adds more is not the one that was judged.
const BEYOND_ADDED: f64 = 1.0;

/// A residual and the world that it adds to.
pub(crate) enum Correction {
    /// The world in which the arm delivers what the map says.
    Launch(Box<Simulator>, LaunchMap),
    /// The paper's networks, and the world that they were trained in: how the table differs today is no matter of theirs.
    Networks(Box<Simulator>, Networks),
}

impl Correction {
    /// The correction of a version's model beside the world alone; none where the model adds nothing.
    pub(crate) fn in_world(alone: &Simulator, residual: Option<&ResidualModel>) -> Option<Self> {
        let same = alone.shifted(alone.shift());
        Some(match residual? {
            ResidualModel::Launch(map) => {
                let delivering = same.with_delivery(Arc::new(map.clone()));
                Self::Launch(Box::new(delivering), map.clone())
            }
            ResidualModel::Networks(networks) => {
                Self::Networks(Box::new(alone.as_identified()), networks.clone())
            }
        })
    }

    /// This correction on a table that differs by `shift` from the world's own; networks do not change with it.
    pub(crate) fn shifted(&self, shift: Shift) -> Self {
        match self {
            Self::Launch(delivering, map) => {
                Self::Launch(Box::new(delivering.shifted(shift)), map.clone())
            }
            Self::Networks(usual, networks) => {
                Self::Networks(Box::new(usual.as_identified()), networks.clone())
            }
        }
    }

    /// The world in which the arm delivers what a launch map says; none for networks.
    pub(crate) fn delivering(&self) -> Option<&Simulator> {
        match self {
            Self::Launch(delivering, _) => Some(delivering),
            Self::Networks(..) => None,
        }
    }

    /// The command of the world alone, and the one to send.
    pub(crate) fn commands(
        &self,
        alone: &Simulator,
        from: Point,
        to: Point,
        conditions: &Conditions,
    ) -> Result<(Command, Command), BrokenLimit> {
        match self {
            Self::Networks(usual, networks) => {
                let simulated = solved(alone, from, to, conditions)?;
                let path = to - from;
                let learnt_at = if alone.is_as_identified() {
                    simulated
                } else {
                    solved(usual, from, to, conditions)?
                };
                let [d_speed, d_angle] =
                    networks.predict([path.x, path.y, learnt_at.speed, learnt_at.angle]);
                let command = Command::new(simulated.speed + d_speed, simulated.angle + d_angle);
                Ok((simulated, command))
            }
            Self::Launch(delivering, map) => {
                let command = solved(delivering, from, to, conditions)?;
                let outside = map.outside(command);
                refuse_if(outside > BEYOND, Reason::OutsideTrainedRegion, || {
                    format!(
                        "the command {:.4} m/s at {:.4} rad lies {:.0} % of half the range of those learnt from outside it; choose a \
                         target among the training strikes' stops, or train on strikes that go there",
                        command.speed,
                        command.angle,
                        100.0 * outside
                    )
                })?;
                // The world alone may not reach this target: its nearest command is then the simulated one.
                let settings = SolveSettings::default();
                let nearest = alone.worker().solve(from, to, conditions, &settings, None);
                Ok((nearest.command, command))
            }
        }
    }

    /// Checks that what the residual adds lies within what it adds on the strikes that it learnt from, or a little beyond.
    pub(crate) fn check_added(
        &self,
        explained: &TrainingExtent,
        simulated: Command,
        command: Command,
    ) -> Result<(), BrokenLimit> {
        let [d_speed, d_angle] = match self {
            Self::Networks(..) => [
                command.speed - simulated.speed,
                command.angle - simulated.angle,
            ],
            Self::Launch(_, map) => map.added(command),
        };
        limits::added("m/s", d_speed, wider(explained.d_speed))?;
        limits::added("rad", d_angle, wider(explained.d_angle))
    }

    /// What the object does when it is struck with the final command; `object` is what it does in the world alone.
    ///
    /// An arm that delivers far less than it is commanded would, by the world alone, throw the object off the table: with a map of what
    /// it delivers, the object moves as in the world where the map acts.
    pub(crate) fn moved(
        &self,
        table: &Table,
        object: Simulated,
        simulate: impl FnOnce(&Simulator) -> Result<Simulated, BrokenLimit>,
    ) -> Result<Simulated, BrokenLimit> {
        match self {
            Self::Networks(..) => {
                limits::shifted_on_table(table, object.stop)?;
                Ok(object)
            }
            Self::Launch(delivering, _) => simulate(delivering),
        }
    }

    /// Root mean square error to expect of a launch map at a command, beyond the scatter of strikes, as a share of the path's length: distance goes
    /// as speed squared, bearing as angle.
    pub(crate) fn unsure(&self, command: Command) -> f64 {
        let Self::Launch(_, map) = self else {
            return 0.0;
        };
        let [speed, angle] = map.offset(command).deviation;
        let parts = map.parts();
        let beyond = |deviation: f64, scatter: f64| (deviation * deviation - scatter).max(0.0);
        (4.0 * beyond(speed, parts.speed.scatter) + beyond(angle, parts.angle.scatter)).sqrt()
    }

    /// Mean distance to expect between stop and target, as a share of the path's length: the misses of the training's held-out commands and, with a
    /// launch map, its own uncertainty at this command.
    pub(crate) fn expected_miss(&self, explained: &TrainingExtent, command: Command) -> f64 {
        match self {
            Self::Networks(..) => explained.miss,
            Self::Launch(_, map) => explained.calibration * map.offset(command).expected_miss(),
        }
    }
}

/// The range, widened by [`BEYOND_ADDED`] on each side.
fn wider(range: Interval) -> Interval {
    let by = 0.5 * BEYOND_ADDED * (range.high - range.low);
    Interval {
        low: range.low - by,
        high: range.high + by,
    }
}

/// The command that brings the object to rest at `to`, or why there is none.
pub(crate) fn solved(
    world: &Simulator,
    from: Point,
    to: Point,
    conditions: &Conditions,
) -> Result<Command, BrokenLimit> {
    let settings = SolveSettings::default();
    let solution = world.worker().solve(from, to, conditions, &settings, None);
    match solution.status {
        SolveStatus::Solved => Ok(solution.command),
        SolveStatus::Unreachable => Err((
            Reason::Unreachable,
            format!(
                "after {} simulations the nearest strike, {:.4} m/s at {:.4} rad, stops {:.1} mm from `to`; \
                 choose another target, or lay the object elsewhere",
                solution.evaluations,
                solution.command.speed,
                solution.command.angle,
                solution.miss * 1e3
            ),
        )),
        SolveStatus::Diverged => Err((
            Reason::Diverged,
            format!(
                "none of {} simulations came to rest; check the artifact's world, or use another --model",
                solution.evaluations
            ),
        )),
    }
}
