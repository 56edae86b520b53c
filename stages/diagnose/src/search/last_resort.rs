//! One effect in the place of all those of its kind: a smooth field of friction where it is likelier than the simpler ones together; a table of any
//! shape, and what is never named, where they are likelier than what was found.

use world::{
    WorldError,
    effects::{Family, Naming, effect},
};

use super::refine::{MANY, replaced, standing};
use super::{FitCriteria, Selection, fit_best, is_field, simpler};
use crate::{
    candidates::Candidate,
    evidence,
    fit::{Fitted, Goal},
    null::renewed,
    score::{Replicates, ScoreTest},
    screen::{Chance, Screened, screen, screen_by},
};

/// Tries each last resort in the place of all effects of its kind, and keeps it where the share of its gain that counts as explained exceeds what
/// they gain together; where no such effect is held, in the place of none.
pub(crate) fn with_last_resorts<'a>(
    mut selection: Selection<'a>,
    last_resorts: &[Candidate],
    chance: &Chance,
) -> Result<Selection<'a>, WorldError> {
    for last_resort in last_resorts {
        if !selection.fitted.model.parts.is_empty()
            && held_beside(&selection, last_resort).is_empty()
        {
            continue;
        }
        let Some((fitted, gain)) = in_place_of_its_kind(&selection, last_resort, chance)? else {
            continue;
        };
        let thresholds = selection.prepared.thresholds;
        let evidence = thresholds.explained * gain.alone - chance[last_resort.name];
        if evidence > gain.held + thresholds.better {
            selection = with_fitted(selection, &fitted, chance)?;
        }
    }
    Ok(selection)
}

/// Tries each of these in the place of the effects of its kind. It replaces several of them where it is likelier; a single one where it is likelier
/// by enough to exclude that, or merely likelier if `is_too_little` says that one is known not to be enough; a field where it is nearly as likely,
/// being simpler.
pub(crate) fn with_replacements<'a>(
    mut selection: Selection<'a>,
    replacements: &[Candidate],
    chance: &mut Chance,
    replicates: Replicates,
    is_too_little: bool,
) -> Result<Selection<'a>, WorldError> {
    for candidate in replacements {
        let held = held_beside(&selection, candidate);
        let Selection { prepared, null, .. } = &selection;
        let thresholds = prepared.thresholds;
        let (share, margin) = match held[..] {
            [] if is_wanted(candidate, &selection) => (1.0, thresholds.better),
            [] => continue,
            // A picture that is stretched errs by angle as no form of an arm does: slides are longer where they are seen turned.
            [name] if kind(name) == Some(Family::LaunchAngleByCommand) => {
                (thresholds.explained, thresholds.excluded)
            }
            [name] if !is_field(name) && !is_too_little => (thresholds.alike, thresholds.better),
            [name] if !is_field(name) => (1.0, thresholds.better),
            // Its many values follow what is left of a single one's form.
            [_] => (thresholds.explained.powi(-2), thresholds.better),
            _ => (1.0, thresholds.better),
        };
        // What it gains by chance takes long to say, and is asked only where it matters.
        chance.insert(candidate.name, 0.0);
        let Some((fitted, gain)) = in_place_of_its_kind(&selection, candidate, chance)? else {
            continue;
        };
        let is_better = |by_chance: f64| share * (gain.alone - by_chance) > gain.held + margin;
        if !is_better(0.0) {
            continue;
        }
        let Some(test) = ScoreTest::new(prepared, null, &[], replicates) else {
            continue;
        };
        let screened = std::slice::from_ref(candidate);
        let screened = screen_by(prepared, null, &test, screened)?;
        drop(test);
        chance.extend(evidence::chance(&screened));
        if is_better(chance[candidate.name]) {
            selection = with_fitted(selection, &fitted, chance)?;
        }
    }
    Ok(selection)
}

/// Beside a field, which is found last, tries for each other effect whether a special case of it is enough now: the general form may have held a part
/// of what the field explains.
pub(crate) fn with_special_cases<'a>(
    mut selection: Selection<'a>,
    candidates: &[Candidate],
    chance: &Chance,
) -> Result<Selection<'a>, WorldError> {
    let parts = |selection: &Selection<'_>| -> Vec<&'static str> {
        let parts = selection.fitted.model.parts.iter();
        parts.map(|part| part.name).collect()
    };
    if !parts(&selection).into_iter().any(is_field) {
        return Ok(selection);
    }
    for name in parts(&selection) {
        let is_special = |candidate: &&Candidate| simpler(name).contains(&candidate.name);
        let special: Vec<Candidate> = candidates.iter().filter(is_special).cloned().collect();
        let place = parts(&selection).iter().position(|part| *part == name);
        let Some(place) = place.filter(|_| !is_field(name) && !special.is_empty()) else {
            continue;
        };
        if let Some(fitted) = replaced(&selection, place, &special, chance)? {
            selection = standing(selection.holding(fitted), chance)?;
        }
    }
    Ok(selection)
}

/// Whether a candidate is tried where no effect of its kind was found: a table of any shape, where tracks of a round object differ from the model by
/// far more than the camera's noise. Many bumps look like no single effect.
fn is_wanted(candidate: &Candidate, selection: &Selection<'_>) -> bool {
    let is_any_shape = effect(candidate.name).is_ok_and(|spec| spec.naming == Naming::InPlace);
    is_any_shape && selection.fitted.is_far_from_round(&selection.prepared)
}

