//! Every candidate at a glance: the score of each of its starts, less what it would gain by chance.

use std::collections::BTreeMap;

use rayon::prelude::*;
use world::WorldError;

use crate::{
    candidates::{Bundle, Candidate},
    fit::{Field, Fitted},
    model::{Part, added, specification},
    score::{Asked, Score},
};

/// What each candidate gains by chance where it is not: the quantile of its replicates, by name.
pub(crate) type Chance = BTreeMap<&'static str, f64>;

/// A candidate beside a fitted model.
#[derive(Clone, Debug)]
pub(crate) struct Screened {
    pub(crate) name: &'static str,
    /// Greatest gain in log-likelihood over its starts.
    pub(crate) gain: f64,
    /// Starts, the best first, each with its gain.
    pub(crate) starts: Vec<(Part, f64)>,
    /// Its parameter of strength, and the least standard error of it over the starts.
    pub(crate) strength: (String, f64),
    /// The greatest gain in each replicate.
    pub(crate) by_chance: Vec<f64>,
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
        .iter()
        .filter(|candidate| !held(candidate.name))
        .map(|candidate| {
            let scored: Vec<Scored> = candidate
                .bundles
                .par_iter()
                .map(|bundle| score(field, fitted, &asked, candidate.name, bundle))
                .collect::<Result<Vec<_>, _>>()?
                .into_iter()
                .flatten()
                .collect();
            let by_chance = (0..replicates)
                .map(|k| {
                    scored
                        .iter()
                        .map(|(_, score, _)| score.by_chance[k])
                        .fold(0.0, f64::max)
                })
                .collect();
            let strength = scored
                .iter()
                .map(|(_, score, strength)| (strength.0.clone(), score.error * strength.1.abs()))
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .unwrap_or_default();
            let mut starts: Vec<(Part, f64)> = scored
                .into_iter()
                .map(|(part, score, _)| (part, score.gain))
                .collect();
            starts.sort_by(|a, b| b.1.total_cmp(&a.1));
            Ok(Screened {
                name: candidate.name,
                gain: starts.first().map_or(0.0, |(_, gain)| *gain),
                starts,
                strength,
                by_chance,
            })
        })
        .collect()
}

/// A start, its score, and the parameter of strength of its first column with its size there.
type Scored = (Part, Score, (String, f64));

fn score(
    field: &Field<'_>,
    fitted: &Fitted,
    asked: &Asked<'_, '_>,
    name: &'static str,
    bundle: &Bundle,
) -> Result<Option<Scored>, WorldError> {
    let model = &fitted.model;
    let mut effects = Vec::new();
    for column in &bundle.columns {
        let mut all = model.effects(field.rig, &model.values)?;
        all.push(world::effects::build(
            &added(&column.part(name)),
            field.rig,
        )?);
        effects.push(all);
    }
    let worlds: Vec<_> = effects
        .iter()
        .map(|effects| (field.planar(&model.values, effects), 1.0))
        .collect();
    let touches = |column: usize, strike: usize| {
        bundle.columns[column]
            .region
            .is_none_or(|(centre, radius)| field.passes(strike, centre, radius))
    };
    let score = asked
        .differences(&worlds, &touches)
        .and_then(|told| told.score());
    Ok(score.map(|score| {
        let first = &bundle.columns[0].strength;
        let neutral = specification(name, &first.0).neutral;
        let strength = (first.0.clone(), first.1 - neutral);
        (bundle.start(name, &score.coefficients), score, strength)
    }))
}
