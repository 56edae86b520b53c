//! MuJoCo's impacts as commanded and a little beside each.

use std::collections::BTreeMap;

use values::{Command, Conditions, Rig};

use super::Launch;
use crate::{Impact, Simulator, Worker, World, WorldError, parameter, releases::Scaled};

/// What is changed beside an impact, and by how much: relative speed, angle (rad), offset of the tip (m), restitution.
const STEPS: [f64; 4] = [0.08, 0.04, 0.003, 0.1];
/// Place of the tip's friction beside them, and by how much its logarithm is changed: none of it matters to a round object that is struck through its
/// centre.
const TIP_FRICTION: (usize, f64) = (STEPS.len(), 0.1);

/// The launches around these strikes' commands in a world, its effects left out; `None` where the object does not leave the tip.
pub fn launches<'s>(
    rig: &Rig,
    world: &World,
    strikes: impl IntoIterator<Item = (Command, &'s Conditions)>,
) -> Result<Vec<Option<Launch>>, WorldError> {
    let restitution = world.value("restitution")?;
    let impacts: Vec<Impact> = strikes
        .into_iter()
        .map(|(command, conditions)| Impact::of(&[], restitution, command, conditions))
        .collect();
    launches_about(rig, world, &impacts)
}

/// The launches around these impacts; effects of the world do not act.
///
/// How a round object leaves the tip depends on no angle: a few speeds then serve all impacts, whose tip offset is one, and whose
/// restitution depends on their speed at the most.
pub fn launches_about(
    rig: &Rig,
    world: &World,
    impacts: &[Impact],
) -> Result<Vec<Option<Launch>>, WorldError> {
    let simulator = Simulator::new(rig, world)?;
    let all = |impacts: &[Impact]| -> Vec<Option<Launch>> {
        simulator.map(impacts, |worker, about| launch(worker, *about))
    };
    if !rig.object.shape().is_round() {
        return beside_tip_friction(rig, world, impacts, all(impacts));
    }
    let rung = |impact: &Impact| (impact.command.speed.ln() / STEPS[0]).round() as i64;
    let rungs: BTreeMap<i64, Impact> = impacts
        .iter()
        .map(|impact| {
            let command = Command::new((rung(impact) as f64 * STEPS[0]).exp(), 0.0);
            let middle = Impact {
                command,
                yaw: 0.0,
                ..*impact
            };
            (rung(impact), middle)
        })
        .collect();
    let middles: Vec<Impact> = rungs.values().copied().collect();
    let ladder: BTreeMap<i64, Option<Launch>> = rungs.into_keys().zip(all(&middles)).collect();
    Ok(impacts
        .iter()
        .map(|impact| {
            let mut launch = ladder[&rung(impact)]?;
            launch.about.command.angle = impact.command.angle;
            launch.about.yaw = impact.yaw;
            Some(launch)
        })
        .collect())
}

/// The launches with what another friction of the tip does to each.
fn beside_tip_friction(
    rig: &Rig,
    world: &World,
    impacts: &[Impact],
    mut launches: Vec<Option<Launch>>,
) -> Result<Vec<Option<Launch>>, WorldError> {
    let (place, step) = TIP_FRICTION;
    let friction = world.value("tip_friction")?;
    // A tip that holds so well slips nowhere.
    if friction * step.exp() > parameter("tip_friction")?.high {
        return Ok(launches);
    }
    let with = |change: f64| -> Result<Vec<Option<Scaled>>, WorldError> {
        let other = world.clone().with("tip_friction", friction * change.exp());
        let simulator = Simulator::new(rig, &other)?;
        Ok(simulator.map(impacts, |worker, about| {
            let release = worker.release(*about)?;
            Some(release.scaled(about.command.speed))
        }))
    };
    let (more, less) = (with(step)?, with(-step)?);
    for (launch, (more, less)) in launches.iter_mut().zip(more.into_iter().zip(less)) {
        *launch = launch.and_then(|mut launch| {
            launch.bends(place, step, more?, less?);
            Some(launch)
        });
    }
    Ok(launches)
}

fn launch(worker: &mut Worker<'_>, about: Impact) -> Option<Launch> {
    let mut at = |away: [f64; 4]| {
        let speed = about.command.speed * (1.0 + away[0]);
        let angle = about.command.angle + away[1];
        worker
            .release(Impact {
                command: Command { speed, angle },
                tip_offset: about.tip_offset + away[2],
                restitution: about.restitution + away[3],
                ..about
            })
            .map(|release| release.scaled(speed))
    };
    let base = at([0.0; 4])?;
    let mut launch = Launch {
        about: Impact {
            tip_friction: 0.0,
            ..about
        },
        base,
        slope: [[0.0; 6]; 5],
        bend: [[0.0; 6]; 5],
    };
    for (direction, step) in STEPS.iter().enumerate() {
        let mut away = [0.0; 4];
        away[direction] = *step;
        let after = at(away)?;
        away[direction] = -step;
        launch.bends(direction, *step, after, at(away)?);
    }
    Some(launch)
}
