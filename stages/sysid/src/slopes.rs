//! Derivatives of tracks, by large-step differences: small steps read the noise of the contact.

use nalgebra::{DMatrix, DVector};
use values::Strike;
use world::{World, WorldError, parameter};

use crate::{
    compare::{Batch, Launch, StrikeSimulator},
    scatter::NUISANCES,
};

/// Steps of the central differences, relative to a parameter's range.
pub(crate) const DIFFERENCE: f64 = 0.01;
/// Steps of the differences by relative speed, angle (rad) and clock (s).
pub(crate) const LAUNCH_STEP: (f64, f64, f64) = (0.01, 0.01, 1e-3);

/// Part of a turn of the command by which a box's way must turn, for the tip to stick.
const FOLLOWS: f64 = 0.5;

/// Of each strike's track: derivatives by the nuisances, and by a turn of its command.
pub(crate) type ByNuisances = (Vec<DMatrix<f64>>, Vec<DVector<f64>>);

/// Derivatives of every strike's track by the nuisances, and by a turn of its command; they change little as parameters do.
///
/// A strike's own angle is one of its command. But a box on whose face the tip slips leaves at the edge of the friction's cone, wherever the tip goes,
/// and would need any angle to explain how ways scatter: its own angle turns its way.
pub(crate) fn nuisances(
    lab: &StrikeSimulator<'_>,
    world: &World,
    base: &Batch,
) -> Result<ByNuisances, WorldError> {
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
            let by_turn = (turned.track(i, strike, 0.0) - &here) / turn;
            let way = turned_about_start(&here, strike);
            let follows = by_turn.dot(&way) > FOLLOWS * way.norm_squared();
            columns.set_column(
                1,
                if lab.is_by_way && !follows {
                    &way
                } else {
                    &by_turn
                },
            );
            columns.set_column(
                2,
                &((base.track(i, strike, delay) - base.track(i, strike, -delay)) / (2.0 * delay)),
            );
            columns.view_mut((0, 3), (n, 1)).fill(1.0);
            columns.view_mut((n, 4), (n, 1)).fill(1.0);
            (columns, by_turn)
        })
        .unzip())
}

/// Derivative of a track (all x, then all y) by a turn of its whole way about where it starts.
fn turned_about_start(track: &DVector<f64>, strike: &Strike) -> DVector<f64> {
    let n = strike.track.len();
    let (x, y) = (track.rows(0, n), track.rows(n, n));
    let mut turned = DVector::zeros(2 * n);
    turned
        .rows_mut(0, n)
        .copy_from(&(-y.add_scalar(-strike.initial.y)));
    turned
        .rows_mut(n, n)
        .copy_from(&x.add_scalar(-strike.initial.x));
    turned
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
