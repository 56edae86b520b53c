//! Asks of every effect held whether another fits better in its place, and how firmly it stands.

use rayon::prelude::*;
use values::Strike;
use world::WorldError;

use super::{
    CandidateFit, FitCriteria, SelectedEffect, Selection, alike, evidence_of, fit_best, is_field,
    simpler,
};
use crate::candidates::{Candidate, is_never_named};
use crate::fit::{Fitted, Goal};
use crate::mixed::GREATEST;
use crate::model::{Model, Part, has_details};
use crate::question::{self, Answer};
use crate::screen::{Chance, Screened, screen};
use crate::smooth::{Covariate, family};
use crate::strikes::PreparedStrikes;
use crate::{Thresholds, gap};

/// The selection refitted without the effect at `place`; of the others, only the evidence is computed ([`with_rivals`] finds their rivals).
pub(crate) fn without<'a>(
    mut selection: Selection<'a>,
    place: usize,
    chance: &Chance,
) -> Result<Selection<'a>, WorldError> {
    let reduced = match reduced(&selection, place)? {
        Some(from) => selection
            .prepared
            .fit_from(&from, &from.model, Goal::Settled)?,
        None => None,
    };
    let fitted = reduced.unwrap_or_else(|| selection.null.clone());
    selection = selection.holding(fitted);
    selection.effects = alone(&selection, chance)?;
    Ok(selection)
}

/// The selection without its first effect of friction or launch speed by strike order for which what is left without it `is_wander`. Friction may
/// then wander up to [`GREATEST`]: an effect is sought beside a narrowly bounded walk, because an unbounded one explains any drift. Launch speeds that change
/// while friction does are no wander of their own. `None` where there is no such effect.
pub(crate) fn with_wander<'a>(
    selection: &Selection<'a>,
    chance: &Chance,
    is_wander: &dyn Fn(&Selection<'a>) -> bool,
) -> Result<Option<Selection<'a>>, WorldError> {
    let Selection {
        prepared,
        null,
        fitted,
        ..
    } = selection;
    let is_over = |part: &Part, covariate| family(part.name).contains(&covariate);
    let parts = &fitted.model.parts;
    let does_friction_change = parts.iter().any(|part| is_over(part, Covariate::Wear));
    let asked = match does_friction_change {
        true => Covariate::Wear,
        false => Covariate::Order,
    };
    for (place, _) in parts
        .iter()
        .enumerate()
        .filter(|(_, part)| is_over(part, asked))
    {
        let refitted = |from: &Fitted, model: &Model| {
            let components = match does_friction_change {
                true => from.estimated.components.with_greatest_wander(GREATEST),
                false => from.estimated.components,
            };
            prepared.fit(model, &components, &from.nuisances, Goal::Settled)
        };
        let without = refitted(fitted, &fitted.model.without(place))?;
        let (Some(fitted), Some(null)) = (without, refitted(null, &null.model)?) else {
            continue;
        };
        let selection = Selection {
            prepared: prepared.clone(),
            null,
            fitted,
            effects: Vec::new(),
        };
        if is_wander(&selection) {
            return standing(selection, chance).map(Some);
        }
    }
    Ok(None)
}

/// Place of the effect without which the stops of these commands move least, if that is little beside the scatter of repeats: nobody who strikes
/// would see it, and a model that is slightly wrong looks like it. Effects stated as a cause stay: they say that the names beside them are not all.
pub(crate) fn least_that_moves_little(
    selection: &Selection<'_>,
) -> Result<Option<usize>, WorldError> {
    let Selection {
        prepared, fitted, ..
    } = selection;
    let parts = fitted.model.parts.iter().enumerate();
    let named: Vec<usize> = parts
        .filter(|(_, part)| !is_never_named(part.name))
        .map(|(place, _)| place)
        .collect();
    if named.is_empty() {
        return Ok(None);
    }
    let floor = question::variation(prepared, fitted, &Answer::default())
        .repeats
        .value;
    let with = prepared.ends(&fitted.model)?;
    let mut least: Option<(usize, f64)> = None;
    for place in named {
        let Some(without) = reduced(selection, place)? else {
            continue;
        };
        let moved = gap::rms_between(&with, &prepared.ends(&without.model)?);
        if moved
            < least.map_or(question::little(floor, prepared.resolved), |(_, least)| {
                least
            })
        {
            least = Some((place, moved));
        }
    }
    Ok(least.map(|(place, _)| place))
}

