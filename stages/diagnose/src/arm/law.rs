//! How delivered launches depend on commanded ones: the library's effects of the striker, fitted by least squares.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use values::{Command, Conditions, Rig, Strike};
use world::effects::{self, AddedEffect, library};
use world::{Estimate, WorldError};

use crate::model::specification;

/// An effect of the arm.
#[derive(Clone, Debug)]
pub(super) struct Law {
    pub(super) name: &'static str,
    pub(super) added: AddedEffect,
    /// Gain in log-likelihood over an arm that does as it is told, less what as many parameters gain by chance.
    pub(super) evidence: f64,
}

/// What a law is of.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Of {
    Speed,
    Angle,
}

/// A law is named where chance gains as much in one case of a thousand, all forms that are tried counted.
const CHANCE: f64 = 0.001;
/// Differences in relative speed or angle (rad) that no strike would show: 0.05 % of a stop at 0.5 m are 0.5 mm.
const FLOOR: f64 = 5e-4;
/// A strike that differs by more deviations is left out.
const OUTLIER: f64 = 6.0;
/// Standard deviations to either end of a 95 % interval.
const NINETY_FIVE: f64 = 1.96;
/// Shares of the delivered speeds at which a fit of a cap begins; the last ones over the fastest.
const CAPS: [f64; 6] = [0.6, 0.75, 0.85, 0.95, 1.05, 1.4];

/// One strike: what was told, what was delivered, and when.
struct Pair<'a> {
    command: Command,
    delivered: Command,
    conditions: &'a Conditions,
}

/// One form that a law may have, and where its fits begin.
struct Form {
    name: &'static str,
    free: Vec<String>,
    starts: Vec<Vec<f64>>,
}

/// A fitted form.
struct Fitted {
    values: Vec<f64>,
    /// Sum of squared residuals, the floor of each counted.
    squares: f64,
    /// Covariance of the values.
    covariance: DMatrix<f64>,
}

