//! Two effects exchanged at once: of a pair that is wrong in both, neither is replaced alone.

use world::WorldError;

use super::{
    CandidateFit, Selection,
    penalty::{alike, simpler},
    refine::{assess, refine},
};
use crate::{
    candidates::Candidate,
    fit::Fitted,
    screen::{Chance, screen},
};

/// Rivals of each effect beside which the others are asked again.
const RIVALS: usize = 2;

/// The same with two effects exchanged for two others where those are better together; where they are as good, they are named as
/// equivalents.
pub(super) fn exchanged<'a>(
    mut selection: Selection<'a>,
    candidates: &[Candidate],
    chance: &Chance,
) -> Result<Selection<'a>, WorldError> {
    let thresholds = selection.prepared.thresholds;
    let held = selection.fitted.model.parts.len();
    if held < 2 {
        return Ok(selection);
    }
    let pairs = exchanges(&selection, candidates, chance)?;
    let here = worth(&selection.fitted, chance);
    let best = pairs
        .iter()
        .max_by(|a, b| a.worth.total_cmp(&b.worth))
        .filter(|best| best.worth > here + thresholds.better);
    if let Some(best) = best {
        selection.fitted = best.fitted.clone();
        return refine(selection, candidates, chance, held);
    }
    for pair in pairs
        .iter()
        .filter(|pair| pair.worth > here - thresholds.excluded)
    {
        for (out, other) in &pair.exchanged {
            let effect = selection.effects.iter_mut().find(|e| e.name == *out);
            if let Some(effect) = effect.filter(|effect| !effect.equivalent.contains(other)) {
                effect.equivalent.push(other);
            }
        }
    }
    Ok(selection)
}

/// A model with two effects exchanged.
struct Exchange {
    fitted: Fitted,
    worth: f64,
    /// Each effect that is left out, and the one in its place.
    exchanged: [(&'static str, &'static str); 2],
}

/// Log-likelihood less what the effects would gain by chance.
fn worth(fitted: &Fitted, chance: &Chance) -> f64 {
    let by_chance: f64 = fitted.model.parts.iter().map(|p| chance[p.name]).sum();
    fitted.likelihood() - by_chance
}

/// Every effect with one of its rivals in its place, and beside that every other effect with its best rival there.
fn exchanges(
    selection: &Selection<'_>,
    candidates: &[Candidate],
    chance: &Chance,
) -> Result<Vec<Exchange>, WorldError> {
    let mut found = Vec::new();
    for effect in &selection.effects {
        // One that contains others is another question, which the likelihood alone does not answer; beside one that does nearly the same,
        // the others were asked when it was not there.
        let near = |rival: &&CandidateFit| {
            let least = selection.prepared.thresholds.fitted_to_end * effect.evidence;
            rival.evidence > least
                && simpler(rival.name).is_empty()
                && !alike(effect.name).contains(&rival.name)
        };
        for rival in effect.rivals.iter().filter(near).take(RIVALS) {
            let beside = Selection {
                prepared: selection.prepared.clone(),
                null: selection.null.clone(),
                fitted: rival.fitted.clone(),
                effects: Vec::new(),
            };
            let lost = effect.evidence - rival.evidence;
            if !may_recover(&beside, lost, effect.name, candidates, chance)? {
                continue;
            }
            // The rival stands last.
            for place in 0..beside.fitted.model.parts.len().saturating_sub(1) {
                let (other, _) = assess(&beside, place, candidates, chance)?;
                let new =
                    |to: &&CandidateFit| to.name != effect.name && simpler(to.name).is_empty();
                if let Some(to) = other.rivals.iter().find(new) {
                    found.push(Exchange {
                        worth: worth(&to.fitted, chance),
                        fitted: to.fitted.clone(),
                        exchanged: [(effect.name, rival.name), (other.name, to.name)],
                    });
                }
            }
        }
    }
    Ok(found)
}

/// Whether something beside a model, other than the effect that it lost, promises a share of what it lost with that: an exchange gains no
/// more than what comes beside all that is there. Linear, so a share is enough.
fn may_recover(
    beside: &Selection<'_>,
    lost: f64,
    effect: &str,
    candidates: &[Candidate],
    chance: &Chance,
) -> Result<bool, WorldError> {
    let Selection {
        prepared, fitted, ..
    } = beside;
    let thresholds = prepared.thresholds;
    let least = thresholds.recovered * (lost - thresholds.excluded);
    if least <= 0.0 {
        return Ok(true);
    }
    let components = &fitted.estimated.components;
    let Some(fitted) = prepared.fit(&fitted.model, components, &fitted.nuisances, 1)? else {
        return Ok(false);
    };
    let screened = screen(prepared, &fitted, candidates)?;
    Ok(screened
        .iter()
        .filter(|s| s.name != effect && simpler(s.name).is_empty())
        .any(|s| s.gain() - chance[s.name] > least))
}
