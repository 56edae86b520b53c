//! The paper's Algorithm 2: NLopt over the distances between measured and simulated stops. For comparison: end points
//! alone cannot distinguish friction from restitution, and the fit says so only by where it stops.

use nlopt::{Algorithm, Nlopt, Target};
use values::{Rig, Strike};
use world::{Simulator, World, WorldError, parameter};

/// Minimises the sum of stop errors over the named parameters with NLopt's BOBYQA, from where `world` stands, in at
/// most `evaluations` passes over the strikes. Returns the world and its mean stop error in m.
pub fn algorithm2(
    rig: &Rig,
    world: &World,
    strikes: &[Strike],
    free: &[&str],
    evaluations: u32,
) -> Result<(World, f64), WorldError> {
    let specs: Vec<_> = free
        .iter()
        .map(|name| parameter(name))
        .collect::<Result<_, _>>()?;
    let at = |x: &[f64]| {
        specs
            .iter()
            .zip(x)
            .fold(world.clone(), |world, (spec, value)| {
                world.with(spec.name, *value)
            })
    };
    // A world that does not come to rest is far from any that does.
    let cost = |x: &[f64]| mean_stop_error(rig, &at(x), strikes).unwrap_or(10.0);
    let mut x: Vec<f64> = free
        .iter()
        .map(|name| world.value(name))
        .collect::<Result<_, _>>()?;
    let objective = |x: &[f64], _: Option<&mut [f64]>, _: &mut ()| cost(x);
    let mut optimizer = Nlopt::new(Algorithm::Bobyqa, x.len(), objective, Target::Minimize, ());
    let low: Vec<f64> = specs.iter().map(|spec| spec.low).collect();
    let high: Vec<f64> = specs.iter().map(|spec| spec.high).collect();
    let set = optimizer
        .set_lower_bounds(&low)
        .and_then(|_| optimizer.set_upper_bounds(&high))
        .and_then(|_| optimizer.set_xtol_rel(1e-5))
        .and_then(|_| optimizer.set_maxeval(evaluations));
    if set.is_ok() {
        // Whether NLopt met its tolerance or ran out of evaluations, `x` is the best that it found.
        let _ = optimizer.optimize(&mut x);
    }
    let best = cost(&x);
    Ok((at(&x), best))
}

fn mean_stop_error(rig: &Rig, world: &World, strikes: &[Strike]) -> Result<f64, WorldError> {
    let errors: Vec<f64> = Simulator::new(rig, world)?
        .map(strikes, |worker, strike| {
            let simulated = worker.strike(strike.initial, strike.command, &strike.conditions)?;
            Ok(simulated.stop.distance(strike.stop))
        })
        .into_iter()
        .collect::<Result<_, WorldError>>()?;
    Ok(errors.iter().sum::<f64>() / errors.len().max(1) as f64)
}
