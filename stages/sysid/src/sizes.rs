//! Sizes in the rig file that the strikes contradict: a box's and the tip's.
//!
//! A tip of radius r that is led through the middle of a box meets its face (1 + r/h)·tan(angle) half sides h off the middle. This, and all
//! that follows in the plane, depends on r/h alone, so that the strikes show this ratio and not which of the two sizes is wrong. A round
//! object is met through its centre at any size. An arm whose angles are off by a share sends a box astray in the same way.

use nalgebra::{DMatrix, DVector};
use values::{Rig, Shape, Strike};
use world::WorldError;

use crate::{compare::StrikeSimulator, fit::Fitted, notes::Note, scatter::SPEED, wanted::Wanted};

/// Step of the central differences by the logarithm of r/h.
const STEP: f64 = 0.05;
/// Probability that a rig file that is right is said to be wrong; most rigs are.
const FALSE_ALARM: f64 = 1e-3;
/// Twice the gain in log-likelihood by which a share on the arm's angles must beat other sizes for the sizes to be left alone.
const BETTER: f64 = 12.0;
/// Factor by which no ruler is off: arms are, and an arm is looked for by the diagnosis.
const FARTHEST: f64 = 1.5;

/// What the strikes say about the rig file's sizes.
#[derive(Default)]
pub(crate) struct Sizes {
    /// Set where they contradict the rig file.
    pub(crate) note: Option<Note>,
    pub(crate) simulations: u64,
}

/// Simulated tracks in the middle of two radii of the tip, and their derivatives by the logarithm of r/h.
struct BySize {
    middles: Vec<DVector<f64>>,
    slopes: Vec<DVector<f64>>,
}

impl BySize {
    /// Simulated tracks about a tip whose radius is exp(`change`) times the rig file's.
    fn new(
        rig: &Rig,
        fitted: &Fitted,
        strikes: &[&Strike],
        change: f64,
    ) -> Result<Self, WorldError> {
        let at = |change: f64| {
            let mut rig = rig.clone();
            rig.striker.radius *= change.exp();
            StrikeSimulator::mujoco(&rig, strikes).simulate(&fitted.world, fitted.launch)
        };
        let (below, above) = (at(change - STEP)?, at(change + STEP)?);
        let (middles, slopes) = strikes
            .iter()
            .enumerate()
            .map(|(i, strike)| {
                let (below, above) = (below.track(i, strike, 0.0), above.track(i, strike, 0.0));
                ((&above + &below) / 2.0, (above - below) / (2.0 * STEP))
            })
            .unzip();
        Ok(Self { middles, slopes })
    }
}

/// Tests whether another size would explain the strikes better. `is_measured`: whether launches are the arm's logged ones.
pub(crate) fn contradicted(
    rig: &Rig,
    fitted: &Fitted,
    strikes: &[&Strike],
    is_measured: bool,
) -> Result<Sizes, WorldError> {
    if rig.object.shape() != Shape::Box {
        return Ok(Sizes::default());
    }
    let nominal = BySize::new(rig, fitted, strikes, 0.0)?;
    let mut sizes = Sizes {
        note: None,
        simulations: 2 * strikes.len() as u64,
    };
    let Some(first) = Wanted::new(fitted, &fitted.residuals, &nominal.slopes) else {
        return Ok(sizes);
    };
    let by_arm = |slopes: &[DMatrix<f64>], column: usize, times: fn(&Strike) -> f64| {
        let slopes: Vec<DVector<f64>> = strikes
            .iter()
            .zip(slopes)
            .map(|(strike, by)| by.column(column) * times(strike))
            .collect();
        Wanted::new(fitted, &fitted.residuals, &slopes)
    };
    // The first of the means is a turn of the command; a box's own angle is one of its way.
    let (by_nuisance, turn) = (&fitted.slopes.by_nuisance, fitted.free.len());
    let angles = by_arm(&fitted.slopes.by_fitted, turn, |s| s.command.angle);
    let speeds = by_arm(by_nuisance, SPEED, |_| 1.0);
    let saturation = by_arm(by_nuisance, SPEED, |s| s.command.speed);
    let is_better = |other: &Option<Wanted>, by: f64| {
        other
            .as_ref()
            .is_some_and(|other| other.distance().powi(2) > first.distance().powi(2) + by)
    };
    if first.distance() < first.limit(FALSE_ALARM)
        || first.change.abs() > FARTHEST.ln()
        || is_better(&angles, BETTER)
        || is_better(&speeds, 0.0)
        || is_better(&saturation, 0.0)
    {
        return Ok(sizes);
    }
    // Once more, about what is wanted: tracks are not quite linear in it. Nothing is said of a size at which a strike misses.
    let Ok(there) = BySize::new(rig, fitted, strikes, first.change) else {
        return Ok(sizes);
    };
    sizes.simulations *= 2;
    let residuals: Vec<DVector<f64>> = fitted
        .residuals
        .iter()
        .zip(nominal.middles.iter().zip(&there.middles))
        .map(|(residual, (nominal, there))| residual - (there - nominal))
        .collect();
    let arm = angles.filter(|_| !is_measured);
    let second = Wanted::new(fitted, &residuals, &there.slopes);
    sizes.note = second.map(|second| Note::WrongSizes {
        half_sides: rig.object.solid.half_sides().unwrap_or_default(),
        radius: rig.striker.radius,
        ratio: first.change + second.change,
        half: second.limit(0.05) * second.error,
        arm: arm.map(|arm| 1.0 + arm.change),
    });
    Ok(sizes)
}
