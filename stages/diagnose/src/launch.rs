//! How each strike's object leaves the tip: MuJoCo's blow as commanded and a little beside it, interpolated.
//!
//! A candidate that changes the command, the tip's line or restitution then needs no simulation of contact at all.

use rayon::prelude::*;
use values::{Command, Point, Rig, Strike};
use world::{Release, Simulator, World, WorldError};

/// What is changed beside a blow, and by how much: relative speed, angle (rad), offset of the tip (m), factor on restitution.
const STEPS: [f64; 4] = [0.08, 0.04, 0.003, 0.2];

/// A blow, as the arm delivers it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blow {
    pub(crate) command: Command,
    /// Lateral offset of the tip's line, in m to the left.
    pub(crate) tip_offset: f64,
    /// Factor on the restitution of the world that the blows were simulated in.
    pub(crate) restitution: f64,
}

/// What varies of a release: time, position and velocity in the frame of the blow, spin; positions per m, speeds and spin
/// per m/s of the tip's speed.
type State = [f64; 6];

/// One strike's release around its command: a parabola in each of four directions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Launch {
    command: Command,
    base: State,
    slope: [State; 4],
    bend: [State; 4],
}

fn state(release: Release, speed: f64) -> State {
    [
        release.time,
        release.position.x,
        release.position.y,
        release.velocity.x / speed,
        release.velocity.y / speed,
        release.spin / speed,
    ]
}

impl Launch {
    /// The release of this strike for a blow near its command.
    pub(crate) fn release(&self, blow: &Blow) -> Release {
        let away = [
            blow.command.speed / self.command.speed - 1.0,
            blow.command.angle - self.command.angle,
            blow.tip_offset,
            blow.restitution - 1.0,
        ];
        let mut state = self.base;
        for ((away, slope), bend) in away.iter().zip(&self.slope).zip(&self.bend) {
            for i in 0..state.len() {
                state[i] += away * (slope[i] + away * bend[i]);
            }
        }
        let [time, x, y, vx, vy, spin] = state;
        let (angle, speed) = (blow.command.angle, blow.command.speed);
        Release {
            time,
            position: Point::new(x, y).rotated(angle),
            velocity: Point::new(vx, vy).rotated(angle) * speed,
            spin: spin * speed,
        }
    }
}

/// The launches of all strikes in a world without effects; `None` for a strike whose object does not leave the tip.
pub(crate) fn launches(
    rig: &Rig,
    world: &World,
    strikes: &[&Strike],
) -> Result<Vec<Option<Launch>>, WorldError> {
    let simulator = Simulator::new(rig, world)?;
    Ok(strikes
        .par_iter()
        .map_init(
            || simulator.worker(),
            |worker, strike| {
                let command = strike.command;
                let mut at = |away: [f64; 4]| {
                    let speed = command.speed * (1.0 + away[0]);
                    let angle = command.angle + away[1];
                    worker
                        .release(Command { speed, angle }, away[2], 1.0 + away[3])
                        .map(|release| state(release, speed))
                };
                let base = at([0.0; 4])?;
                let (mut slope, mut bend) = ([[0.0; 6]; 4], [[0.0; 6]; 4]);
                for (direction, step) in STEPS.iter().enumerate() {
                    let mut away = [0.0; 4];
                    away[direction] = *step;
                    let after = at(away)?;
                    away[direction] = -step;
                    let before = at(away)?;
                    for i in 0..base.len() {
                        slope[direction][i] = (after[i] - before[i]) / (2.0 * step);
                        bend[direction][i] =
                            (after[i] + before[i] - 2.0 * base[i]) / (2.0 * step * step);
                    }
                }
                Some(Launch {
                    command,
                    base,
                    slope,
                    bend,
                })
            },
        )
        .collect())
}
