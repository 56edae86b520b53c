//! Adds effects one by one; when none is left to add, replaces those for which another is better.

use std::collections::BTreeSet;

use world::{
    WorldError,
    effects::{Family, effect},
};

use super::refine::{refine, standing, with_rivals};
use super::{CandidateFit, FitCriteria, Selection, alike, fit_possible};
use crate::{
    candidates::Candidate,
    evidence::{Alarm, REAL, Statistic},
    fit::Fitted,
    null::renewed,
    score::{Replicates, ScoreTest, signs},
    screen::{Chance, Screened, screen_by},
    smooth::family_columns,
    strikes::PreparedStrikes,
};

/// What a search may do.
pub(crate) struct Limits<'l> {
    /// Greatest number of effects.
    pub(crate) effects: usize,
    /// Evidence that the first effect must bring for each value that it frees.
    pub(crate) first: f64,
    /// Sign flips by which another effect is tested for chance.
    pub(crate) flips: Replicates,
    pub(crate) alarm: &'l Alarm,
}

/// Adds effects while each brings more than chance, and asks of each whether another could stand in its place.
pub(crate) fn search<'a>(
    prepared: &PreparedStrikes<'a>,
    null: &Fitted,
    first: &[Screened],
    candidates: &[Candidate],
    chance: &Chance,
    limits: &Limits<'_>,
) -> Result<Selection<'a>, WorldError> {
    let mut selection = Selection {
        prepared: prepared.clone(),
        null: null.clone(),
        fitted: null.clone(),
        effects: Vec::new(),
    };
    // Beside the effects held, candidates are screened where another may be added.
    let mut screened = Some(first.to_vec());
    let mut short = candidates.to_vec();
    // Each effect that is replaced makes the model better: so often at the most, for noise is estimated anew between.
    for _ in 0..=limits.effects {
        let mut is_larger = false;
        while selection.effects.len() < limits.effects {
            let beside = match screened.take() {
                Some(screened) => screened,
                None => screen_beside_family(&selection, candidates)?,
            };
            let Some(fit) = next_effect(&selection, &beside, chance, limits)? else {
                break;
            };
            let Some((prepared, null, fitted)) =
                renewed(&selection.prepared, &selection.null, &fit.fitted)?
            else {
                break;
            };
            let held = selection.effects.len();
            let larger = Selection {
                prepared,
                null,
                fitted,
                effects: Vec::new(),
            };
            short = shortlist(candidates, &beside);
            selection = standing(larger, chance)?;
            is_larger = true;
            if selection.effects.len() <= held {
                break;
            }
        }
        if !is_larger {
            break;
        }
        let before = selection.names();
        selection = refine(selection, &short, chance, before.len())?;
        if selection.names() == before {
            break;
        }
    }
    with_rivals(selection, &short, chance)
}

/// Candidates that do nearly the same as this one; if it is friction by place, all candidates of friction by place.
fn of_a_kind(screened: &[Screened], name: &str) -> Vec<&'static str> {
    let is_by_place = |name: &str| {
        let spec = effect(name);
        spec.is_ok_and(|spec| spec.family == Family::FrictionByPlace)
    };
    let names = screened.iter().map(|screened| screened.name);
    names
        .filter(|other| alike(name).contains(other) || is_by_place(name) && is_by_place(other))
        .collect()
}

/// Every candidate beside the model and what a wrong form of its effects would leave; and how likely each is by chance.
fn screen_beside_family(
    selection: &Selection<'_>,
    candidates: &[Candidate],
) -> Result<Vec<Screened>, WorldError> {
    let Selection {
        prepared, fitted, ..
    } = selection;
    let family = family_columns(prepared, fitted);
    match ScoreTest::new(prepared, fitted, &family, Replicates::NONE) {
        Some(test) => screen_by(prepared, fitted, &test, candidates),
        None => Ok(Vec::new()),
    }
}

/// Share of the largest gain of candidates that fit at no possible value, below which an effect is not their cause: they stand for something that the
/// library lacks.
const SAYS: f64 = 0.5;

