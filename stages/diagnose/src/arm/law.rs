//! How delivered launches depend on commanded ones: the library's effects of the striker, fitted by least squares.

use std::collections::BTreeMap;

use statrs::distribution::{ChiSquared, ContinuousCDF};
use values::{Rig, Strike};
use world::effects::{self, AddedEffect};
use world::{Estimate, WorldError};

use super::descent::{FLOOR, Fitted, fitted, residuals, squares};
use super::forms::{BY_PLACE, Form, Pair, Quantity, forms, forms_by_place, forms_of_others};
use crate::fit::NINETY_FIVE;
use crate::heldout::{self, FOLDS};

/// An effect of the arm.
#[derive(Clone, Debug)]
pub(super) struct Law {
    pub(super) name: &'static str,
    pub(super) added: AddedEffect,
    /// Gain in log-likelihood over an arm that delivers its commands, less what as many parameters gain by chance.
    pub(super) evidence: f64,
}

/// A law is named where chance gains as much in one case of a thousand, all forms that are tried counted.
pub(super) const CHANCE: f64 = 0.001;
/// A strike that differs by more deviations is left out.
const OUTLIER: f64 = 6.0;
/// Cap on how much one strike counts, in typical squared errors about a law.
const MOST_OF_ONE: f64 = 20.0;

/// The laws by which the arm of these strikes deviates from its commands: by what was commanded, one of the speed, one of the angle, and then by
/// where the object lay.
pub(super) fn fit(rig: &Rig, strikes: &[&Strike]) -> Result<Vec<Law>, WorldError> {
    let pairs = Pair::all(strikes);
    let mut laws = Vec::new();
    let mut by_place: Option<Law> = None;
    for quantity in Quantity::ALL {
        let of_place = forms_by_place(quantity, rig, strikes);
        let mut of_command = forms(quantity, &pairs);
        of_command.extend(forms_of_others(quantity, rig, strikes)?);
        // Of each kind beside the other, the stronger one first.
        let all = [of_command.as_slice(), of_place.as_slice()].concat();
        let Some(first) = law_of(rig, quantity, &all, &pairs)? else {
            continue;
        };
        let effect = [effects::build(&first.added, rig)?];
        let (on_command, on_place) = if first.name == BY_PLACE {
            let less: Vec<_> = pairs.iter().map(|pair| pair.less(&effect)).collect();
            let second = law_of(rig, quantity, &of_command, &less)?;
            (second, Some(first))
        } else {
            let beside: Vec<_> = pairs.iter().map(|pair| pair.beside(&effect)).collect();
            let second = law_of(rig, quantity, &of_place, &beside)?;
            (Some(first), second)
        };
        laws.extend(on_command);
        by_place = match (by_place, on_place) {
            (Some(mut law), Some(more)) => {
                law.added.parameters.extend(more.added.parameters);
                law.evidence += more.evidence;
                Some(law)
            }
            (law, more) => law.or(more),
        };
    }
    laws.extend(by_place);
    Ok(laws)
}

/// The law, of these forms, that the strikes need and that predicts strikes left out of its fit.
fn law_of(
    rig: &Rig,
    quantity: Quantity,
    forms: &[Form],
    pairs: &[Pair<'_>],
) -> Result<Option<Law>, WorldError> {
    let all: Vec<&Pair<'_>> = pairs.iter().collect();
    let Some((form, fitted, _)) = best(rig, quantity, forms, &all)? else {
        return Ok(None);
    };
    // Once more without strikes that lie far from it.
    let residuals = residuals(rig, quantity, form, &fitted.values, &all)?;
    let mut sizes: Vec<f64> = residuals.iter().map(|r| r.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let most = OUTLIER * (1.4826 * sizes[sizes.len() / 2]).max(FLOOR);
    let near: Vec<&Pair<'_>> = all
        .iter()
        .zip(&residuals)
        .filter(|(_, residual)| residual.abs() <= most)
        .map(|(pair, _)| *pair)
        .collect();
    let Some((form, fitted, evidence)) = best(rig, quantity, forms, &near)? else {
        return Ok(None);
    };
    let pays = pays(rig, quantity, form, &fitted, &near)?;
    Ok(pays.then(|| law(form, &fitted, evidence)))
}

/// Whether a law predicts the deliveries of strikes left out of its fit better than no law (cross-validation).
fn pays(
    rig: &Rig,
    quantity: Quantity,
    form: &Form,
    fitted_to_all: &Fitted,
    pairs: &[&Pair<'_>],
) -> Result<bool, WorldError> {
    let about = residuals(rig, quantity, form, &fitted_to_all.values, pairs)?;
    let mut typical: Vec<f64> = about.iter().map(|r| r * r + FLOOR * FLOOR).collect();
    typical.sort_by(f64::total_cmp);
    let most = MOST_OF_ONE * typical.get(typical.len() / 2).copied().unwrap_or(0.0);
    // A cap does nothing to most strikes: what is typical is not their fall.
    let falls = |values: &[f64], of: &[&Pair<'_>]| -> Result<Vec<f64>, WorldError> {
        let left = residuals(rig, quantity, form, values, of)?;
        let plain = of
            .iter()
            .map(|pair| pair.difference(quantity, pair.command));
        Ok(plain
            .zip(left)
            .map(|(plain, left)| (plain * plain - left * left).clamp(-most, most))
            .collect())
    };
    let mut left_out = Vec::new();
    for fold in 0..FOLDS {
        let part = |is_left_out: bool| -> Vec<&Pair<'_>> {
            let each = pairs.iter().enumerate();
            each.filter(|(i, _)| (i % FOLDS == fold) == is_left_out)
                .map(|(_, pair)| *pair)
                .collect()
        };
        if let Some(fitted) = fitted(rig, quantity, form, &part(false))? {
            left_out.extend(falls(&fitted.values, &part(true))?);
        }
    }
    Ok(heldout::pays(&left_out))
}

/// The form that these strikes need, with its evidence; none where the arm delivers its commands. A form with further values must
/// bring as much beyond the best of the simpler ones as it must beyond none.
fn best<'f>(
    rig: &Rig,
    quantity: Quantity,
    forms: &'f [Form],
    pairs: &[&Pair<'_>],
) -> Result<Option<(&'f Form, Fitted, f64)>, WorldError> {
    let n = pairs.len() as f64;
    let off: Vec<f64> = pairs
        .iter()
        .map(|pair| pair.difference(quantity, pair.command))
        .collect();
    let plain = squares(&off);
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
        if let Some(fitted) = fitted(rig, quantity, form, pairs)? {
            let gain = 0.5 * n * (plain / fitted.squares).ln();
            gains.push((form, fitted, gain));
        }
    }
    gains.sort_by(|a, b| {
        let values = |fit: &(&Form, Fitted, f64)| fit.0.free.len();
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

fn law(form: &Form, fitted: &Fitted, evidence: f64) -> Law {
    let given = form.fixed.iter();
    let given = given.map(|(name, value)| (name.clone(), Estimate::fixed(*value)));
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
        .chain(given)
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
