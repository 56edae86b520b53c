//! Which effects: forward by evidence, replaced and dropped again where that is better.

use std::collections::BTreeMap;

use rayon::prelude::*;
use world::WorldError;

use crate::{
    candidates::Candidate,
    fit::{Field, Fitted, GLANCE, ITERATIONS},
    screen::{Chance, Screened, Start, screen},
};

/// Candidates that are fitted at each step, the best by their scores, and starts of each.
const FITTED: usize = 5;
const STARTS: usize = 2;
/// Gain of the score below this share of the best one's is not worth a fit.
const HOPELESS: f64 = 0.25;
/// Evidence that each effect more must bring beyond chance: one missing effect is likelier than two.
const ANOTHER: f64 = 2.0;
/// Share of what the effects so far explain that another must bring: a real effect never has quite the library's form, and what
/// is left of a strong one looks like a weak one.
const FORM: f64 = 0.02;
/// Share of the best one's evidence below which a candidate is not fitted to the end.
const BEHIND: f64 = 0.6;
/// A candidate whose evidence is less than this short of the best one's is not excluded: odds of a hundred to one.
pub(crate) const EXCLUDED: f64 = 4.6;
/// Evidence by which another effect in an effect's place is better.
const BETTER: f64 = 0.5;
/// Share of the evidence below which an effect that is nearly the same by construction is excluded.
const ALIKE: f64 = 0.6;

/// A model beside what it gains.
#[derive(Clone, Debug)]
pub(crate) struct Step {
    pub(crate) fitted: Fitted,
    pub(crate) name: &'static str,
    /// Gain in log-likelihood less what the candidate would gain by chance.
    pub(crate) evidence: f64,
}

impl Step {
    fn worth(&self) -> f64 {
        self.evidence - self.fitted.model.free.len() as f64
    }
}