/// The selection with the details of its effects' forms free, without the effects that stood for them. No name rests on a detail; every interval does.
/// Where a rival of its kind, with details of its own, is likelier than an effect, it takes its place: a wide disc is nearer to a curved seam than a straight
/// one is.
pub(crate) fn with_details<'a>(
    mut selection: Selection<'a>,
    candidates: &[Candidate],
    chance: &Chance,
) -> Result<Selection<'a>, WorldError> {
    if !selection
        .fitted
        .model
        .parts
        .iter()
        .any(|part| has_details(part.name))
    {
        return Ok(selection);
    }
    if let Some(fitted) = detailed(&selection.prepared, &selection.fitted)? {
        selection = selection.holding(fitted);
    }
    selection = standing(selection, chance)?;
    for place in 0..selection.fitted.model.parts.len() {
        if let Some(fitted) = detailed_rival(&selection, place, candidates, chance)? {
            selection = standing(selection.holding(fitted), chance)?;
            break;
        }
    }
    Ok(selection)
}

/// The model with the best rival of its kind in the place of an effect, both with details, where that is better.
fn detailed_rival(
    selection: &Selection<'_>,
    place: usize,
    candidates: &[Candidate],
    chance: &Chance,
) -> Result<Option<Fitted>, WorldError> {
    let prepared = &selection.prepared;
    let SelectedEffect { name, evidence, .. } = selection.effects[place];
    let is_rival = |candidate: &&Candidate| candidate.name != name && has_details(candidate.name);
    let rivals: Vec<Candidate> = candidates.iter().filter(is_rival).cloned().collect();
    let reduced = match has_details(name) {
        true => reduced(selection, place)?,
        false => None,
    };
    let Some(reduced) = reduced.filter(|_| !rivals.is_empty()) else {
        return Ok(None);
    };
    let criteria = FitCriteria {
        required: &[],
        least_gain: Some(0.0),
        least_evidence: f64::NEG_INFINITY,
    };
    let screened = screen(prepared, &reduced, &rivals)?;
    let mut best: Option<(f64, Fitted)> = None;
    for rival in fit_best(prepared, &reduced, &screened, chance, criteria)? {
        let rival = with_own_details(prepared, rival)?;
        let least = best
            .as_ref()
            .map_or(evidence + prepared.thresholds.better, |best| best.0);
        if rival.evidence > least {
            best = Some((rival.evidence, rival.fitted));
        }
    }
    Ok(best.map(|(_, fitted)| fitted))
}

/// A rival with the details of its form free.
fn with_own_details(
    prepared: &PreparedStrikes<'_>,
    rival: CandidateFit,
) -> Result<CandidateFit, WorldError> {
    Ok(match detailed(prepared, &rival.fitted)? {
        Some(fitted) => CandidateFit {
            evidence: rival.evidence + fitted.likelihood() - rival.fitted.likelihood(),
            fitted,
            ..rival
        },
        None => rival,
    })
}

/// A fit with the details of its effects' forms free; `None` where there is none to be freed. Details of a form at the end of its range would make one that
/// is not measured look as if it were.
fn detailed(prepared: &PreparedStrikes<'_>, from: &Fitted) -> Result<Option<Fitted>, WorldError> {
    let at_end = from.forms_at_end();
    let is_measured = |place| {
        let mut forms = from.model.forms();
        !forms.any(|(i, part, _)| part == place && at_end.contains(&i))
    };
    match from.model.with_details(is_measured) {
        Some(model) => prepared.fit_from(from, &model, Goal::Settled),
        None => Ok(None),
    }
}

/// The selection without the effects whose evidence beside the others is negative; of those kept, only the evidence is computed.
pub(super) fn standing<'a>(
    mut selection: Selection<'a>,
    chance: &Chance,
) -> Result<Selection<'a>, WorldError> {
    loop {
        selection.effects = alone(&selection, chance)?;
        let mut effects = selection.effects.iter();
        let idle = effects.find(|effect| effect.evidence < 0.0 && effect.fit_without.is_some());
        match idle.and_then(|effect| effect.fit_without.clone()) {
            Some(reduced) => selection = selection.holding(reduced),
            None => return Ok(selection),
        }
    }
}

