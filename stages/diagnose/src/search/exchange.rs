//! Two effects exchanged at once: of a pair that is wrong in both, neither is replaced alone.

use rayon::prelude::*;
use world::WorldError;

use super::{
    CandidateFit, Selection,
    fits::{FitCriteria, fit_best},
    penalty::{alike, simpler},
    refine::refine,
};
use crate::{
    candidates::Candidate,
    fit::Fitted,
    screen::{Chance, Screened, screen},
    strikes::PreparedStrikes,
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
    let search = PairSearch {
        prepared,
        chance,
        here: worth(&selection.fitted, chance),
    };
    let mut found = Vec::new();
    for effect in &selection.effects {
        // One that contains others is another question, which the likelihood alone does not answer; beside one that does nearly the same,
        // the others were asked when it was not there.
        let near = |rival: &&CandidateFit| {
            let least = prepared.thresholds.fitted * effect.evidence;
            rival.evidence > least
                && simpler(rival.name).is_empty()
                && !alike(effect.name).contains(&rival.name)
        };
        for rival in effect.rivals.iter().filter(near).take(RIVALS) {
            // Its columns were dropped.
            let Some(fitted) = prepared.fit_from(&rival.fitted, &rival.fitted.model)? else {
                continue;
            };
            let partners = search.partners(&fitted, effect.name, candidates)?;
            if partners.is_empty() {
                continue;
            }
            // The rival stands last.
            let places = fitted.model.parts.len().saturating_sub(1);
            let pairs: Vec<Option<Exchange>> = (0..places)
                .into_par_iter()
                .map(|place| {
                    let other = fitted.model.parts[place].name;
                    let reduced = prepared.fit_from(&fitted, &fitted.model.without(place))?;
                    let Some(reduced) = reduced else {
                        return Ok(None);
                    };
                    let to = search.best_replacement(&reduced, other, &partners)?;
                    Ok(to.map(|to| Exchange {
                        worth: worth(&to.fitted, chance),
                        fitted: to.fitted,
                        exchanged: [(effect.name, rival.name), (other, to.name)],
                    }))
                })
                .collect::<Result<_, WorldError>>()?;
            found.extend(pairs.into_iter().flatten());
        }
    }
    Ok(found)
}

/// What pairs are sought with.
struct PairSearch<'s, 'a> {
    prepared: &'s PreparedStrikes<'a>,
    chance: &'s Chance,
    /// Worth of the model as it stands.
    here: f64,
}

impl PairSearch<'_, '_> {
    /// What an effect must gain by its score to bring a model back to where the selection stands: a share of what the model lost. Scores are
    /// linear, so a share is enough.
    fn required_gain(&self, fitted: &Fitted) -> f64 {
        let thresholds = self.prepared.thresholds;
        let lost = self.here - worth(fitted, self.chance);
        thresholds.recovered * (lost - thresholds.excluded)
    }

    /// The effects that may be the second of a pair whose first stands in the place of the one removed: those that gain enough beside all that is there,
    /// for an exchange gains no more.
    fn partners(
        &self,
        fitted: &Fitted,
        removed: &str,
        candidates: &[Candidate],
    ) -> Result<Vec<Candidate>, WorldError> {
        let others: Vec<Candidate> = candidates
            .iter()
            .filter(|candidate| candidate.name != removed && simpler(candidate.name).is_empty())
            .cloned()
            .collect();
        let screened = screen(self.prepared, fitted, &others)?;
        // What all of them gain is a further step of the model's own.
        let own = screened
            .iter()
            .map(Screened::gain)
            .fold(f64::INFINITY, f64::min);
        let required = self.required_gain(fitted);
        let gains_enough = |name| {
            let mut found = screened.iter().filter(|s| s.name == name);
            found.any(|s| s.gain() - own - self.chance[s.name] > required)
        };
        Ok(others
            .into_iter()
            .filter(|candidate| gains_enough(candidate.name))
            .collect())
    }

    /// The best of these effects in the place of the second one removed, of those that gain enough there.
    fn best_replacement(
        &self,
        reduced: &Fitted,
        removed: &str,
        partners: &[Candidate],
    ) -> Result<Option<CandidateFit>, WorldError> {
        let (prepared, chance) = (self.prepared, self.chance);
        let required = self.required_gain(reduced);
        let mut screened = screen(prepared, reduced, partners)?;
        screened.retain(|s| s.gain() - chance[s.name] > required);
        let criteria = FitCriteria {
            required: alike(removed),
            ..FitCriteria::default()
        };
        let fits = fit_best(prepared, reduced, &screened, chance, criteria)?;
        Ok(fits.into_iter().next())
    }
}
