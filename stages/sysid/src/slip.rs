//! Whether a tip of another friction, which slips where strikes are aslant, explains how launches differ from the world's.
//!
//! A tip that sticks says only that its friction is enough: a small step shows nothing. Where it slips, a box leaves at no more than the
//! friction cone's angle and loses speed, which the fit takes for scatter of launches. So the launches that the fit gave each strike
//! are held against those by a few other frictions, in MuJoCo's impacts alone.

use nalgebra::{DMatrix, DVector};
use values::{Rig, Shape, Strike};
use world::{Impact, Simulator, World, WorldError};

use crate::{
    fit::Fitted,
    identify::WORTH,
    scatter::{ANGLE, SPEED},
    start::{HOLDS, holds},
};

/// Frictions that are looked at.
const LEAST: f64 = 0.08;
const FURTHER: f64 = 1.1;
const LOOKED_AT: i32 = 30;

/// How each strike leaves the tip: logarithm of its speed and its angle in rad, a row a strike. None where one does not leave it.
fn launches(
    rig: &Rig,
    world: &World,
    fitted: &Fitted,
    strikes: &[&Strike],
) -> Result<Option<DMatrix<f64>>, WorldError> {
    let restitution = world.value("restitution")?;
    let impacts: Vec<Impact> = strikes
        .iter()
        .map(|strike| {
            let command = fitted.launch.of(strike.command);
            Impact::of(&[], restitution, command, &strike.conditions)
        })
        .collect();
    let released = Simulator::new(rig, world)?.map(&impacts, |worker, impact| {
        let velocity = worker.release(*impact)?.velocity;
        Some([velocity.norm().max(1e-9).ln(), velocity.bearing()])
    });
    let released: Option<Vec<[f64; 2]>> = released.into_iter().collect();
    Ok(released.map(|all| DMatrix::from_fn(all.len(), 2, |i, j| all[i][j])))
}

/// The world with the tip's friction under which the launches of a fit's strikes are likeliest, where that is beyond chance; `all`: what the
/// tip must hold. Restitution and what turns all launches alike or by a share of their angle are fitted anew beside each.
pub(crate) fn explained(
    rig: &Rig,
    fitted: &Fitted,
    all: &[&Strike],
) -> Result<(Option<World>, u64), WorldError> {
    let struck: Vec<usize> = (0..all.len())
        .filter(|i| !all[*i].conditions.is_unstruck)
        .collect();
    if rig.object.shape() != Shape::Box || struck.len() < 8 {
        return Ok((None, 0));
    }
    let strikes: Vec<&Strike> = struck.iter().map(|i| all[*i]).collect();
    let n = strikes.len();
    let mut simulations = n as u64;
    let Some(as_fitted) = launches(rig, &fitted.world, fitted, &strikes)? else {
        return Ok((None, simulations));
    };
    let beside = [
        DMatrix::from_element(n, 1, 1.0),
        DMatrix::from_fn(n, 2, |i, j| strikes[i].command.angle.powi(j as i32)),
    ];
    // Twice the logarithm of a likelihood, the scatter of both estimated anew.
    let likelihood = |launched: &DMatrix<f64>| {
        let of = |j: usize, place: usize| {
            let needed = DVector::from_fn(n, |i, _| {
                as_fitted[(i, j)] + fitted.guesses[struck[i]][place] - launched[(i, j)]
            });
            let weighed = DVector::from_fn(n, |i, _| fitted.weights[struck[i]].sqrt());
            let columns =
                DMatrix::from_fn(n, beside[j].ncols(), |i, k| weighed[i] * beside[j][(i, k)]);
            let needed = needed.component_mul(&weighed);
            let basis = columns.qr().q();
            let left = &needed - &basis * basis.tr_mul(&needed);
            -(n as f64) * left.norm_squared().max(1e-12).ln()
        };
        of(0, SPEED) + of(1, ANGLE)
    };
    let mut most = likelihood(&as_fitted) + WORTH;
    let mut best = None;
    for k in 0..LOOKED_AT {
        let friction = LEAST * FURTHER.powi(k);
        if !holds(rig, all, friction) {
            continue;
        }
        let other = fitted.world.clone().with(HOLDS, friction);
        simulations += n as u64;
        let Some(launched) = launches(rig, &other, fitted, &strikes)? else {
            continue;
        };
        let likely = likelihood(&launched);
        if likely > most {
            (most, best) = (likely, Some(other));
        }
    }
    Ok((best, simulations))
}