/// The laws by which the arm of these strikes deviates from its commands: none, one of the speed, one of the angle.
pub(super) fn fit(rig: &Rig, strikes: &[&Strike]) -> Result<Vec<Law>, WorldError> {
    let pairs: Vec<Pair<'_>> = strikes
        .iter()
        .filter_map(|strike| {
            Some(Pair {
                command: strike.command,
                delivered: strike.delivered?.command(),
                conditions: &strike.conditions,
            })
        })
        .collect();
    let mut laws = Vec::new();
    for of in [Of::Speed, Of::Angle] {
        let forms = forms(of, &pairs);
        let all: Vec<&Pair<'_>> = pairs.iter().collect();
        let Some((form, fitted, _)) = best(rig, of, &forms, &all)? else {
            continue;
        };
        // Once more without strikes that lie far from it.
        let residuals = residuals(rig, of, form, &fitted.values, &all)?;
        let mut sizes: Vec<f64> = residuals.iter().map(|r| r.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let most = OUTLIER * (1.4826 * sizes[sizes.len() / 2]).max(FLOOR);
        let near: Vec<&Pair<'_>> = all
            .iter()
            .zip(&residuals)
            .filter(|(_, residual)| residual.abs() <= most)
            .map(|(pair, _)| *pair)
            .collect();
        if let Some((form, fitted, evidence)) = best(rig, of, &forms, &near)? {
            laws.push(law(form, &fitted, evidence));
        }
    }
    Ok(laws)
}

/// The forms that the library has for a law, on these strikes.
fn forms(of: Of, pairs: &[Pair<'_>]) -> Vec<Form> {
    let find = |name: &str| library().find(|spec| spec.name == name);
    let mut forms = Vec::new();
    let mut add = |name: &str, free: &[&str], starts: Vec<Vec<f64>>| {
        if let Some(spec) = find(name)
            && free
                .iter()
                .all(|parameter| spec.parameter(parameter).is_some())
        {
            forms.push(Form {
                name: spec.name,
                free: free.iter().map(|parameter| (*parameter).into()).collect(),
                starts,
            });
        }
    };
    match of {
        Of::Speed => {
            let name = "striker_speed_error";
            for free in [&["slope"][..], &["offset"], &["offset", "slope"]] {
                let start = free.iter().map(|p| if *p == "slope" { 1.0 } else { 0.0 });
                add(name, free, vec![start.collect()]);
            }
            let fastest = pairs.iter().map(|p| p.delivered.speed).fold(0.0, f64::max);
            for free in [
                &["cap"][..],
                &["cap", "slope"],
                &["cap", "offset", "slope"],
                &["cap", "slope", "softness"],
            ] {
                let start = |cap: f64| {
                    let value = |parameter: &&str| match *parameter {
                        "cap" => cap,
                        "slope" => 1.0,
                        "softness" => 0.3,
                        _ => 0.0,
                    };
                    free.iter().map(value).collect()
                };
                add(
                    name,
                    free,
                    CAPS.map(|share| start(share * fastest)).to_vec(),
                );
            }
        }
        Of::Angle => {
            add("striker_angle_bias", &["bias"], vec![vec![0.0]]);
            for free in [
                &["bias", "gain"][..],
                &["bias", "slope"],
                &["bias", "gain", "slope"],
            ] {
                add("striker_angle_error", free, vec![vec![0.0; free.len()]]);
            }
            let mut sessions: Vec<&str> = pairs
                .iter()
                .map(|p| p.conditions.session.as_str())
                .collect();
            sessions.sort_unstable();
            sessions.dedup();
            if sessions.len() > 1 {
                let none = vec![0.0; sessions.len()];
                add("striker_angle_by_session", &sessions, vec![none]);
            }
        }
    }
    forms
}

/// The form that these strikes need, with its evidence; none where the arm does as it is told. A form with further values must
/// bring as much beyond the best of the simpler ones as it must beyond none.
fn best<'f>(
    rig: &Rig,
    of: Of,
    forms: &'f [Form],
    pairs: &[&Pair<'_>],
) -> Result<Option<(&'f Form, Fitted, f64)>, WorldError> {
    let n = pairs.len() as f64;
    let told: Vec<f64> = pairs
        .iter()
        .map(|pair| pair.difference(of, pair.command))
        .collect();
    let plain = squares(&told);
    let by_chance = |values: usize| {
        ChiSquared::new(values as f64).map_or(f64::INFINITY, |chance| {
            0.5 * chance.inverse_cdf(1.0 - CHANCE / forms.len() as f64)
        })
    };
    let mut gains = Vec::new();
    for form in forms {
        let values = form.free.len();
        if pairs.len() < 4 * values + 4 {
            continue;
        }
        if let Some(fitted) = fitted(rig, of, form, pairs)? {
            let gain = 0.5 * n * (plain / fitted.squares).ln();
            gains.push((form, fitted, gain));
        }
    }
    gains.sort_by(|a, b| {
        let values = |of: &(&Form, Fitted, f64)| of.0.free.len();
        values(a).cmp(&values(b)).then(b.2.total_cmp(&a.2))
    });
    let mut best: Option<(&Form, Fitted, f64)> = None;
    for (form, fitted, gain) in gains {
        let (values, least) = best
            .as_ref()
            .map_or((0, 0.0), |(form, _, gain)| (form.free.len(), *gain));
        if form.free.len() > values && gain - least > by_chance(form.free.len() - values) {
            best = Some((form, fitted, gain));
        }
    }
    Ok(best.map(|(form, fitted, gain)| {
        let evidence = gain - by_chance(form.free.len());
        (form, fitted, evidence)
    }))
}

impl Pair<'_> {
    /// Delivered less predicted: speed relative to the command's, or angle in rad.
    fn difference(&self, of: Of, predicted: Command) -> f64 {
        match of {
            Of::Speed => (self.delivered.speed - predicted.speed) / self.command.speed.max(1e-9),
            Of::Angle => {
                let error = self.delivered.angle - predicted.angle;
                error - TAU * (error / TAU).round()
            }
        }
    }
}

fn squares(residuals: &[f64]) -> f64 {
    residuals.iter().map(|r| r * r + FLOOR * FLOOR).sum()
}

fn added(form: &Form, values: &[f64]) -> AddedEffect {
    let estimates = values.iter().map(|value| Estimate::fixed(*value));
    AddedEffect {
        name: form.name.into(),
        parameters: form.free.iter().cloned().zip(estimates).collect(),
    }
}

fn residuals(
    rig: &Rig,
    of: Of,
    form: &Form,
    values: &[f64],
    pairs: &[&Pair<'_>],
) -> Result<Vec<f64>, WorldError> {
    let effect = effects::build(&added(form, values), rig)?;
    Ok(pairs
        .iter()
        .map(|pair| pair.difference(of, effect.deliver(pair.command, pair.conditions)))
        .collect())
}

/// The best fit from all starts.
fn fitted(
    rig: &Rig,
    of: Of,
    form: &Form,
    pairs: &[&Pair<'_>],
) -> Result<Option<Fitted>, WorldError> {
    let mut best: Option<Fitted> = None;
    for start in &form.starts {
        let fitted = descend(rig, of, form, start, pairs)?;
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

/// Levenberg and Marquardt's descent from one start, within the parameters' ranges; `None` where the strikes do not tell them.
fn descend(
    rig: &Rig,
    of: Of,
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
    let mut here = residuals(rig, of, form, &values, pairs)?;
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
            let there = residuals(rig, of, form, &moved, pairs)?;
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
        let there = residuals(rig, of, form, &next, pairs)?;
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
    let is_told =
        (0..values.len()).all(|i| covariance[(i, i)].is_finite() && covariance[(i, i)] >= 0.0);
    Ok(is_told.then_some(Fitted {
        values,
        squares,
        covariance,
    }))
}

fn law(form: &Form, fitted: &Fitted, evidence: f64) -> Law {
    let parameters: BTreeMap<String, Estimate> = form
        .free
        .iter()
        .enumerate()
        .map(|(i, parameter)| {
            let (value, half) = (
                fitted.values[i],
                NINETY_FIVE * fitted.covariance[(i, i)].sqrt(),
            );
            (
                parameter.clone(),
                Estimate::with_interval(value, value - half, value + half),
            )
        })
        .collect();
    Law {
        name: form.name,
        added: AddedEffect {
            name: form.name.into(),
            parameters,
        },
        evidence,
    }
}
