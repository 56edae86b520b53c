//! The friction of the tip on a box's face, by how strikes leave the tip.
//!
//! A tip that sticks says only that its friction is enough: a small step shows nothing, and a fit that begins there ends there. Where it
//! slips, a box leaves at no more than the friction cone's angle and loses speed, which a fit takes for scatter of launches. So a fit begins at
//! the friction by which MuJoCo's impacts alone are nearest to the launches that tracks show, and the launches that it then gives each strike
//! are held against those by other frictions.

use nalgebra::{DMatrix, DVector};
use values::{Point, Rig, Strike, median};
use world::{Impact, Simulator, World, WorldError, parameter};

use crate::{
    compare::Launch,
    fit::Fitted,
    identify::WORTH,
    scatter::{ANGLE, SPEED},
    start::{HOLDS, heading, holds},
};

/// Least friction of the tip that is tried, the factor from each to the next, and their number.
const LEAST: f64 = 0.08;
const FURTHER: f64 = 1.1;
const LOOKED_AT: i32 = 30;
/// Number of strikes simulated before a fit, and the scatter of launches assumed then, relative and in rad: clocks and slides are not known yet.
const STRIKES: usize = 40;
const SCATTER: f64 = 0.03;
/// Deviation, in units of that scatter, with which a strike counts that does not leave the tip.
const STAYS: f64 = 5.0;
/// Least number of strikes that tell the tip's friction.
const FEWEST: usize = 8;

/// The frictions of the tip that are tried, every second one before a fit.
fn frictions(step: usize) -> impl Iterator<Item = f64> {
    (0..LOOKED_AT)
        .step_by(step)
        .map(|k| LEAST * FURTHER.powi(k))
}

/// The world from which a fit begins, with the tip's friction and the restitution by which impacts are nearest to the launches that tracks
/// show, where that is beyond chance. Only where the tip's friction was not set.
pub(crate) fn start(rig: &Rig, world: World, all: &[&Strike]) -> Result<World, WorldError> {
    if rig.object.shape().is_round() || world.parameters.contains_key(HOLDS) {
        return Ok(world);
    }
    let seen: Vec<(&Strike, [f64; 2])> = all
        .iter()
        .step_by(all.len().div_ceil(STRIKES).max(1))
        .filter(|strike| !strike.conditions.is_unstruck)
        .filter_map(|strike| {
            let (_, speed) = strike.release()?;
            let aside = Point::polar(1.0, heading(strike)? - strike.command.angle).bearing();
            Some((*strike, [speed.max(1e-9).ln(), aside]))
        })
        .collect();
    if seen.len() < FEWEST {
        return Ok(world);
    }
    let (strikes, seen): (Vec<&Strike>, Vec<[f64; 2]>) = seen.into_iter().unzip();
    let spec = parameter("restitution")?;
    // Twice the negative logarithm of a likelihood (Cauchy's, for mishits), and the world with its restitution.
    let far = |mut world: World| -> Result<(f64, World), WorldError> {
        let mut far = (f64::INFINITY, world.clone());
        for _ in 0..2 {
            let launched = launches(rig, &world, Launch::EXACT, &strikes)?;
            let off = |j: usize| -> Vec<f64> {
                let pairs = seen.iter().zip(&launched);
                pairs
                    .filter_map(|(seen, launched)| Some(seen[j] - (*launched)?[j]))
                    .collect()
            };
            let (speeds, angles) = (off(0), off(1));
            let faster = median(speeds.clone()).unwrap_or(0.0);
            let turned = median(angles.clone()).unwrap_or(0.0);
            // Of one that does not leave the tip, more than any scatter.
            let stays = (seen.len() - speeds.len()) as f64 * STAYS.powi(2).ln_1p();
            let of = |all: &[f64], middle: f64| -> f64 {
                let each = all.iter().map(|v| ((v - middle) / SCATTER).powi(2).ln_1p());
                each.sum::<f64>() + stays
            };
            far = (
                2.0 * (of(&speeds, faster) + of(&angles, turned)),
                world.clone(),
            );
            let restitution = (1.0 + world.value("restitution")?) * faster.exp() - 1.0;
            world = world.with("restitution", restitution.clamp(spec.low, spec.high));
        }
        Ok(far)
    };
    let (mut least, mut best) = (far(world.clone())?.0 - WORTH, None);
    for friction in frictions(2) {
        let (far, other) = far(world.clone().with(HOLDS, friction))?;
        if far < least {
            (least, best) = (far, Some(other));
        }
    }
    Ok(best.unwrap_or(world))
}

