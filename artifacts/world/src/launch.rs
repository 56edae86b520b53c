//! How each strike's object leaves the tip: MuJoCo's blow as commanded and a little beside it, interpolated.
//!
//! A candidate that changes the command, the tip's line or restitution then needs no simulation of contact at all.

use std::collections::BTreeMap;

use rayon::prelude::*;
use values::{Command, Rig, Shape};

use crate::{Blow, Release, Simulator, Worker, World, WorldError, release::Scaled};

/// What is changed beside a blow, and by how much: relative speed, angle (rad), offset of the tip (m), restitution.
const STEPS: [f64; 4] = [0.08, 0.04, 0.003, 0.1];

/// One strike's release around its command: a parabola in each of four directions.
#[derive(Clone, Copy, Debug)]
pub struct Launch {
    about: Blow,
    base: Scaled,
    slope: [Scaled; 4],
    bend: [Scaled; 4],
}

impl Launch {
    /// The release of this strike for a blow near its command.
    pub fn release(&self, blow: &Blow) -> Release {
        let away = [
            blow.command.speed / self.about.command.speed - 1.0,
            blow.command.angle - self.about.command.angle,
            blow.tip_offset - self.about.tip_offset,
            blow.restitution - self.about.restitution,
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
pub fn launches(
    rig: &Rig,
    world: &World,
    commands: &[Command],
) -> Result<Vec<Option<Launch>>, WorldError> {
    let restitution = world.value("restitution")?;
    let blows: Vec<Blow> = commands
        .iter()
        .map(|command| Blow {
            command: *command,
            tip_offset: 0.0,
            restitution,
        })
        .collect();
    launches_about(rig, world, &blows)
}

/// The launches around these blows; effects of the world do not act.
///
/// How a round object leaves the tip depends on no angle: a few speeds then serve all blows, whose tip offset is one, and whose
/// restitution depends on their speed at the most.
pub fn launches_about(
    rig: &Rig,
    world: &World,
    blows: &[Blow],
) -> Result<Vec<Option<Launch>>, WorldError> {
    let simulator = Simulator::new(rig, world)?;
    let all = |blows: &[Blow]| -> Vec<Option<Launch>> {
        blows
            .par_iter()
            .map_init(
                || simulator.worker(),
                |worker, about| launch(worker, *about),
            )
            .collect()
    };
    if rig.object.shape == Shape::Box {
        return Ok(all(blows));
    }
    let rung = |blow: &Blow| (blow.command.speed.ln() / STEPS[0]).round() as i64;
    let rungs: BTreeMap<i64, Blow> = blows
        .iter()
        .map(|blow| {
            let command = Command {
                speed: (rung(blow) as f64 * STEPS[0]).exp(),
                angle: 0.0,
            };
            (rung(blow), Blow { command, ..*blow })
        })
        .collect();
    let middles: Vec<Blow> = rungs.values().copied().collect();
    let ladder: BTreeMap<i64, Option<Launch>> = rungs.into_keys().zip(all(&middles)).collect();
    Ok(blows
        .iter()
        .map(|blow| {
            let mut launch = ladder[&rung(blow)]?;
            launch.about.command.angle = blow.command.angle;
            Some(launch)
        })
        .collect())
}

fn launch(worker: &mut Worker<'_>, about: Blow) -> Option<Launch> {
    let mut at = |away: [f64; 4]| {
        let speed = about.command.speed * (1.0 + away[0]);
        let angle = about.command.angle + away[1];
        worker
            .release(Blow {
                command: Command { speed, angle },
                tip_offset: about.tip_offset + away[2],
                restitution: about.restitution + away[3],
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
        about,
        base,
        slope,
        bend,
    })
}
