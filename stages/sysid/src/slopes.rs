//! Derivatives of tracks, by large-step differences: small steps read the noise of the contact.

use nalgebra::DMatrix;
use world::{World, WorldError, parameter};

use crate::{
    compare::{Batch, Launch, StrikeSimulator},
    scatter::NUISANCES,
};

/// Steps of the central differences, relative to a parameter's range.
pub(crate) const DIFFERENCE: f64 = 0.01;
/// Steps of the differences by relative speed, angle (rad) and clock (s).
pub(crate) const LAUNCH_STEP: (f64, f64, f64) = (0.01, 0.01, 1e-3);

/// Derivatives of every strike's track by the nuisances; they change little as parameters do.
pub(crate) fn nuisances(
    lab: &StrikeSimulator<'_>,
    world: &World,
    base: &Batch,
) -> Result<Vec<DMatrix<f64>>, WorldError> {
    let (speed, turn, delay) = LAUNCH_STEP;
    let launch = base.launch();
    let changed = |launch| lab.simulate(world, launch);
    let faster = changed(Launch {
        speed_factor: launch.speed_factor + speed,
        ..launch
    })?;
    let turned = changed(Launch {
        turn: launch.turn + turn,
        ..launch
    })?;
    Ok(lab
        .strikes
        .iter()
        .enumerate()
        .map(|(i, strike)| {
            let n = strike.track.len();
            let here = base.track(i, strike, 0.0);
            let mut columns = DMatrix::zeros(2 * n, NUISANCES);
            columns.set_column(0, &((faster.track(i, strike, 0.0) - &here) / speed));
            columns.set_column(1, &((turned.track(i, strike, 0.0) - &here) / turn));
            columns.set_column(
                2,
                &((base.track(i, strike, delay) - base.track(i, strike, -delay)) / (2.0 * delay)),
            );
            columns.view_mut((0, 3), (n, 1)).fill(1.0);
            columns.view_mut((n, 4), (n, 1)).fill(1.0);
            columns
        })
        .collect())
}

/// Derivatives of every strike's track by the named parameters, by central differences kept within their ranges.
pub(crate) fn sensitivities(
    lab: &StrikeSimulator<'_>,
    world: &World,
    launch: Launch,
    names: &[String],
) -> Result<Vec<DMatrix<f64>>, WorldError> {
    let mut columns: Vec<DMatrix<f64>> = lab
        .strikes
        .iter()
        .map(|strike| DMatrix::zeros(2 * strike.track.len(), names.len()))
        .collect();
    for (column, name) in names.iter().enumerate() {
        let spec = parameter(name)?;
        let (value, step) = (world.value(name)?, DIFFERENCE * (spec.high - spec.low));
        let (low, high) = ((value - step).max(spec.low), (value + step).min(spec.high));
        let at = |value| lab.simulate(&world.clone().with(name, value), launch);
        let (below, above) = (at(low)?, at(high)?);
        for (i, strike) in lab.strikes.iter().enumerate() {
            let slope = (above.track(i, strike, 0.0) - below.track(i, strike, 0.0)) / (high - low);
            columns[i].set_column(column, &slope);
        }
    }
    Ok(columns)
}
