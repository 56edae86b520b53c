//! Adds effects one by one; when none is left to add, exchanges two.

use world::WorldError;

use super::{
    CandidateFit, Selection,
    exchange::exchanged,
    fits::{FitCriteria, fit_best},
    penalty::alike,
    refine::refine,
};
use crate::{
    candidates::Candidate,
    evidence::{Alarm, Statistic},
    fit::Fitted,
    null::renewed,
    score::{Replicates, ScoreTest},
    screen::{Chance, Screened, screen_by},
    smooth::family_columns,
    strikes::PreparedStrikes,
};

/// What a search may do.
pub(crate) struct Limits<'l> {
    /// Effects at the most.
    pub(crate) effects: usize,
    /// By which another effect is shown to be no chance.
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
    let mut screening = Some(Screening {
        screened: first.to_vec(),
        significant: None,
    });
    let mut short = candidates.to_vec();
    // Each exchange makes the model better: so many at the most, for noise is estimated anew between them.
    for _ in 0..=limits.effects {
        while let Some(Screening {
            screened,
            significant,
        }) = screening.take()
        {
            if selection.effects.len() >= limits.effects {
                break;
            }
            let Some(fit) = next_effect(&selection, &screened, chance, significant.as_ref())?
            else {
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
            short = shortlist(candidates, &screened);
            selection = refine(larger, &short, chance, held)?;
            if selection.effects.len() > held {
                screening = screen_beside_family(&selection, candidates, limits)?;
            }
        }
        let (better, is_better) = exchanged(selection, &short, chance)?;
        selection = better;
        if !is_better {
            break;
        }
        screening = screen_beside_family(&selection, candidates, limits)?;
    }
    Ok(selection)
}

/// Candidates beside a model; beside one with effects, how likely each is by chance.
struct Screening {
    screened: Vec<Screened>,
    significant: Option<Alarm>,
}

/// Every candidate beside the model and what a wrong form of its effects would leave; and how likely each is by chance.
fn screen_beside_family(
    selection: &Selection<'_>,
    candidates: &[Candidate],
    limits: &Limits<'_>,
) -> Result<Option<Screening>, WorldError> {
    let Selection {
        prepared, fitted, ..
    } = selection;
    let family = family_columns(prepared, fitted)?;
    let Some(test) = ScoreTest::new(prepared, fitted, &family, limits.flips) else {
        return Ok(None);
    };
    let screened = screen_by(prepared, fitted, &test, candidates, limits.flips)?;
    Ok(Some(Screening {
        significant: Some(limits.alarm.beside(&Statistic::all(&screened, &[]))),
        screened,
    }))
}

/// The effect that is added next, fitted; none where no candidate brings enough.
fn next_effect(
    selection: &Selection<'_>,
    screened: &[Screened],
    chance: &Chance,
    significant: Option<&Alarm>,
) -> Result<Option<CandidateFit>, WorldError> {
    let Selection {
        prepared, fitted, ..
    } = selection;
    let mut open: Vec<Screened> = screened
        .iter()
        .filter(|s| s.gain() > prepared.thresholds.fitted * chance[s.name])
        .filter(|s| significant.is_none_or(|alarm| alarm.p_value_of(s.name).is_real()))
        .cloned()
        .collect();
    let is_enough = |fit: &CandidateFit| {
        let by_form = taken_by_form(screened, fit.name, prepared.thresholds.form_least);
        fit.evidence > required_evidence(selection, fit, by_form)
    };
    while !open.is_empty() {
        let best = open
            .iter()
            .max_by(|a, b| (a.gain() - chance[a.name]).total_cmp(&(b.gain() - chance[b.name])));
        let criteria = FitCriteria {
            required: best.map_or(&[], |best| alike(best.name)),
            ..FitCriteria::default()
        };
        let names: Vec<&str> = best.iter().map(|best| best.name).collect();
        let fits = fit_best(prepared, fitted, &open, chance, criteria)?;
        let is_fitted = |name: &str| names.contains(&name) || fits.iter().any(|f| f.name == name);
        open.retain(|s| !is_fitted(s.name));
        if let Some(fit) = fits.into_iter().find(is_enough) {
            return Ok(Some(fit));
        }
    }
    Ok(None)
}

/// Share of a candidate's score that what a wrong form of the effects held would leave takes: a change of launches by their order, beside a
/// patch of the table, is not of the patch's form, however strong that is. No share is taken for less than `least`: what is gone through
/// are smooth forms.
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

/// Evidence that is asked of another effect, of whose score a wrong form of the effects held would take this share.
fn required_evidence(selection: &Selection<'_>, fit: &CandidateFit, by_form: f64) -> f64 {
    if selection.effects.is_empty() {
        return 0.0;
    }
    let own = fit.fitted.model.free.len() - selection.fitted.model.free.len();
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

/// Starts of each candidate that are tried in another's place: the best where it was last screened.
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
