//! Every candidate at a glance: the score of each of its starts, and a whole linear step from the best of them.

use std::collections::BTreeMap;

use nalgebra::SVector;
use rayon::prelude::*;
use world::{WorldError, effects::Effect, planar::Planar};

use crate::{
    candidates::{Bundle, Candidate},
    fit::{Field, Fitted},
    mixed::{Estimated, NUISANCES, Spread},
    model::{Model, PRIOR, Part, added, specification},
    score::{Asked, Score},
};

/// What each candidate gains by chance where it is not: the quantile of its replicates, by name.
pub(crate) type Chance = BTreeMap<&'static str, f64>;

/// Starts of a candidate, the best by their scores, from which a whole step is taken.
const STEPS: usize = 4;

/// Bundles that are remembered.
const SHORT: usize = 16;

/// Where a fit may begin.
#[derive(Clone, Debug)]
pub(crate) struct Start {
    pub(crate) model: Model,
    pub(crate) spread: Spread,
    pub(crate) kicks: Vec<SVector<f64, NUISANCES>>,
    /// Gain in log-likelihood, were all linear.
    pub(crate) gain: f64,
}

impl Start {
    fn worth(&self) -> f64 {
        self.gain - self.model.free.len() as f64
    }
}

/// A candidate beside a fitted model.
#[derive(Clone, Debug)]
pub(crate) struct Screened {
    pub(crate) name: &'static str,
    /// Greatest score over its starts, at the scatter of the fitted model: what chance is known of.
    pub(crate) score: f64,
    /// Its best bundles.
    pub(crate) bundles: Vec<Bundle>,
    /// Where fits may begin, the best first.
    pub(crate) starts: Vec<Start>,
    /// Its parameter of strength, and the least standard error of it over the starts.
    pub(crate) strength: (String, f64),
    /// The greatest score in each replicate.
    pub(crate) by_chance: Vec<f64>,
}

impl Screened {
    /// Gain in log-likelihood of its best start.
    pub(crate) fn gain(&self) -> f64 {
        self.starts.first().map_or(0.0, |start| start.gain)
    }
}

/// Screens all candidates that the model does not hold.
pub(crate) fn screen(
    field: &Field<'_>,
    fitted: &Fitted,
    candidates: &[Candidate],
    replicates: usize,
    seed: u64,
) -> Result<Vec<Screened>, WorldError> {
    let Some(asked) = Asked::new(field, fitted, replicates, seed)? else {
        return Ok(Vec::new());
    };
    let held = |name: &str| fitted.model.parts.iter().any(|part| part.name == name);
    candidates
        .par_iter()
        .filter(|candidate| !held(candidate.name))
        .map(|candidate| {
            let name = candidate.name;
            let mut scored: Vec<(&Bundle, Score)> = candidate
                .bundles
                .par_iter()
                .map(|bundle| Ok(Beside::new(field, fitted, name, bundle)?.score(&asked)))
                .collect::<Result<Vec<_>, WorldError>>()?
                .into_iter()
                .zip(&candidate.bundles)
                .filter_map(|(score, bundle)| Some((bundle, score?)))
                .collect();
            // As Akaike would have it: a parameter more must be worth it.
            let worth = |(bundle, score): &(&Bundle, Score)| score.gain - bundle.free.len() as f64;
            scored.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
            let by_chance = (0..replicates)
                .map(|k| {
                    let gains = scored.iter().map(|(_, score)| score.by_chance[k]);
                    gains.fold(0.0, f64::max)
                })
                .collect();
            let strength = scored
                .iter()
                .map(|(bundle, score)| {
                    let (strength, value) = &bundle.columns[0].strength;
                    let size = value - specification(name, strength).neutral;
                    (strength.clone(), score.error * size.abs())
                })
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .unwrap_or_default();
            let mut starts: Vec<Start> = scored
                .par_iter()
                .take(STEPS)
                .map(|(bundle, score)| {
                    Ok(Beside::new(field, fitted, name, bundle)?.start(&asked, score))
                })
                .collect::<Result<_, WorldError>>()?;
            starts.sort_by(|a, b| b.worth().total_cmp(&a.worth()));
            Ok(Screened {
                name,
                score: scored
                    .iter()
                    .map(|(_, score)| score.gain)
                    .fold(0.0, f64::max),
                bundles: scored
                    .iter()
                    .take(SHORT)
                    .map(|(b, _)| (*b).clone())
                    .collect(),
                starts,
                strength,
                by_chance,
            })
        })
        .collect()
}