/// Names of the effects held that are of a candidate's kind.
fn held_beside(selection: &Selection<'_>, candidate: &Candidate) -> Vec<&'static str> {
    let parts = selection.fitted.model.parts.iter();
    parts
        .map(|part| part.name)
        .filter(|name| takes_place_of(candidate.name, name))
        .collect()
}

/// Whether a candidate may replace an effect: one of its kind; for a surface of any shape also patches and edges of friction or a lens, which it may
/// have been taken for (beside a lens it would take what the lens's form leaves). A path that curls is taken for a slope and a grain together; a
/// picture that is stretched, for an arm that errs by angle and a grain; one that is shifted beyond a line, for a constant error or one by place; friction at the
/// beginning of each slide, for patches and fields, for what depends on speed, and for restitution that does; a table that
/// slopes otherwise in each session, for directions, friction and a slope.
fn takes_place_of(candidate: &str, held: &str) -> bool {
    match (kind(candidate), kind(held)) {
        (Some(Family::ForceByPlace), Some(Family::FrictionByPlace | Family::SeenByPlace)) => true,
        (Some(Family::FrictionByHeading), Some(Family::ForceByPlace)) => true,
        (
            Some(Family::SeenByHeading),
            Some(Family::LaunchAngle | Family::LaunchAngleByCommand | Family::FrictionByHeading),
        ) => true,
        (
            Some(Family::SeenBySide),
            Some(
                Family::LaunchAngle
                | Family::LaunchByPlace
                | Family::SeenByPlace
                | Family::SeenByHeading,
            ),
        ) => true,
        (
            Some(Family::FrictionBySlide),
            Some(Family::FrictionByPlace | Family::FrictionBySpeed | Family::RestitutionBySpeed),
        ) => true,
        (
            Some(Family::ForceBySession),
            Some(Family::FrictionByOrder | Family::LaunchAngleByOrder | Family::ForceByPlace),
        ) => true,
        (candidate, held) => candidate == held,
    }
}

fn kind(name: &str) -> Option<Family> {
    effect(name).ok().map(|spec| spec.family)
}

/// Log-likelihood that an effect gains in the place of all those of its kind.
struct Gain {
    alone: f64,
    /// What those of its kind gain together beyond chance.
    held: f64,
}

/// The model with a candidate in the place of all effects of its kind; `None` where none can be fitted.
fn in_place_of_its_kind(
    selection: &Selection<'_>,
    candidate: &Candidate,
    chance: &Chance,
) -> Result<Option<(Fitted, Gain)>, WorldError> {
    let Selection {
        prepared, fitted, ..
    } = selection;
    let mut model = fitted.model.clone();
    let mut by_chance = 0.0;
    for place in (0..model.parts.len()).rev() {
        let name = model.parts[place].name;
        if takes_place_of(candidate.name, name) {
            model = model.without(place);
            by_chance += chance[name];
        }
    }
    let Some(reduced) = prepared.fit_from(fitted, &model, Goal::LIKELIHOOD)? else {
        return Ok(None);
    };
    let held = (fitted.likelihood() - reduced.likelihood() - by_chance).max(0.0);
    let screened = screen(prepared, &reduced, std::slice::from_ref(candidate))?;
    // A fit of many values costs much: not where a linear step promises less than what is there. One of few values may gain more than its step.
    let promises_less = |screened: &Screened| {
        let start = screened.starts.first();
        start.is_some_and(|start| start.model.free.len() > MANY) && screened.gain() < held
    };
    if screened.iter().all(promises_less) {
        return Ok(None);
    }
    let criteria = FitCriteria {
        required: &[candidate.name],
        ..FitCriteria::default()
    };
    let fits = fit_best(prepared, &reduced, &screened, chance, criteria)?;
    Ok(fits.into_iter().next().map(|fit| {
        let gain = Gain {
            alone: fit.fitted.likelihood() - reduced.likelihood(),
            held,
        };
        (fit.fitted, gain)
    }))
}

/// The model with a candidate beside all its effects; `None` where it has it, or it cannot be fitted.
pub(crate) fn beside(
    selection: &Selection<'_>,
    candidate: &Candidate,
    chance: &Chance,
) -> Result<Option<Fitted>, WorldError> {
    let Selection {
        prepared, fitted, ..
    } = selection;
    if selection.names().contains(&candidate.name) {
        return Ok(None);
    }
    let screened = screen(prepared, fitted, std::slice::from_ref(candidate))?;
    let criteria = FitCriteria {
        required: &[candidate.name],
        ..FitCriteria::default()
    };
    let fits = fit_best(prepared, fitted, &screened, chance, criteria)?;
    Ok(fits.into_iter().next().map(|fit| fit.fitted))
}

/// The selection with `fitted` as its model, noise re-estimated and idle effects dropped; unchanged where that model cannot be fitted under its own
/// noise.
fn with_fitted<'a>(
    selection: Selection<'a>,
    fitted: &Fitted,
    chance: &Chance,
) -> Result<Selection<'a>, WorldError> {
    let Some((prepared, null, fitted)) = renewed(&selection.prepared, &selection.null, fitted)?
    else {
        return Ok(selection);
    };
    let other = Selection {
        prepared,
        null,
        fitted,
        effects: Vec::new(),
    };
    standing(other, chance)
}