/// Each effect and its evidence beside the others.
fn alone(selection: &Selection<'_>, chance: &Chance) -> Result<Vec<SelectedEffect>, WorldError> {
    (0..selection.fitted.model.parts.len())
        .into_par_iter()
        .map(|place| {
            let reduced = reduced(selection, place)?;
            Ok(effect_alone(selection, place, reduced, chance))
        })
        .collect()
}

/// Number of free values above which only close rivals are tried: each trial costs as much as fitting them all.
pub(super) const MANY: usize = 40;

/// The selection with the rivals of each effect: candidates that fit nearly as well in its place. In a model of more than [`MANY`] values, only
/// candidates alike to an effect are tried, and none for a field.
pub(crate) fn with_rivals<'a>(
    mut selection: Selection<'a>,
    candidates: &[Candidate],
    chance: &Chance,
) -> Result<Selection<'a>, WorldError> {
    let is_large = selection.fitted.model.free.len() > MANY;
    let asked = |name: &str| -> Vec<Candidate> {
        let is_asked = |rival: &str| !is_large || !is_field(name) && alike(name).contains(&rival);
        let candidates = candidates.iter().filter(|rival| is_asked(rival.name));
        candidates.cloned().collect()
    };
    if selection.effects.is_empty() {
        selection.effects = alone(&selection, chance)?;
    }
    let effects = std::mem::take(&mut selection.effects)
        .into_par_iter()
        .enumerate()
        .map(|(place, effect)| {
            let rivals = asked(effect.name);
            assessed(&selection, place, effect, &rivals, chance)
        })
        .collect::<Result<_, WorldError>>()?;
    selection.effects = effects;
    Ok(selection)
}

/// Replaces or drops an effect where that is better, at most `changes` times; of those kept, only the evidence is computed.
pub(super) fn refine<'a>(
    mut selection: Selection<'a>,
    candidates: &[Candidate],
    chance: &Chance,
    changes: usize,
) -> Result<Selection<'a>, WorldError> {
    for _ in 0..changes {
        selection = standing(selection, chance)?;
        let places: Vec<usize> = (0..selection.fitted.model.parts.len()).collect();
        let mut better = None;
        // As many at once as there are threads: the first that is replaced decides, however many were asked beside it.
        for places in places.chunks(rayon::current_num_threads()) {
            let found: Vec<(Vec<Screened>, Option<Fitted>)> = places
                .par_iter()
                .map(|place| rivals_of(&selection, *place, candidates, chance))
                .collect::<Result<_, WorldError>>()?;
            for (place, (screened, rival)) in places.iter().zip(found) {
                selection.effects[*place].screened = Some(screened);
                better = better.or(rival);
            }
            if better.is_some() {
                break;
            }
        }
        match better {
            Some(fitted) => selection = selection.holding(fitted),
            None => return Ok(selection),
        }
    }
    standing(selection, chance)
}

/// Share of an effect's linear gain below which no rival replaced one: a linear gain predicts that of the fit to some per cent.
const NEAR: f64 = 0.9;

/// The model with the best rival in the place of one of its effects, where that is better.
pub(super) fn replaced(
    selection: &Selection<'_>,
    place: usize,
    candidates: &[Candidate],
    chance: &Chance,
) -> Result<Option<Fitted>, WorldError> {
    let (_, better) = rivals_of(selection, place, candidates, chance)?;
    Ok(better)
}

/// The screening of every candidate in the place of an effect, and the model with the best of them there, where that is better.
fn rivals_of(
    selection: &Selection<'_>,
    place: usize,
    candidates: &[Candidate],
    chance: &Chance,
) -> Result<(Vec<Screened>, Option<Fitted>), WorldError> {
    let prepared = &selection.prepared;
    let Some(reduced) = reduced(selection, place)? else {
        return Ok((Vec::new(), None));
    };
    let SelectedEffect { name, evidence, .. } = selection.effects[place];
    let all = screen(prepared, &reduced, candidates)?;
    let (own, screened): (Vec<Screened>, Vec<Screened>) =
        all.iter().cloned().partition(|s| s.name == name);
    let better = evidence + prepared.thresholds.better;
    let criteria = FitCriteria {
        required: &[],
        least_gain: Some(NEAR * own.first().map_or(evidence, |own| own.gain().min(evidence))),
        least_evidence: better,
    };
    let rivals = fit_best(prepared, &reduced, &screened, chance, criteria)?;
    let best = rivals.into_iter().next();
    let best = best.filter(|rival| rival.evidence > better);
    Ok((all, best.map(|rival| rival.fitted)))
}