/// A fitted model, and worlds with a little of an effect beside it.
struct Beside<'b, 'a> {
    field: &'b Field<'a>,
    fitted: &'b Fitted,
    name: &'static str,
    bundle: &'b Bundle,
    effects: Vec<Vec<Box<dyn Effect>>>,
}

impl<'b, 'a> Beside<'b, 'a> {
    fn new(
        field: &'b Field<'a>,
        fitted: &'b Fitted,
        name: &'static str,
        bundle: &'b Bundle,
    ) -> Result<Self, WorldError> {
        let model = &fitted.model;
        let effects = bundle
            .columns
            .iter()
            .map(|column| {
                let mut all = model.effects(field.rig, &model.values)?;
                let part = added(&column.part(name));
                all.push(world::effects::build(&part, field.rig)?);
                Ok(all)
            })
            .collect::<Result<_, WorldError>>()?;
        Ok(Self {
            field,
            fitted,
            name,
            bundle,
            effects,
        })
    }

    fn worlds(&self) -> Vec<(Planar<'_>, f64)> {
        self.effects
            .iter()
            .map(|effects| (self.field.planar(&self.fitted.model.values, effects), 1.0))
            .collect()
    }

    fn touches(&self, column: usize, strike: usize) -> bool {
        self.bundle.columns[column]
            .region
            .is_none_or(|(centre, radius)| self.field.passes(strike, centre, radius))
    }

    fn score(&self, asked: &Asked<'_, '_>) -> Option<Score> {
        asked
            .differences(&self.worlds(), &|column, strike| {
                self.touches(column, strike)
            })?
            .score(&self.is_kept())
    }

    fn is_kept(&self) -> Vec<bool> {
        let columns = &self.bundle.columns;
        columns.iter().map(|column| column.is_kept).collect()
    }

    /// A whole step from here, or what the score says where that has no answer.
    fn start(&self, asked: &Asked<'_, '_>, score: &Score) -> Start {
        let columns = &self.bundle.columns;
        let is_kept = self.is_kept();
        let precision: Vec<f64> = columns
            .iter()
            .map(|column| {
                let (name, value) = &column.strength;
                let spec = specification(self.name, name);
                ((value - spec.neutral) / (PRIOR * spec.scale)).powi(2)
            })
            .collect();
        let touches = |column, strike| self.touches(column, strike);
        match asked.step(&self.worlds(), &touches, &is_kept, &precision) {
            Some(stepped) => self.stepped(&stepped, &is_kept),
            None => Start {
                model: self.model(&score.coefficients),
                spread: self.fitted.estimated.spread,
                kicks: self.fitted.kicks.clone(),
                gain: score.gain,
            },
        }
    }

    fn model(&self, coefficients: &[f64]) -> Model {
        let part: Part = self.bundle.start(self.name, coefficients);
        self.fitted.model.with(part)
    }

    fn stepped(&self, stepped: &Estimated, is_kept: &[bool]) -> Start {
        let own = self.fitted.model.free.len();
        let mut found = stepped.beta.iter().skip(own);
        let coefficients: Vec<f64> = is_kept
            .iter()
            .map(|kept| match kept {
                true => 1.0,
                false => found.next().copied().unwrap_or_default(),
            })
            .collect();
        let mut model = self.model(&coefficients);
        for (place, free) in self.fitted.model.free.iter().enumerate() {
            let moved = model.values[place] + stepped.beta[place];
            model.values[place] = moved.clamp(free.low, free.high);
        }
        Start {
            model,
            spread: stepped.spread,
            kicks: stepped.nuisances.clone(),
            gain: stepped.likelihood_there - self.fitted.estimated.likelihood_there,
        }
    }
}
