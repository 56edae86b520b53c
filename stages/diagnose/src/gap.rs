//! The gap: stop errors in MuJoCo's world before and after, on strikes that took no part.

use values::{Point, Rig, Split, Strike};
use world::{Simulator, World, WorldError};

use crate::{
    diagnosis::{Gap, StopResidual},
    fit::Fitted,
    mixed::{ANGLE, FRICTION, SPEED},
    model::CLOCK,
    strikes::{Nuisances, PreparedStrikes},
};

/// Measured less simulated stops, in m; `None` where a strike does not rest in that world.
pub(crate) fn stop_residuals(
    rig: &Rig,
    world: &World,
    strikes: &[&Strike],
) -> Result<Vec<Option<Point>>, WorldError> {
    Ok(Simulator::new(rig, world)?.map(strikes, |worker, strike| {
        worker
            .strike(strike.initial, strike.command, &strike.conditions)
            .ok()
            .map(|simulated| strike.stop - simulated.stop)
    }))
}

/// Root mean square, in m.
pub(crate) fn rms(residuals: impl Iterator<Item = Point>) -> f64 {
    let (mut sum, mut count) = (0.0, 0usize);
    for r in residuals {
        sum += r.dot(r);
        count += 1;
    }
    (sum / count.max(1) as f64).sqrt()
}

/// What repeats of these strikes would scatter by: launch, friction and camera as estimated with the best model, in m.
pub(crate) fn noise_floor(
    prepared: &PreparedStrikes<'_>,
    fitted: &Fitted,
) -> Result<f64, WorldError> {
    let model = &fitted.model;
    let effects = model.effects(prepared.rig, &model.values)?;
    let planar = prepared.planar(&model.values, &effects);
    let components = &fitted.estimated.components;
    let clock = model.values[CLOCK];
    let none = Nuisances::zeros();
    let variances: Vec<f64> = (0..prepared.strikes.len())
        .filter_map(|i| {
            let stop = prepared.simulate(&planar, i, clock, &none)?.stop;
            // The resting place after, as the one before below.
            let mut variance = components.nuisance[3].powi(2) + components.nuisance[4].powi(2);
            for nuisance in [SPEED, ANGLE, 3, 4, FRICTION] {
                let mut b = none;
                b[nuisance] = match nuisance {
                    FRICTION => fitted.friction_scatter(),
                    _ => components.nuisance[nuisance],
                };
                let moved = prepared.simulate(&planar, i, clock, &b)?.stop - stop;
                variance += moved.dot(moved);
            }
            Some(variance)
        })
        .collect();
    Ok((variances.iter().sum::<f64>() / variances.len().max(1) as f64).sqrt())
}

/// The gap over the held-out strikes.
pub(crate) fn gap(before: &[Option<Point>], after: &[Option<Point>], noise_floor: f64) -> Gap {
    let both: Vec<(Point, Point)> = before
        .iter()
        .zip(after)
        .filter_map(|(b, a)| Some(((*b)?, (*a)?)))
        .collect();
    Gap {
        heldout_strikes: both.len(),
        before: rms(both.iter().map(|(b, _)| *b)),
        after: rms(both.iter().map(|(_, a)| *a)),
        noise_floor,
        unit: "m".into(),
        measure: "rms stop error".into(),
    }
}

/// Each strike's residual along and across its path.
pub(crate) fn residuals(
    strikes: &[&Strike],
    before: &[Option<Point>],
    after: &[Option<Point>],
) -> Vec<StopResidual> {
    strikes
        .iter()
        .zip(before.iter().zip(after))
        .filter_map(|(strike, (before, after))| {
            let path = strike.path();
            let ahead = path * (1.0 / path.norm().max(1e-9));
            let split = |r: Point| [r.dot(ahead), r.y * ahead.x - r.x * ahead.y];
            Some(StopResidual {
                strike_id: strike.id.clone(),
                is_heldout: strike.split == Split::Test,
                before: split((*before)?),
                after: split((*after)?),
            })
        })
        .collect()
}
