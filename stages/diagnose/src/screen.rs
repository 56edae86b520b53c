//! Every candidate by the score of each of its starts, and a whole linear step from the best of them.

use std::{collections::BTreeMap, sync::Arc};

use nalgebra::DMatrix;
use rayon::prelude::*;
use world::{
    WorldError,
    effects::{Acts, Effect, FitStart},
    planar::{Node, Planar, StartChange},
};

use crate::{
    candidates::{Candidate, begun, little},
    fit::Fitted,
    mixed::{Estimated, VarianceComponents},
    model::{CLOCK, Model, PRIOR, added, specification},
    score::{Replicates, Score, ScoreTest, StrikeColumns},
    strikes::{Nuisances, PreparedStrikes},
};

/// Gain in log-likelihood that each candidate reaches by chance where it is absent: a quantile of its replicates, by name.
pub(crate) type Chance = BTreeMap<&'static str, f64>;

/// Starts of a candidate, the best by their scores, from which a whole step is taken.
const STEPS: usize = 4;

/// Number of a candidate's best starts that are kept.
const SHORT: usize = 8;

/// Starts that are scored at once, which bounds the memory that their columns take.
const AT_ONCE: usize = 32;

/// Where a fit may begin.
#[derive(Clone, Debug)]
pub(crate) struct Start {
    pub(crate) model: Model,
    pub(crate) components: VarianceComponents,
    pub(crate) nuisances: Vec<Nuisances>,
    /// Gain in log-likelihood, if tracks are linear over the step.
    pub(crate) gain: f64,
}

impl Start {
    /// Gain less the number of free values (Akaike's criterion): a parameter more must bring as much.
    fn penalised_gain(&self) -> f64 {
        self.gain - self.model.free.len() as f64
    }
}

/// A candidate beside a fitted model.
#[derive(Clone, Debug)]
pub(crate) struct Screened {
    pub(crate) name: &'static str,
    /// Greatest gain over its starts: the score at the scatter of the fitted model, which is what chance is known of, or what a
    /// whole step gains where that scatter is of the effect's own making.
    pub(crate) score: f64,
    /// The best starts of its fits.
    pub(crate) shortlist: Vec<FitStart>,
    /// Where fits may begin, the best first.
    pub(crate) starts: Vec<Start>,
    /// Its parameter of strength, and the least standard error of it over the starts.
    pub(crate) strength: (String, f64),
    /// The greatest score in each replicate.
    pub(crate) by_chance: Vec<f64>,
    /// Score of each start.
    scores: Vec<Arc<Score>>,
}

impl Screened {
    /// Gain in log-likelihood of its best start.
    pub(crate) fn gain(&self) -> f64 {
        self.starts.first().map_or(0.0, |start| start.gain)
    }

    /// Takes the greatest score where the signs of strikes (a row each) are flipped, in each column, for what chance brings.
    pub(crate) fn flip(&mut self, signs: &DMatrix<f64>) {
        // By one product, which is blocked, where one of a few rows is not.
        let rows = self.scores.iter().map(|score| score.by_strike.nrows());
        let mut by_strike = DMatrix::zeros(rows.sum(), signs.nrows());
        let mut first = 0;
        for Score { by_strike: own, .. } in self.scores.iter().map(AsRef::as_ref) {
            by_strike.rows_mut(first, own.nrows()).copy_from(own);
            first += own.nrows();
        }
        let flipped = by_strike * signs;
        self.by_chance = vec![0.0; signs.ncols()];
        let mut first = 0;
        for score in &self.scores {
            let count = score.by_strike.nrows();
            let gains = score.gains(flipped.rows(first, count));
            first += count;
            for (most, gain) in self.by_chance.iter_mut().zip(gains) {
                *most = most.max(gain);
            }
        }
    }
}

/// Screens all candidates that the model does not hold, by their scores alone.
pub(crate) fn screen(
    prepared: &PreparedStrikes<'_>,
    fitted: &Fitted,
    candidates: &[Candidate],
) -> Result<Vec<Screened>, WorldError> {
    match ScoreTest::new(prepared, fitted, &[], Replicates::NONE) {
        Some(test) => screen_by(prepared, fitted, &test, candidates),
        None => Ok(Vec::new()),
    }
}

