//! What tip and object do for a command: the tip's way, where the arm may go all along it, and the object's slide in a world.

use values::{Command, Conditions, Point, Rig};
use world::{Simulated, Simulator};

use crate::limits::BrokenLimit;
use crate::stroke::Stroke;
use crate::{Reason, clearance};

/// Number of speeds that are tried to say which one would fit.
const SPEEDS: u32 = 60;

/// The motion of the tip, where the arm may go all along it.
pub(crate) fn stroke(
    rig: &Rig,
    simulator: &Simulator,
    from: Point,
    command: Command,
    conditions: &Conditions,
) -> Result<Stroke, BrokenLimit> {
    let profile = simulator.profile(from, command, conditions).ok_or_else(|| {
            (
                Reason::Unreachable,
                format!(
                    "the tip passes beside the object at {:.4} rad; lay the object more in line with its target",
                    command.angle
                ),
            )
        })?;
    let standoff = profile.strike.distance(from);
    let at = |speed: f64| {
        let command = Command { speed, ..command };
        let stroke = Stroke::plan(from, command, &rig.robot, standoff);
        let ends = [("start", stroke.start), ("stop", stroke.stop)];
        clearance::path(rig, &ends).map(|()| stroke)
    };
    at(command.speed).map_err(|(reason, detail)| {
            let low = rig.robot.speed.low;
            let fitting = (0..=SPEEDS)
                .map(|step| command.speed + (low - command.speed) * f64::from(step) / f64::from(SPEEDS))
                .find(|speed| at(*speed).is_ok());
            let mend = match fitting {
                Some(speed) => format!(
                    "at this place and angle up to {speed:.3} m/s would fit: choose a target nearer to the object, or lay the object \
                     farther from what is in the way"
                ),
                None => "no speed of robot.speed fits at this place and angle: lay the object elsewhere".into(),
            };
            (reason, format!("at {:.4} m/s {detail}; {mend}", command.speed))
        })
}

/// What the object does when it is struck with the final command, in a world.
pub(crate) fn object(
    world: &Simulator,
    from: Point,
    command: Command,
    conditions: &Conditions,
) -> Result<Simulated, BrokenLimit> {
    let mut worker = world.worker();
    worker.strike(from, command, conditions).map_err(|error| {
        (
            Reason::Diverged,
            format!(
                "the final command, residual included, has no end: {error}; use another --model"
            ),
        )
    })
}
