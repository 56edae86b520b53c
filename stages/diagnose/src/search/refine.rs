//! Asks of every effect held whether another fits better in its place, and how firmly it stands.

use rayon::prelude::*;
use world::WorldError;

use super::{
    CandidateFit, SelectedEffect, Selection,
    fits::{FitCriteria, fit_best},
    penalty::{alike, evidence_of, simpler},
};
use crate::{
    Thresholds,
    candidates::Candidate,
    fit::Fitted,
    model::Part,
    screen::{Chance, Screened, screen},
};

/// The same without one of its effects; of the others, the evidence alone is known ([`with_rivals`]).
pub(crate) fn without<'a>(
    mut selection: Selection<'a>,
    place: usize,
    chance: &Chance,
) -> Result<Selection<'a>, WorldError> {
    let null = || selection.null.clone();
    selection.fitted = reduced(&selection, place)?.unwrap_or_else(null);
    selection.effects = (0..selection.fitted.model.parts.len())
        .map(|place| {
            let reduced = reduced(&selection, place)?;
            Ok(effect_alone(&selection, place, reduced.as_ref(), chance))
        })
        .collect::<Result<_, WorldError>>()?;
    Ok(selection)
}

/// The same, and who could stand in the place of each effect.
pub(crate) fn with_rivals<'a>(
    selection: Selection<'a>,
    candidates: &[Candidate],
    chance: &Chance,
) -> Result<Selection<'a>, WorldError> {
    refine(selection, candidates, chance, 0)
}

/// Replaces or drops an effect where that is better, at most so many times, then says how firmly each stands.
pub(super) fn refine<'a>(
    mut selection: Selection<'a>,
    candidates: &[Candidate],
    chance: &Chance,
    mut changes: usize,
) -> Result<Selection<'a>, WorldError> {
    loop {
        let mut better = None;
        let mut effects = Vec::new();
        let places: Vec<usize> = (0..selection.fitted.model.parts.len()).collect();
        // As many at once as there are threads: the first that is replaced decides, however many were asked beside it.
        'places: for places in places.chunks(rayon::current_num_threads()) {
            let assessed: Vec<_> = places
                .par_iter()
                .map(|place| assess(&selection, *place, candidates, chance))
                .collect::<Result<_, WorldError>>()?;
            for (mut effect, reduced) in assessed {
                if changes > 0 {
                    better = replacement(&effect, reduced, selection.prepared.thresholds);
                    if better.is_some() {
                        break 'places;
                    }
                }
                effect.drop_columns();
                effects.push(effect);
            }
        }
        match better {
            Some(fitted) => {
                selection.fitted = fitted;
                changes -= 1;
            }
            None => {
                selection.effects = effects;
                return Ok(selection);
            }
        }
    }
}

/// The model that is better than the one with this effect: without it, or with a rival in its place.
fn replacement(
    effect: &SelectedEffect,
    reduced: Option<Fitted>,
    thresholds: &Thresholds,
) -> Option<Fitted> {
    if effect.evidence < 0.0 {
        return reduced;
    }
    let rival = effect.rivals.first()?;
    (rival.evidence > effect.evidence + thresholds.better).then(|| rival.fitted.clone())
}

/// The model without one of its effects, fitted; `None` where that diverges.
fn reduced(selection: &Selection<'_>, place: usize) -> Result<Option<Fitted>, WorldError> {
    let from = &selection.fitted;
    selection
        .prepared
        .fit_from(from, &from.model.without(place))
}

/// An effect and its evidence beside the others; without bound where no model without it can be fitted.
fn effect_alone(
    selection: &Selection<'_>,
    place: usize,
    reduced: Option<&Fitted>,
    chance: &Chance,
) -> SelectedEffect {
    let fitted = &selection.fitted;
    let name = fitted.model.parts[place].name;
    let evidence = reduced.map_or(f64::INFINITY, |reduced| {
        evidence_of(
            name,
            fitted.likelihood() - reduced.likelihood(),
            fitted.model.free.len() - reduced.model.free.len(),
            chance[name],
            selection.prepared.thresholds,
        )
    });
    SelectedEffect {
        name,
        evidence,
        equivalent: Vec::new(),
        rivals: Vec::new(),
    }
}

/// How firmly one effect stands beside the others, and the model without it.
fn assess(
    selection: &Selection<'_>,
    place: usize,
    candidates: &[Candidate],
    chance: &Chance,
) -> Result<(SelectedEffect, Option<Fitted>), WorldError> {
    let Selection {
        prepared, fitted, ..
    } = selection;
    let thresholds = prepared.thresholds;
    let reduced = reduced(selection, place)?;
    let effect = effect_alone(selection, place, reduced.as_ref(), chance);
    let Some(reduced) = reduced else {
        return Ok((effect, None));
    };
    let (name, evidence) = (effect.name, effect.evidence);
    let is_offset = is_speed_offset(&fitted.model.fitted_parts(&fitted.model.values)[place]);
    let (own, screened): (Vec<Screened>, Vec<Screened>) = screen(prepared, &reduced, candidates)?
        .into_iter()
        .partition(|s| s.name == name);
    let criteria = FitCriteria {
        required: alike(name),
        incumbent_gain: own.first().map(|own| own.gain().min(evidence)),
    };
    let rivals = fit_best(prepared, &reduced, &screened, chance, criteria)?;
    let at_end = fitted.forms_at_end();
    let is_at_end = fitted
        .model
        .forms()
        .any(|(i, of, _)| of == place && at_end.contains(&i));
    let equivalent = rivals
        .iter()
        .enumerate()
        // A form at the end of its range stands for something else, the best rival first of all.
        // One that contains this effect is never excluded, and says no other thing.
        .filter(|(_, rival)| !contains(rival.name, name))
        .filter(|(rank, rival)| {
            let is_same = is_offset && rival.evidence > 0.0 && alike(name).contains(&rival.name);
            (is_at_end && *rank == 0) || is_same || !is_excluded(name, evidence, rival, thresholds)
        })
        .map(|(_, rival)| rival.name)
        .collect();
    let effect = SelectedEffect {
        equivalent,
        rivals,
        ..effect
    };
    Ok((effect, Some(reduced)))
}

/// Whether an arm delivers the commanded speed and a constant more. Restitution that falls as that constant over the speed launches
/// alike, and no form that the library gives it excludes it.
fn is_speed_offset(part: &Part) -> bool {
    let value = |name| part.parameters.get(name).copied();
    part.name == "striker_speed_error"
        && value("cap").is_none()
        && value("offset").is_some_and(|offset| offset > 0.0)
}

/// Whether the data exclude another effect in the place of a named one. Of effects that differ in form alone, and whose form is
/// a choice of the library's, more is asked than odds.
fn is_excluded(name: &str, evidence: f64, rival: &CandidateFit, thresholds: &Thresholds) -> bool {
    let share = if alike(name).contains(&rival.name) {
        thresholds.alike
    } else {
        1.0
    };
    rival.evidence < share * (evidence - thresholds.excluded)
}

/// Whether an effect, or one that does nearly the same, is a special case of another.
fn contains(name: &str, special: &str) -> bool {
    let of = simpler(name);
    of.contains(&special) || alike(special).iter().any(|alike| of.contains(alike))
}