/// How each strike leaves the tip: logarithm of its speed, and its angle beside the tip's in rad; none of one that does not leave it.
fn launches(
    rig: &Rig,
    world: &World,
    launch: Launch,
    strikes: &[&Strike],
) -> Result<Vec<Option<[f64; 2]>>, WorldError> {
    let restitution = world.value("restitution")?;
    let impacts: Vec<Impact> = strikes
        .iter()
        .map(|strike| {
            let command = launch.of(strike.command);
            Impact::of(&[], restitution, command, &strike.conditions)
        })
        .collect();
    Ok(Simulator::new(rig, world)?.map(&impacts, |worker, impact| {
        let velocity = worker.release(*impact)?.velocity;
        Some([velocity.norm().max(1e-9).ln(), velocity.bearing()])
    }))
}

/// The world with the tip's friction under which the launches of a fit's strikes are likeliest, where that is beyond chance; `all`: strikes that the
/// tip must hold. Restitution, and a turn of all launches alike or by a share of their angle, are fitted anew beside each friction.
pub(crate) fn explained(
    rig: &Rig,
    fitted: &Fitted,
    all: &[&Strike],
) -> Result<Option<World>, WorldError> {
    let struck: Vec<usize> = (0..all.len())
        .filter(|i| !all[*i].conditions.is_unstruck)
        .collect();
    if rig.object.shape().is_round() || struck.len() < FEWEST {
        return Ok(None);
    }
    let strikes: Vec<&Strike> = struck.iter().map(|i| all[*i]).collect();
    let n = strikes.len();
    let as_fitted = launches(rig, &fitted.world, fitted.launch, &strikes)?;
    let weights = DVector::from_fn(n, |i, _| fitted.weights[struck[i]].sqrt());
    // What is fitted anew, as orthonormal columns.
    let basis = |columns: usize| {
        let powers = |i: usize, j: usize| strikes[i].command.angle.powi(j as i32);
        let beside = DMatrix::from_fn(n, columns, |i, j| weights[i] * powers(i, j));
        beside.qr().q()
    };
    let parts = [(SPEED, basis(1)), (ANGLE, basis(2))];
    // Twice the logarithm of a likelihood, the scatter of both estimated anew.
    let likelihood = |launched: &[Option<[f64; 2]>]| -> f64 {
        let of = |(j, (place, basis)): (usize, &(usize, DMatrix<f64>))| {
            let needed = DVector::from_fn(n, |i, _| {
                // One that does not leave the tip tells nothing.
                let moves = as_fitted[i].zip(launched[i]);
                let moves = moves.map_or(0.0, |(from, to)| from[j] - to[j]);
                weights[i] * (fitted.guesses[struck[i]][*place] + moves)
            });
            let left = &needed - basis * basis.tr_mul(&needed);
            -(n as f64) * left.norm_squared().max(1e-12).ln()
        };
        parts.iter().enumerate().map(of).sum()
    };
    let mut most = likelihood(&as_fitted) + WORTH;
    let mut best = None;
    for friction in frictions(1) {
        if !holds(rig, all, friction) {
            continue;
        }
        let other = fitted.world.clone().with(HOLDS, friction);
        let launched = launches(rig, &other, fitted.launch, &strikes)?;
        let likely = likelihood(&launched);
        if likely > most {
            (most, best) = (likely, Some(other));
        }
    }
    Ok(best)
}