/// Fits beside one model, by candidate and start: what was fitted once is not fitted again.
pub(crate) type Tried = BTreeMap<(&'static str, usize), Option<Step>>;

/// The candidates worth a fit, and those that are `asked` for in any case, each fitted beside a model; the best first.
pub(crate) fn fit_best(
    field: &Field<'_>,
    from: &Fitted,
    screened: &[Screened],
    chance: &Chance,
    asked: &[&str],
    tried: &mut Tried,
) -> Result<Vec<Step>, WorldError> {
    let mut order: Vec<&Screened> = screened.iter().collect();
    order.sort_by(|a, b| (b.gain() - chance[b.name]).total_cmp(&(a.gain() - chance[a.name])));
    let Some(best) = order.first() else {
        return Ok(Vec::new());
    };
    let least = HOPELESS * best.gain();
    let worth: Vec<((&'static str, usize), &Start)> = order
        .iter()
        .enumerate()
        .filter(|(rank, s)| (*rank < FITTED && s.gain() >= least) || asked.contains(&s.name))
        .flat_map(|(_, s)| {
            s.starts
                .iter()
                .take(STARTS)
                .enumerate()
                .map(|(i, start)| ((s.name, i), start))
        })
        .collect();
    let step = |name: &'static str, fitted: Fitted| Step {
        evidence: fitted.likelihood() - from.likelihood() - chance[name],
        name,
        fitted,
    };
    let glanced: Vec<_> = worth
        .par_iter()
        .filter(|(key, _)| !tried.contains_key(key))
        .map(|(key, start)| {
            let Start {
                model,
                spread,
                kicks,
                ..
            } = start;
            let fitted = field.fit(model, spread, kicks, GLANCE)?;
            let is_better = |f: &Fitted| f.likelihood() > from.likelihood();
            if fitted.as_ref().is_some_and(is_better) {
                return Ok((*key, fitted.map(|fitted| step(key.0, fitted))));
            }
            // A whole step was too long: from where the model stands.
            let own = from.model.values.len();
            let mut model = model.clone();
            model.values[..own].copy_from_slice(&from.model.values);
            let fitted = field.fit(&model, &from.estimated.spread, &from.kicks, GLANCE)?;
            Ok((*key, fitted.map(|fitted| step(key.0, fitted))))
        })
        .collect::<Result<_, WorldError>>()?;
    tried.extend(glanced);
    let glanced = || {
        worth
            .iter()
            .filter_map(|(key, _)| Some((*key, tried[key].as_ref()?)))
    };
    let best = glanced()
        .map(|(_, step)| step.evidence)
        .fold(f64::NEG_INFINITY, f64::max);
    let fits: Vec<_> = glanced()
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|(key, glanced)| {
            // Far behind after a glance, it is left there: a rival all the same, if a poor one.
            if glanced.evidence < BEHIND * best && !asked.contains(&glanced.name) {
                return Ok((key, glanced.clone()));
            }
            let fitted = field.further(glanced.fitted.clone(), ITERATIONS - GLANCE)?;
            Ok((key, step(glanced.name, fitted)))
        })
        .collect::<Result<_, WorldError>>()?;
    let mut steps: Vec<Step> = Vec::new();
    let possible = |step: &Step| step.fitted.model.is_possible();
    tried.extend(fits.iter().map(|(key, step)| (*key, Some(step.clone()))));
    for step in fits.into_iter().map(|(_, step)| step).filter(possible) {
        match steps.iter_mut().find(|other| other.name == step.name) {
            Some(other) if other.worth() >= step.worth() => {}
            Some(other) => *other = step,
            None => steps.push(step),
        }
    }
    steps.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    Ok(steps)
}

/// What a search ends with.
pub(crate) struct Searched {
    pub(crate) fitted: Fitted,
    /// For each of the model's effects, its evidence beside the others, and who could stand in its place.
    pub(crate) standing: Vec<Standing>,
}

impl Searched {
    /// The effect that stands least firmly, if others stand beside it and its evidence is less than `left`.
    pub(crate) fn weaker_than(&self, left: f64) -> Option<usize> {
        let (place, weakest) = self
            .standing
            .iter()
            .enumerate()
            .min_by(|a, b| a.1.evidence.total_cmp(&b.1.evidence))?;
        (self.standing.len() > 1 && weakest.evidence < left).then_some(place)
    }
}

/// The same without one of its effects.
pub(crate) fn without(
    field: &Field<'_>,
    searched: &Searched,
    place: usize,
    candidates: &[Candidate],
    chance: &Chance,
) -> Result<Searched, WorldError> {
    let from = &searched.fitted;
    let model = from.model.without(place);
    let fitted = field
        .fit(&model, &from.estimated.spread, &from.kicks, ITERATIONS)?
        .unwrap_or_else(|| from.clone());
    settle(field, fitted, None, candidates, chance, 0)
}

/// How firmly an effect stands.
#[derive(Clone, Debug)]
pub(crate) struct Standing {
    pub(crate) name: &'static str,
    pub(crate) evidence: f64,
    pub(crate) equivalent: Vec<&'static str>,
    /// Models with another effect in its place, the best first.
    pub(crate) rivals: Vec<Step>,
}

/// What is known of the effect that was added last.
struct Newest {
    standing: Standing,
    /// The model without it.
    reduced: Fitted,
}

impl Standing {
    fn new(name: &'static str, evidence: f64, rivals: Vec<Step>) -> Self {
        Self {
            name,
            evidence,
            equivalent: rivals
                .iter()
                .filter(|step| !is_excluded(name, evidence, step))
                .map(|step| step.name)
                .collect(),
            rivals,
        }
    }
}

/// Adds effects while each brings more than chance, and asks of each whether another could stand in its place.
pub(crate) fn search(
    field: &Field<'_>,
    null: &Fitted,
    first: &[Screened],
    candidates: &[Candidate],
    chance: &Chance,
    most: usize,
) -> Result<Searched, WorldError> {
    let mut searched = Searched {
        fitted: null.clone(),
        standing: Vec::new(),
    };
    let mut screened = first.to_vec();
    let mut short = shortlist(candidates, &screened);
    for _ in 0..2 * most {
        let fitted = &searched.fitted;
        let held = fitted.model.parts.len();
        let gained = fitted.likelihood() - null.likelihood();
        let asked = (ANOTHER * held as f64).max(FORM * gained);
        // An effect that does nearly what another does stands beside it only where the form of neither is enough.
        let beside = |name: &str| {
            let alike = alike(name);
            let standing = searched.standing.iter();
            standing
                .filter(|s| alike.contains(&s.name))
                .map(|s| (1.0 - ALIKE) * s.evidence)
                .fold(asked, f64::max)
        };
        let mut tried = Tried::new();
        let mut beside_it = |name: Option<&str>| {
            let others: Vec<Screened> = screened
                .iter()
                .filter(|s| Some(s.name) != name)
                .cloned()
                .collect();
            let asked = name.map_or(&[] as &[&str], alike);
            fit_best(field, fitted, &others, chance, asked, &mut tried)
        };
        let adds = |step: &Step| held < most && step.evidence > beside(step.name);
        let Some(mut step) = beside_it(None)?.into_iter().find(adds) else {
            break;
        };
        let mut rivals = beside_it(Some(step.name))?;
        // A rival that was left after a glance may be the better one.
        let is_better = |rival: &Step| rival.evidence > step.evidence + BETTER && adds(rival);
        if let Some(better) = rivals.iter().position(is_better) {
            step = rivals.swap_remove(better);
            rivals = beside_it(Some(step.name))?;
        }
        let newest = Newest {
            standing: Standing::new(step.name, step.evidence, rivals),
            reduced: fitted.clone(),
        };
        searched = settle(field, step.fitted, Some(newest), &short, chance, held)?;
        screened = screen(field, &searched.fitted, candidates, 0, 0)?;
        short = shortlist(&short, &screened);
    }
    Ok(searched)
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

/// Replaces or drops an effect where that is better, at most so many times, then says how firmly each stands.
fn settle(
    field: &Field<'_>,
    mut fitted: Fitted,
    mut newest: Option<Newest>,
    candidates: &[Candidate],
    chance: &Chance,
    mut changes: usize,
) -> Result<Searched, WorldError> {
    loop {
        let mut better = None;
        let mut all = Vec::new();
        for place in 0..fitted.model.parts.len() {
            let is_last = place + 1 == fitted.model.parts.len();
            let (standing, reduced) = match newest.take_if(|_| is_last) {
                Some(newest) => (newest.standing, Some(newest.reduced)),
                None => standing(field, &fitted, place, candidates, chance)?,
            };
            if changes > 0 {
                let rival = standing.rivals.first();
                better = if standing.evidence < 0.0 {
                    reduced
                } else {
                    rival
                        .filter(|rival| rival.evidence > standing.evidence + BETTER)
                        .map(|rival| rival.fitted.clone())
                };
                if better.is_some() {
                    break;
                }
            }
            all.push(standing);
        }
        match better {
            Some(model) => (fitted, newest, changes) = (model, None, changes - 1),
            None => {
                return Ok(Searched {
                    fitted,
                    standing: all,
                });
            }
        }
    }
}

/// How firmly one effect stands beside the others, and the model without it.
fn standing(
    field: &Field<'_>,
    fitted: &Fitted,
    place: usize,
    candidates: &[Candidate],
    chance: &Chance,
) -> Result<(Standing, Option<Fitted>), WorldError> {
    let name = fitted.model.parts[place].name;
    let model = fitted.model.without(place);
    let spread = &fitted.estimated.spread;
    let Some(reduced) = field.fit(&model, spread, &fitted.kicks, ITERATIONS)? else {
        let firm = Standing::new(name, f64::INFINITY, Vec::new());
        return Ok((firm, None));
    };
    let evidence = fitted.likelihood() - reduced.likelihood() - chance[name];
    let screened: Vec<Screened> = screen(field, &reduced, candidates, 0, 0)?
        .into_iter()
        .filter(|s| s.name != name)
        .collect();
    let tried = &mut Tried::new();
    let steps = fit_best(field, &reduced, &screened, chance, alike(name), tried)?;
    let standing = Standing::new(name, evidence, steps);
    Ok((standing, Some(reduced)))
}

/// Whether the data exclude another effect in the place of a named one. Of effects that differ in form alone, and whose form is
/// a choice of the library's, more is asked than odds.
fn is_excluded(name: &str, evidence: f64, rival: &Step) -> bool {
    let share = if alike(name).contains(&rival.name) {
        ALIKE
    } else {
        1.0
    };
    rival.evidence < share * (evidence - EXCLUDED)
}

/// Effects that do the same by construction, or nearly so.
fn alike(name: &str) -> &'static [&'static str] {
    world::effects::effect(name).map_or(&[], |spec| spec.equivalent)
}
