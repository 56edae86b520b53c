//! One effect in the place of all those of its kind: a smooth field where it is likelier than the simpler ones together, and what is never
//! named where it is likelier than a field or several of them.

use world::{
    WorldError,
    effects::{Family, Naming, effect},
};

use super::{
    Selection,
    fits::{FitCriteria, Tried, fit_best},
    refine::refine,
};
use crate::{
    Thresholds,
    candidates::Candidate,
    evidence,
    null::renewed,
    score::{Replicates, ScoreTest},
    screen::{Chance, screen, screen_by},
};

/// Asks each last resort whether it stands better than all effects of its kind together, which hold less than what explains a gap of what
/// it gains; where no effect is held, whether it stands at all.
pub(crate) fn with_last_resorts<'a>(
    mut selection: Selection<'a>,
    last_resorts: &[Candidate],
    candidates: &[Candidate],
    chance: &Chance,
) -> Result<Selection<'a>, WorldError> {
    for last_resort in last_resorts {
        if selection.fitted.model.parts.is_empty()
            || !held_beside(&selection, last_resort).is_empty()
        {
            let explains = |gain: Gain, thresholds: &Thresholds| {
                thresholds.explained * gain.alone - gain.by_chance > gain.held + thresholds.better
            };
            selection = replaced(selection, last_resort, candidates, chance, explains)?;
        }
    }
    Ok(selection)
}

/// Asks each of those that are never named whether it stands better than a field or several effects of its kind, which are less simple; or so
/// much better than a single one that this is excluded.
pub(crate) fn with_never_named<'a>(
    mut selection: Selection<'a>,
    never_named: &[Candidate],
    candidates: &[Candidate],
    chance: &mut Chance,
    replicates: Replicates,
) -> Result<Selection<'a>, WorldError> {
    for candidate in never_named {
        let held = held_beside(&selection, candidate);
        if held.is_empty() {
            continue;
        }
        let Selection { prepared, null, .. } = &selection;
        let Some(test) = ScoreTest::new(prepared, null, &[], replicates) else {
            continue;
        };
        let screened = std::slice::from_ref(candidate);
        let screened = screen_by(prepared, null, &test, screened, replicates)?;
        drop(test);
        chance.extend(evidence::chance(&screened));
        let is_field = |name: &str| effect(name).is_ok_and(|s| s.naming == Naming::LastResort);
        let is_simpler = held.len() > 1 || is_field(held[0]);
        let is_better = |gain: Gain, thresholds: &Thresholds| {
            let evidence = gain.alone - gain.by_chance;
            let share = if is_simpler { 1.0 } else { thresholds.alike };
            gain.held + thresholds.better < share * evidence
        };
        selection = replaced(selection, candidate, candidates, chance, is_better)?;
    }
    Ok(selection)
}

/// Log-likelihood that one effect gains in the place of all those of its kind.
#[derive(Clone, Copy)]
struct Gain {
    alone: f64,
    /// What it would gain by chance.
    by_chance: f64,
    /// What those of its kind gain together beyond chance.
    held: f64,
}

/// Names of the effects held that are of a candidate's kind.
fn held_beside(selection: &Selection<'_>, candidate: &Candidate) -> Vec<&'static str> {
    let parts = selection.fitted.model.parts.iter();
    parts
        .map(|part| part.name)
        .filter(|name| kind(name) == kind(candidate.name))
        .collect()
}

fn kind(name: &str) -> Option<Family> {
    effect(name).ok().map(|spec| spec.family)
}

/// The same with a candidate in the place of all effects of its kind, where what it gains is enough.
fn replaced<'a>(
    selection: Selection<'a>,
    candidate: &Candidate,
    candidates: &[Candidate],
    chance: &Chance,
    is_enough: impl Fn(Gain, &Thresholds) -> bool,
) -> Result<Selection<'a>, WorldError> {
    let Selection {
        prepared, fitted, ..
    } = &selection;
    let mut model = fitted.model.clone();
    let mut by_chance = 0.0;
    for place in (0..model.parts.len()).rev() {
        let name = model.parts[place].name;
        if kind(name) == kind(candidate.name) {
            model = model.without(place);
            by_chance += chance[name];
        }
    }
    let Some(reduced) = prepared.fit_from(fitted, &model)? else {
        return Ok(selection);
    };
    let screened = screen(prepared, &reduced, std::slice::from_ref(candidate))?;
    let criteria = FitCriteria {
        required: &[candidate.name],
        ..FitCriteria::default()
    };
    let fits = fit_best(
        prepared,
        &reduced,
        &screened,
        chance,
        criteria,
        &mut Tried::new(),
    )?;
    let held = (fitted.likelihood() - reduced.likelihood() - by_chance).max(0.0);
    let Some(fit) = fits.into_iter().find(|fit| {
        let gain = Gain {
            alone: fit.fitted.likelihood() - reduced.likelihood(),
            by_chance: chance[candidate.name],
            held,
        };
        is_enough(gain, prepared.thresholds)
    }) else {
        return Ok(selection);
    };
    let Some((prepared, null, fitted)) = renewed(prepared, &selection.null, &fit.fitted)? else {
        return Ok(selection);
    };
    let replaced = Selection {
        prepared,
        null,
        fitted,
        effects: Vec::new(),
    };
    refine(replaced, candidates, chance, 0)
}