/// The effect that is added next, fitted; none where no candidate brings enough. Beside effects that are held it must be no chance: that takes
/// flips of all candidates, which are made once one brings enough.
fn next_effect(
    selection: &Selection<'_>,
    screened: &[Screened],
    chance: &Chance,
    limits: &Limits<'_>,
) -> Result<Option<CandidateFit>, WorldError> {
    let Selection {
        prepared, fitted, ..
    } = selection;
    let is_first = selection.effects.is_empty();
    let drawn = limits.alarm.beside(&Statistic::all(screened));
    let mut open: Vec<Screened> = screened
        .iter()
        .filter(|s| s.gain() > prepared.thresholds.fitted * chance[s.name])
        .filter(|s| is_first || drawn.p_value_of(s.name).drawn < REAL)
        .cloned()
        .collect();
    let is_enough = |fit: &CandidateFit| {
        let by_form = match is_of_a_family_held(selection, fit.name) {
            true => 1.0,
            false => taken_by_form(screened, fit.name, prepared.thresholds.form_least),
        };
        fit.evidence > required_evidence(selection, fit, by_form, limits.first)
    };
    let mut significant: Option<Alarm> = None;
    let mut said = 0.0f64;
    let mut impossible = BTreeSet::new();
    while !open.is_empty() {
        let best = open
            .iter()
            .max_by(|a, b| (a.gain() - chance[a.name]).total_cmp(&(b.gain() - chance[b.name])));
        // A line is near to a wide disc, and its step to the end: what is of a kind is compared where each ends.
        let required = best.map_or(Vec::new(), |best| of_a_kind(&open, best.name));
        let criteria = FitCriteria {
            required: &required,
            ..FitCriteria::default()
        };
        let names: Vec<&str> = best.iter().map(|best| best.name).collect();
        let fits = fit_possible(prepared, fitted, &open, chance, criteria, &mut impossible)?;
        let unfitted = best.filter(|best| fits.iter().all(|fit| fit.name != best.name));
        said = unfitted.map_or(said, |best| said.max(best.gain() - chance[best.name]));
        let is_fitted = |name: &str| names.contains(&name) || fits.iter().any(|f| f.name == name);
        open.retain(|s| !is_fitted(s.name));
        let is_cause = |fit: &CandidateFit| is_enough(fit) && fit.evidence > SAYS * said;
        for fit in fits.into_iter().filter(is_cause) {
            if is_first {
                return Ok(Some(fit));
            }
            let significant = significant.get_or_insert_with(|| {
                let signs = signs(prepared.strikes.len(), limits.flips);
                let mut flipped = screened.to_vec();
                flipped.iter_mut().for_each(|s| s.flip(&signs));
                limits.alarm.beside(&Statistic::all(&flipped))
            });
            if significant.p_value_of(fit.name).is_real() {
                return Ok(Some(fit));
            }
        }
    }
    Ok(None)
}

/// Whether an effect of the same family is held. A line or a slope explains what is left of a patch whose edge is soft, or that is no disc.
fn is_of_a_family_held(selection: &Selection<'_>, name: &str) -> bool {
    let family = |name: &str| effect(name).ok().map(|spec| spec.family);
    let mut held = selection.effects.iter();
    held.any(|held| family(held.name) == family(name))
}

/// Share of a candidate's score that a wrong form of the effects held would explain, as smooth dependences of their families show it: at least
/// `least`. A change of launches by their order, beside a patch of the table, is not of the patch's form, however strong it is.
fn taken_by_form(screened: &[Screened], name: &str, least: f64) -> f64 {
    let found = screened.iter().find(|screened| screened.name == name);
    let left = found.map(|found| found.score / found.gain());
    let taken = left.map_or(1.0, |left| 1.0 - left);
    if taken.is_finite() {
        taken.clamp(least, 1.0)
    } else {
        1.0
    }
}

/// Evidence that another effect must bring, where a wrong form of the effects held would explain this share of its score.
fn required_evidence(
    selection: &Selection<'_>,
    fit: &CandidateFit,
    by_form: f64,
    first: f64,
) -> f64 {
    let own = fit.fitted.model.free.len() - selection.fitted.model.free.len();
    if selection.effects.is_empty() {
        return first * own as f64;
    }
    let thresholds = selection.prepared.thresholds;
    let form = by_form * thresholds.form * selection.gain();
    // An effect that does nearly what another does stands beside it only where the form of neither is enough.
    let alike = alike(fit.name);
    selection
        .effects
        .iter()
        .filter(|held| alike.contains(&held.name))
        .map(|held| (1.0 - thresholds.alike) * held.evidence)
        .fold(f64::max(thresholds.another * own as f64, form), f64::max)
}

/// For each candidate, the starts to try in another's place: those that were best when it was last screened.
fn shortlist(candidates: &[Candidate], screened: &[Screened]) -> Vec<Candidate> {
    candidates
        .iter()
        .map(|candidate| {
            let found = screened.iter().find(|s| s.name == candidate.name);
            Candidate {
                name: candidate.name,
                starts: found.map_or_else(|| candidate.starts.clone(), |s| s.shortlist.clone()),
            }
        })
        .collect()
}
