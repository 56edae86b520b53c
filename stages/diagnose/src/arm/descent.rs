//! Least squares of one form from all its starts.

use nalgebra::{DMatrix, DVector};
use values::Rig;
use world::effects::{self, AddedEffect};
use world::{Estimate, WorldError};

use super::forms::{Form, Pair, Quantity};
use crate::model::specification;

/// Differences in relative speed or angle (rad) that no strike would show: 0.05 % of a stop at 0.5 m are 0.5 mm.
pub(super) const FLOOR: f64 = 5e-4;

/// A fitted form.
pub(super) struct Fitted {
    pub(super) values: Vec<f64>,
    /// Sum of squared residuals, the floor of each counted.
    pub(super) squares: f64,
    /// Covariance of the values.
    pub(super) covariance: DMatrix<f64>,
}

pub(super) fn squares(residuals: &[f64]) -> f64 {
    residuals.iter().map(|r| r * r + FLOOR * FLOOR).sum()
}

fn added(form: &Form, values: &[f64]) -> AddedEffect {
    let fixed = form.fixed.iter();
    let fixed = fixed.map(|(name, value)| (name.clone(), Estimate::fixed(*value)));
    let estimates = values.iter().map(|value| Estimate::fixed(*value));
    AddedEffect {
        name: form.name.into(),
        parameters: form
            .free
            .iter()
            .cloned()
            .zip(estimates)
            .chain(fixed)
            .collect(),
    }
}

pub(super) fn residuals(
    rig: &Rig,
    quantity: Quantity,
    form: &Form,
    values: &[f64],
    pairs: &[&Pair<'_>],
) -> Result<Vec<f64>, WorldError> {
    let effect = effects::build(&added(form, values), rig)?;
    Ok(pairs
        .iter()
        .map(|pair| {
            pair.difference(
                quantity,
                effect.deliver(pair.command, pair.from, pair.conditions),
            )
        })
        .collect())
}

/// The best fit from all starts.
pub(super) fn fitted(
    rig: &Rig,
    quantity: Quantity,
    form: &Form,
    pairs: &[&Pair<'_>],
) -> Result<Option<Fitted>, WorldError> {
    let mut best: Option<Fitted> = None;
    for start in &form.starts {
        let fitted = descend(rig, quantity, form, start, pairs)?;
        if let Some(fitted) = fitted
            && best
                .as_ref()
                .is_none_or(|best| fitted.squares < best.squares)
        {
            best = Some(fitted);
        }
    }
    Ok(best)
}

/// Levenberg and Marquardt's descent from one start, within the parameters' ranges; `None` where the strikes do not determine them.
fn descend(
    rig: &Rig,
    quantity: Quantity,
    form: &Form,
    start: &[f64],
    pairs: &[&Pair<'_>],
) -> Result<Option<Fitted>, WorldError> {
    /// Steps; it takes some ten.
    const STEPS: usize = 60;
    /// Difference quotients over this share of a parameter's scale.
    const STEP: f64 = 1e-4;
    /// No step gains more than this share any more.
    const DONE: f64 = 1e-10;
    let own: Vec<_> = form
        .free
        .iter()
        .map(|parameter| specification(form.name, parameter))
        .collect();
    let clamp = |values: &mut Vec<f64>| {
        for (value, own) in values.iter_mut().zip(&own) {
            *value = value.clamp(own.low, own.high);
        }
    };
    let mut values = start.to_vec();
    clamp(&mut values);
    let mut here = residuals(rig, quantity, form, &values, pairs)?;
    let mut damping = 1e-3;
    let jacobian = |values: &[f64], here: &[f64]| -> Result<DMatrix<f64>, WorldError> {
        let mut jacobian = DMatrix::zeros(pairs.len(), values.len());
        for (i, own) in own.iter().enumerate() {
            let step = STEP
                * own.scale
                * if values[i] + STEP * own.scale > own.high {
                    -1.0
                } else {
                    1.0
                };
            let mut moved = values.to_vec();
            moved[i] += step;
            let there = residuals(rig, quantity, form, &moved, pairs)?;
            for (row, (there, here)) in there.iter().zip(here).enumerate() {
                jacobian[(row, i)] = (there - here) / step;
            }
        }
        Ok(jacobian)
    };
    for _ in 0..STEPS {
        let j = jacobian(&values, &here)?;
        let (normal, slope) = (
            j.transpose() * &j,
            j.transpose() * DVector::from_column_slice(&here),
        );
        let mut damped = normal.clone();
        for i in 0..values.len() {
            damped[(i, i)] += damping * normal[(i, i)].max(1e-12);
        }
        let Some(step) = damped.lu().solve(&slope) else {
            return Ok(None);
        };
        let mut next: Vec<f64> = values.iter().zip(step.iter()).map(|(v, s)| v - s).collect();
        clamp(&mut next);
        let there = residuals(rig, quantity, form, &next, pairs)?;
        let (old, new) = (squares(&here), squares(&there));
        if new < old {
            (values, here, damping) = (next, there, damping * 0.3);
            if old - new < DONE * old {
                break;
            }
        } else {
            damping *= 10.0;
            if damping > 1e9 {
                break;
            }
        }
    }
    let j = jacobian(&values, &here)?;
    let Some(inverse) = (j.transpose() * &j).try_inverse() else {
        return Ok(None);
    };
    let freedom = pairs.len().saturating_sub(values.len()).max(1) as f64;
    let squares = squares(&here);
    let covariance = inverse * (squares / freedom);
    let is_determined =
        (0..values.len()).all(|i| covariance[(i, i)].is_finite() && covariance[(i, i)] >= 0.0);
    Ok(is_determined.then_some(Fitted {
        values,
        squares,
        covariance,
    }))
}
