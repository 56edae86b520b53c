//! How each strike's object leaves the tip: MuJoCo's blow as commanded and a little beside it, interpolated.
//!
//! A candidate that changes the command, the tip's line or restitution then needs no simulation of contact at all.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;
use values::{Command, Rig, Shape};

use crate::{Blow, Release, Simulator, Worker, World, WorldError, release::Scaled};

/// What is changed beside a blow, and by how much: relative speed, angle (rad), offset of the tip (m), restitution.
const STEPS: [f64; 4] = [0.08, 0.04, 0.003, 0.1];

/// One strike's release around its command: a parabola in each of four directions.
#[derive(Clone, Copy, Debug)]
pub struct Launch {
    command: Command,
    restitution: f64,
    base: Scaled,
    slope: [Scaled; 4],
    bend: [Scaled; 4],
}

impl Launch {
    /// The release of this strike for a blow near its command.
    pub fn release(&self, blow: &Blow) -> Release {
        let away = [
            blow.command.speed / self.command.speed - 1.0,
            blow.command.angle - self.command.angle,
            blow.tip_offset,
            blow.restitution - self.restitution,
        ];
        let mut state = self.base;
        for ((away, slope), bend) in away.iter().zip(&self.slope).zip(&self.bend) {
            for i in 0..state.len() {
                state[i] += away * (slope[i] + away * bend[i]);
            }
        }
        Release::of(state, blow.command)
    }
}

/// The launches around these commands in a world, its effects left out; `None` where the object does not leave the tip.
///
/// How a round object leaves the tip depends on no angle: a few speeds then serve all strikes.
pub fn launches(
    rig: &Rig,
    world: &World,
    commands: &[Command],
) -> Result<Vec<Option<Launch>>, WorldError> {
    let simulator = Simulator::new(rig, world)?;
    let restitution = world.value("restitution")?;
    let all = |commands: &[Command]| -> Vec<Option<Launch>> {
        commands
            .par_iter()
            .map_init(
                || simulator.worker(),
                |worker, command| launch(worker, *command, restitution),
            )
            .collect()
    };
    if rig.object.shape == Shape::Box {
        return Ok(all(commands));
    }
    let rung = |speed: f64| (speed.ln() / STEPS[0]).round();
    let rungs: BTreeSet<i64> = commands.iter().map(|c| rung(c.speed) as i64).collect();
    let speeds: Vec<Command> = rungs
        .iter()
        .map(|rung| Command {
            speed: (*rung as f64 * STEPS[0]).exp(),
            angle: 0.0,
        })
        .collect();
    let ladder: BTreeMap<i64, Option<Launch>> = rungs.into_iter().zip(all(&speeds)).collect();
    Ok(commands
        .iter()
        .map(|command| {
            let mut launch = ladder[&(rung(command.speed) as i64)]?;
            launch.command.angle = command.angle;
            Some(launch)
        })
        .collect())
}

fn launch(worker: &mut Worker<'_>, command: Command, restitution: f64) -> Option<Launch> {
    let mut at = |away: [f64; 4]| {
        let speed = command.speed * (1.0 + away[0]);
        let angle = command.angle + away[1];
        worker
            .release(Blow {
                command: Command { speed, angle },
                tip_offset: away[2],
                restitution: restitution + away[3],
            })
            .map(|release| release.scaled(speed))
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
            bend[direction][i] = (after[i] + before[i] - 2.0 * base[i]) / (2.0 * step * step);
        }
    }
    Some(Launch {
        command,
        restitution,
        base,
        slope,
        bend,
    })
}