/// Screens all candidates that the model does not hold, by a score test that is already built, with its replicates.
pub(crate) fn screen_by(
    prepared: &PreparedStrikes<'_>,
    fitted: &Fitted,
    test: &ScoreTest<'_, '_>,
    candidates: &[Candidate],
) -> Result<Vec<Screened>, WorldError> {
    let replicates = test.replicates.drawn + test.replicates.flipped;
    let held = |name: &str| fitted.model.parts.iter().any(|part| part.name == name);
    candidates
        .par_iter()
        .filter(|candidate| !held(candidate.name))
        .map(|candidate| {
            let mut beside = Vec::new();
            for starts in candidate.starts.chunks(AT_ONCE) {
                beside.extend(scored(prepared, fitted, test, candidate.name, starts)?);
            }
            beside.sort_by(|a, b| b.penalised_gain().total_cmp(&a.penalised_gain()));
            let scores = || beside.iter().map(|beside| &beside.score);
            let mut starts: Vec<Start> = best_of_each_form(&beside)
                .into_par_iter()
                .map(|beside| beside.start(test))
                .collect();
            starts.sort_by(|a, b| b.penalised_gain().total_cmp(&a.penalised_gain()));
            let whole_steps = starts.iter().filter(|_| !test.is_beside);
            Ok(Screened {
                name: candidate.name,
                score: scores()
                    .map(|score| score.gain)
                    // A whole step knows nothing of random columns.
                    .chain(whole_steps.map(|start| start.gain))
                    .fold(0.0, f64::max),
                strength: beside
                    .iter()
                    .map(ScoredStart::strength)
                    .min_by(|a, b| a.1.total_cmp(&b.1))
                    .unwrap_or_default(),
                by_chance: (0..replicates)
                    .map(|k| scores().map(|score| score.by_chance[k]).fold(0.0, f64::max))
                    .collect(),
                shortlist: beside
                    .iter()
                    .take(SHORT)
                    .map(|beside| beside.begin.clone())
                    .collect(),
                starts,
                scores: beside.into_iter().map(|beside| beside.score).collect(),
            })
        })
        .collect()
}

/// The starts from which a whole step is taken: the best of each form, and then the next best. A form of more values often has the greatest
/// score, and its step the farthest to go.
fn best_of_each_form<'s, 'b>(ranked: &'s [ScoredStart<'b>]) -> Vec<&'s ScoredStart<'b>> {
    let (mut best, mut others): (Vec<&ScoredStart<'_>>, Vec<_>) = (Vec::new(), Vec::new());
    for start in ranked {
        let is_new = best.iter().all(|best| best.begin.free != start.begin.free);
        if is_new { &mut best } else { &mut others }.push(start);
    }
    best.into_iter().chain(others).take(STEPS).collect()
}

/// Scores a fitted model with a little of an effect added, for each of these starts at which strikes can be simulated and the effect is distinct from
/// the model's own values.
fn scored<'b>(
    prepared: &PreparedStrikes<'_>,
    fitted: &'b Fitted,
    test: &ScoreTest<'_, '_>,
    name: &'static str,
    starts: &'b [FitStart],
) -> Result<Vec<ScoredStart<'b>>, WorldError> {
    let moved: Vec<Option<StrikeColumns>> = starts
        .par_iter()
        .map(|start| moved(prepared, fitted, test, name, start))
        .collect::<Result<_, WorldError>>()?;
    let (starts, moved): (Vec<&FitStart>, Vec<StrikeColumns>) = starts
        .iter()
        .zip(moved)
        .filter_map(|(start, moved)| Some((start, moved?)))
        .unzip();
    let sets: Vec<(usize, &StrikeColumns)> = starts
        .iter()
        .zip(&moved)
        .map(|(start, moved)| (start.columns.len(), moved))
        .collect();
    let scores = test.scores_of_each(&sets);
    let scored =
        starts
            .into_iter()
            .zip(moved)
            .zip(scores)
            .filter_map(|((begin, moved), scores)| {
                let score = scores.score(&begin.is_kept())?;
                Some(ScoredStart {
                    fitted,
                    name,
                    begin,
                    moved,
                    score: score.into(),
                })
            });
    Ok(scored.collect())
}

