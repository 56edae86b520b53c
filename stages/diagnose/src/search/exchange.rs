//! Two effects exchanged at once: of a pair that is wrong in both, neither is replaced alone.

use world::WorldError;

use super::{
    CandidateFit, Selection,
    penalty::{alike, simpler},
    refine::{assess, refine},
};
use crate::{
    candidates::Candidate,
    fit::{Fitted, ITERATIONS},
    screen::{Chance, Screened, screen},
};

/// Rivals of each effect beside which the others are asked again.
const RIVALS: usize = 2;

/// The same with two effects exchanged for two others where those are better together, and whether they are; where they are as good, they
/// are named as equivalents.
pub(super) fn exchanged<'a>(
    mut selection: Selection<'a>,
    candidates: &[Candidate],
    chance: &Chance,
) -> Result<(Selection<'a>, bool), WorldError> {
    let thresholds = selection.prepared.thresholds;
    let held = selection.fitted.model.parts.len();
    if held < 2 {
        return Ok((selection, false));
    }
    let pairs = exchanges(&selection, candidates, chance)?;
    let here = worth(&selection.fitted, chance);
    let best = pairs
        .iter()
        .max_by(|a, b| a.worth.total_cmp(&b.worth))
        .filter(|best| best.worth > here + thresholds.better);
    if let Some(best) = best {
        selection.fitted = best.fitted.clone();
        return Ok((refine(selection, candidates, chance, held)?, true));
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
    Ok((selection, false))
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
    let prepared = &selection.prepared;
    let here = worth(&selection.fitted, chance);
    let mut found = Vec::new();
    for effect in &selection.effects {
        // One that contains others is another question, which the likelihood alone does not answer; beside one that does nearly the same,
        // the others were asked when it was not there.
        let near = |rival: &&CandidateFit| {
            let least = prepared.thresholds.fitted_to_end * effect.evidence;
            rival.evidence > least
                && simpler(rival.name).is_empty()
                && !alike(effect.name).contains(&rival.name)
        };
        for rival in effect.rivals.iter().filter(near).take(RIVALS) {
            // It was perhaps left after its first iterations, and its columns were dropped.
            let Fitted {
                model,
                estimated,
                nuisances,
                ..
            } = &rival.fitted;
            let fitted = prepared.fit(model, &estimated.components, nuisances, ITERATIONS)?;
            let Some(fitted) = fitted else { continue };
            let lost = here - worth(&fitted, chance);
            let beside = Selection {
                prepared: prepared.clone(),
                null: selection.null.clone(),
                fitted,
                effects: Vec::new(),
            };
            let promising = promising(&beside, lost, effect.name, candidates, chance)?;
            if promising.is_empty() {
                continue;
            }
            // The rival stands last.
            for place in 0..beside.fitted.model.parts.len().saturating_sub(1) {
                let (other, _) = assess(&beside, place, &promising, chance)?;
                if let Some(to) = other.rivals.first() {
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

/// The effects, other than the one that a model lost, that promise beside it a share of what it lost with that: an exchange gains no more
/// than what is added to all that is there. By scores, which are linear, so a share is enough.
fn promising(
    beside: &Selection<'_>,
    lost: f64,
    effect: &str,
    candidates: &[Candidate],
    chance: &Chance,
) -> Result<Vec<Candidate>, WorldError> {
    let Selection {
        prepared, fitted, ..
    } = beside;
    let thresholds = prepared.thresholds;
    let least = thresholds.recovered * (lost - thresholds.excluded);
    let others: Vec<Candidate> = candidates
        .iter()
        .filter(|candidate| candidate.name != effect && simpler(candidate.name).is_empty())
        .cloned()
        .collect();
    let screened = screen(prepared, fitted, &others)?;
    // What all of them gain is a further step of the model's own.
    let own = screened
        .iter()
        .map(Screened::gain)
        .fold(f64::INFINITY, f64::min);
    let promises = |name| {
        let mut found = screened.iter().filter(|s| s.name == name);
        found.any(|s| s.gain() - own - chance[s.name] > least)
    };
    Ok(others
        .into_iter()
        .filter(|candidate| promises(candidate.name))
        .collect())
}