/// The model without one of its effects, fitted only as far as comparing needs, and once; `None` where that fit diverges.
fn reduced(selection: &Selection<'_>, place: usize) -> Result<Option<Fitted>, WorldError> {
    let Selection {
        prepared, fitted, ..
    } = selection;
    match selection.effects.get(place) {
        Some(effect) => Ok(effect.fit_without.clone()),
        None => prepared.fit_from(fitted, &fitted.model.without(place), Goal::LIKELIHOOD),
    }
}

/// An effect and its evidence beside the others; infinite where no model without it can be fitted.
fn effect_alone(
    selection: &Selection<'_>,
    place: usize,
    without: Option<Fitted>,
    chance: &Chance,
) -> SelectedEffect {
    let fitted = &selection.fitted;
    let name = fitted.model.parts[place].name;
    let evidence = without.as_ref().map_or(f64::INFINITY, |reduced| {
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
        fit_without: without,
        screened: None,
        equivalent: Vec::new(),
        rivals: Vec::new(),
    }
}

/// An effect with its equivalents and rivals beside the others.
fn assessed(
    selection: &Selection<'_>,
    place: usize,
    mut effect: SelectedEffect,
    candidates: &[Candidate],
    chance: &Chance,
) -> Result<SelectedEffect, WorldError> {
    let known = effect.screened.take();
    let Some(reduced) = &effect.fit_without else {
        return Ok(effect);
    };
    let Selection {
        prepared, fitted, ..
    } = selection;
    let thresholds = prepared.thresholds;
    let (name, evidence) = (effect.name, effect.evidence);
    let part = &fitted.model.fitted_parts(&fitted.model.values)[place];
    let is_offset = is_speed_offset(part, &prepared.strikes);
    let at_end = fitted.forms_at_end();
    let is_at_end = fitted
        .model
        .forms()
        .any(|(i, of, _)| of == place && at_end.contains(&i));
    let screened = match known {
        Some(known) => known,
        None => screen(prepared, reduced, candidates)?,
    };
    let is_asked = |s: &Screened| candidates.iter().any(|asked| asked.name == s.name);
    let (own, screened): (Vec<Screened>, Vec<Screened>) = screened
        .into_iter()
        .filter(is_asked)
        .partition(|s| s.name == name);
    let incumbent = own.first().map(|own| own.gain().min(evidence));
    let criteria = FitCriteria {
        required: alike(name),
        least_gain: incumbent.map(|gain| thresholds.fitted * gain),
        least_evidence: f64::NEG_INFINITY,
    };
    let mut rivals = fit_best(prepared, reduced, &screened, chance, criteria)?;
    if has_details(name) {
        let each = rivals.into_iter();
        rivals = each
            .map(|rival| with_own_details(prepared, rival))
            .collect::<Result<_, WorldError>>()?;
        rivals.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    }
    // They are to compare with, not to fit on from.
    for rival in &mut rivals {
        rival.fitted.drop_columns();
    }
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
    Ok(SelectedEffect {
        equivalent,
        rivals,
        ..effect
    })
}

/// Share of an arm's speed offset below which its cap takes too little off to tell the offset from restitution.
const LITTLE_CAP: f64 = 0.1;

/// Whether a part is a constant added to the commanded speed, from which a hard cap takes little off (root mean square over strikes). A restitution
/// that falls as that constant over the speed launches alike, and no form in the library excludes it.
fn is_speed_offset(part: &Part, strikes: &[&Strike]) -> bool {
    let value = |name, neutral| part.parameters.get(name).copied().unwrap_or(neutral);
    let (offset, slope) = (value("offset", 0.0), value("slope", 1.0));
    let cap = value("cap", f64::INFINITY);
    let beyond = |strike: &&Strike| (offset + slope * strike.command.speed - cap).max(0.0);
    let squares: f64 = strikes.iter().map(|strike| beyond(strike).powi(2)).sum();
    let taken = (squares / strikes.len().max(1) as f64).sqrt();
    let is_hard = cap.is_infinite() || value("softness", 0.0) == 0.0;
    part.name == "striker_speed_error" && is_hard && offset > 0.0 && taken < LITTLE_CAP * offset
}

/// Whether the data exclude a rival in the place of a named effect. Where the two differ in form alone, which is a choice of the library's, more than
/// the odds is asked.
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