/// What a little of an effect from this start changes of each strike; `None` where one does not come to rest. What acts as another command would is
/// taken as a change of launches, which is right however large it is: a track is not linear in a launch that is half as fast, but a strike's own
/// logarithm of speed is.
fn moved(
    prepared: &PreparedStrikes<'_>,
    fitted: &Fitted,
    test: &ScoreTest<'_, '_>,
    name: &'static str,
    begin: &FitStart,
) -> Result<Option<StrikeColumns>, WorldError> {
    let columns = &begin.columns;
    let each = columns
        .iter()
        .map(|column| world::effects::build(&added(&little(name, column)), prepared.rig));
    let each = each.collect::<Result<Vec<_>, WorldError>>()?;
    let touches = |column: usize, strike| {
        let region = columns[column].region;
        region.is_none_or(|(centre, radius)| prepared.passes(strike, centre, radius))
    };
    if each
        .iter()
        .all(|effect| matches!(effect.acts(), Acts::Slide | Acts::Strike))
    {
        return Ok(
            test.moved(columns.len(), &touches, &|response, _, k, change| {
                let added = |node: &Node| response.effect(node, each[k].as_ref());
                response.answer(StartChange::default(), &added, change);
            }),
        );
    }
    let model = &fitted.model;
    let beside = each.into_iter().map(|effect| {
        let mut all = model.effects(prepared.rig, &model.values)?;
        all.push(effect);
        Ok(all)
    });
    let beside = beside.collect::<Result<Vec<_>, WorldError>>()?;
    let worlds: Vec<Planar<'_>> = beside
        .iter()
        .map(|effects| prepared.planar(&model.values, effects))
        .collect();
    let is_command = |all: &Vec<Box<dyn Effect>>| {
        let effect = all.last();
        effect.is_some_and(|effect| effect.acts() == Acts::Launch && effect.tip_offset() == 0.0)
    };
    if beside.iter().all(is_command) {
        let here = model.effects(prepared.rig, &model.values)?;
        let here = prepared.planar(&model.values, &here);
        return Ok(Some(
            test.launches(&|i| prepared.relaunched(&here, &worlds, i)),
        ));
    }
    let clock = model.values[CLOCK];
    Ok(
        test.moved(columns.len(), &touches, &|response, i, k, change| {
            prepared.answer_of(response, &worlds[k], i, clock, &fitted.nuisances[i], change);
        }),
    )
}

/// A fitted model with a little of an effect added, and its score.
struct ScoredStart<'b> {
    fitted: &'b Fitted,
    name: &'static str,
    begin: &'b FitStart,
    /// Change of each strike's track by the little effect, and its score.
    moved: StrikeColumns,
    score: Arc<Score>,
}

impl<'b> ScoredStart<'b> {
    /// Gain less the number of free values (Akaike's criterion): a parameter more must bring as much.
    fn penalised_gain(&self) -> f64 {
        self.score.gain - self.begin.free.len() as f64
    }

    /// Its first parameter of strength, and the standard error of that.
    fn strength(&self) -> (String, f64) {
        let (strength, value) = &self.begin.columns[0].strength;
        let size = value - specification(self.name, strength).neutral;
        (strength.clone(), self.score.error * size.abs())
    }

    /// The start after a whole linear step from here, or by the score alone where the step has no solution.
    fn start(&self, test: &ScoreTest<'_, '_>) -> Start {
        let columns = &self.begin.columns;
        let is_kept = self.begin.is_kept();
        let precision: Vec<f64> = columns
            .iter()
            .map(|column| {
                let (name, value) = &column.strength;
                let spec = specification(self.name, name);
                let width = self.begin.shrinks_to.unwrap_or(PRIOR * spec.scale);
                ((value - spec.neutral) / width).powi(2)
            })
            .collect();
        match test.step(&self.moved, &is_kept, &precision) {
            Some(stepped) => self.stepped(&stepped, &is_kept, test.promised_alone()),
            None => Start {
                model: self.model(&self.score.coefficients),
                components: self.fitted.estimated.components,
                nuisances: self.fitted.nuisances.clone(),
                gain: self.score.gain,
            },
        }
    }

    fn model(&self, coefficients: &[f64]) -> Model {
        let part = begun(self.name, self.begin, coefficients);
        self.fitted.model.with(part)
    }

    fn stepped(&self, stepped: &Estimated, is_kept: &[bool], alone: f64) -> Start {
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
        let gain = stepped.likelihood_there - alone;
        Start {
            gain: gain + model.log_prior() - self.fitted.model.log_prior(),
            model,
            components: stepped.components,
            nuisances: stepped.nuisances.clone(),
        }
    }
}
