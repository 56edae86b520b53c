//! Score tests: how much a small change would explain of what a fitted model leaves.
//!
//! At a fitted model a column c (the derivative of every track by some strength) gains S/2 of log-likelihood, S = u²/V, with
//! u = cᵀΣ⁻¹r and V what is left of cᵀΣ⁻¹c beside the model's own columns. What chance gains is known from the same columns in
//! two ways: residuals drawn from the fitted model and its noise (parametric bootstrap), and the measured residuals with the
//! signs of whole strikes flipped, which takes no model of noise on trust.

mod columns;
mod products;
mod replicates;
mod strike;

pub(crate) use columns::{ColumnScores, RandomColumns, Score, StrikeColumns};
pub(crate) use replicates::{DRAWN, FLIPPED, Replicates, signs};

use std::sync::OnceLock;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use world::planar::Response;

use self::{
    products::StrikeProducts,
    replicates::{common_heights, studentised},
    strike::StrikeAtFit,
};
use crate::{
    fit::{Fitted, HELD, hold_at_bounds, prior},
    mixed::{self, Estimated, Prior, Products},
    model::CLOCK,
    strikes::PreparedStrikes,
};

/// Steps of expectation and maximisation of a linear step.
const EM_STEPS: usize = 8;
/// Longest way in m over which changes along a slide are taken as smooth: bases are wider.
const LONGEST: f64 = 0.025;
/// Relative wander of friction below which it shows in no track.
const STILL: f64 = 1e-3;

/// Writes the change of a strike's frames by a column: the strike's response, its place, the column's, and the change.
type Answer<'f> = dyn Fn(&Response<'_>, usize, usize, &mut [f64]) + Sync + 'f;

/// The wander's columns, where there is one.
fn wander(prepared: &PreparedStrikes<'_>, fitted: &Fitted) -> Option<RandomColumns> {
    let wander = fitted.estimated.components.wander;
    if wander < STILL {
        return None;
    }
    let strikes = fitted.linearisation.whitened.iter().zip(&prepared.paths);
    let moved = strikes
        .map(|(whitened, path)| {
            let friction = whitened.nuisances.column(mixed::FRICTION);
            let columns =
                DMatrix::from_fn(friction.len(), path.len(), |row, k| friction[row] * path[k]);
            Some(columns)
        })
        .collect();
    Some(RandomColumns {
        moved,
        variance: wander * wander,
    })
}

/// Place of the share of wrong sizes, where it lies at an end of its range.
fn held_at_end(fitted: &Fitted) -> Option<usize> {
    let model = &fitted.model;
    model.sizes().filter(|place| model.is_at_end(*place, 0.0))
}

/// A fitted model, ready to be tested against columns that it lacks.
pub(crate) struct ScoreTest<'f, 'a> {
    prepared: &'f PreparedStrikes<'a>,
    fitted: &'f Fitted,
    strikes: Vec<StrikeAtFit<'f>>,
    responses: OnceLock<Option<Vec<Response<'a>>>>,
    promised: OnceLock<f64>,
    /// XᵀΣ⁻¹·(r − X·β), a column for each strike.
    own_left: DMatrix<f64>,
    /// (XᵀΣ⁻¹X + prior precision)⁻¹.
    inverse: DMatrix<f64>,
    /// XᵀΣ⁻¹·[r, drawn residuals].
    scores: DMatrix<f64>,
    /// A row for each strike, a column for each flip: 1 or −1.
    signs: DMatrix<f64>,
    /// Factor on each drawn residual's scores for the scatter being estimated, not known: Student's t.
    studentised: Vec<f64>,
    /// Whether random columns other than the wander stand beside the model.
    pub(crate) is_beside: bool,
    pub(crate) replicates: Replicates,
}

impl<'f, 'a> ScoreTest<'f, 'a> {
    /// Prepares a fitted model with random columns beside it; `None` where its values cannot be distinguished.
    pub(crate) fn new(
        prepared: &'f PreparedStrikes<'a>,
        fitted: &'f Fitted,
        random: &[RandomColumns],
        replicates: Replicates,
    ) -> Option<Self> {
        let p = fitted.model.free.len();
        let is_beside = !random.is_empty();
        let wander = wander(prepared, fitted);
        let random: Vec<&RandomColumns> = wander.iter().chain(random).collect();
        let random = random.as_slice();
        let all = p + random.iter().map(|columns| columns.count()).sum::<usize>();
        let common = common_heights(random, replicates);
        let mut strikes: Vec<StrikeAtFit<'f>> = (0..prepared.strikes.len())
            .into_par_iter()
            .map(|i| StrikeAtFit::new(prepared, fitted, i, random, &common, replicates))
            .collect();
        let mut information = DMatrix::zeros(all + 1 + replicates.drawn, all);
        for at in &strikes {
            information += at.weighed() * &at.own;
        }
        // What the strikes say nothing of, such as a cap above all speeds, is left to its prior.
        let mut known = information.rows(0, all).into_owned();
        for (i, free) in fitted.model.free.iter().enumerate() {
            known[(i, i)] += free.width.powi(-2);
        }
        let mut place = p;
        for columns in random {
            for _ in 0..columns.count() {
                known[(place, place)] += columns.variance.recip();
                place += 1;
            }
        }
        let mut scores = information.rows(all, 1 + replicates.drawn).transpose();
        // Where a prior holds a value against the strikes, they are balanced.
        let Prior { precision, away } = prior(&fitted.model);
        for i in 0..p {
            scores[(i, 0)] += precision[i] * away[i];
        }
        // At the end of what is believed it takes nothing of an effect that does the same.
        if let Some(i) = held_at_end(fitted) {
            known[(i, i)] += HELD;
        }
        let inverse = known.try_inverse()?;
        let beta = &inverse * scores.column(0);
        let mut own_left = DMatrix::zeros(all, strikes.len());
        for (at, mut own_left) in strikes.iter_mut().zip(own_left.column_iter_mut()) {
            let weighed = at.weighed();
            let left = weighed.row(all).transpose() - weighed.rows(0, all).tr_mul(&beta);
            own_left.gemv_tr(1.0, &at.own, &left, 0.0);
            at.left = left;
        }
        Some(Self {
            signs: signs(strikes.len(), replicates),
            studentised: studentised(strikes.len(), p, replicates.drawn, replicates.seed),
            prepared,
            fitted,
            strikes,
            responses: OnceLock::new(),
            promised: OnceLock::new(),
            own_left,
            inverse,
            scores,
            is_beside,
            replicates,
        })
    }

    /// How each strike answers to small changes; `None` where one does not come to rest.
    fn responses(&self) -> Option<&[Response<'a>]> {
        let Self {
            prepared, fitted, ..
        } = self;
        let model = &fitted.model;
        let of_all = || {
            let effects = model.effects(prepared.rig, &model.values).ok()?;
            let planar = prepared.planar(&model.values, &effects);
            let of_strike = |i: usize| {
                let release = prepared.release(&planar, i);
                let (clock, b) = (model.values[CLOCK], &fitted.nuisances[i]);
                prepared.response(&planar, i, release, clock, b, LONGEST)
            };
            let strikes = (0..prepared.strikes.len()).into_par_iter();
            strikes.map(of_strike).collect()
        };
        self.responses.get_or_init(of_all).as_deref()
    }

    /// `count` columns of every strike that they change: `answer(response, strike, column, change)` writes the change of that strike's frames. `None`
    /// where a strike does not come to rest.
    pub(crate) fn moved(
        &self,
        count: usize,
        touches: &(dyn Fn(usize, usize) -> bool + Sync),
        answer: &Answer<'_>,
    ) -> Option<StrikeColumns> {
        let responses = self.responses()?.par_iter().enumerate();
        let of_strike = |(i, response): (usize, &Response<'_>)| {
            let rows = self.strikes[i].simulated.len();
            let mut columns = None;
            let mut change = DVector::zeros(rows);
            for column in (0..count).filter(|column| touches(*column, i)) {
                answer(response, i, column, change.as_mut_slice());
                let columns = columns.get_or_insert_with(|| DMatrix::zeros(rows, count));
                let mut column = columns.column_mut(column);
                self.prepared.whitenings[i].pass(change.as_view(), column.as_mut_slice());
            }
            columns
        };
        Some(responses.map(of_strike).collect())
    }

    /// A whole linear step with those columns beside the model's own, the scatter estimated anew: where the scatter is of the
    /// effect's own making, its score at that scatter says little. A column that is kept stands as it is; the others have a
    /// weak prior of this `precision`. β is the model's values, then the columns that are not kept.
    pub(crate) fn step(
        &self,
        moved: &StrikeColumns,
        is_kept: &[bool],
        precision: &[f64],
    ) -> Option<Estimated> {
        let free: Vec<usize> = (0..is_kept.len()).filter(|k| !is_kept[*k]).collect();
        let products: Vec<_> = self
            .strikes
            .par_iter()
            .zip(moved)
            .zip(&self.fitted.linearisation.products)
            .map(|((at, columns), products)| {
                let Some(columns) = columns else {
                    // What is not touched has columns of nothing.
                    return products.beside_nothing(free.len());
                };
                let mut residual = at.whitened.residual.clone();
                for k in (0..is_kept.len()).filter(|k| is_kept[*k]) {
                    residual -= columns.column(k);
                }
                let free: Vec<_> = free.iter().map(|k| columns.column(*k)).collect();
                products.beside(
                    &at.whitened.nuisances,
                    &at.whitened.values,
                    &free,
                    &residual,
                )
            })
            .collect();
        let more: Vec<f64> = free.iter().map(|k| precision[*k]).collect();
        self.stepped(&products, &more)
    }

    /// Log-likelihood that a step of the model's own values promises: where a fit ended for steps led astray, that is more than it has, and no
    /// candidate's gain.
    pub(crate) fn promised_alone(&self) -> f64 {
        let promised = || {
            let fitted = &self.fitted.estimated;
            let stepped = self.stepped(&self.fitted.linearisation.products, &[]);
            stepped.map_or(fitted.likelihood_there, |stepped| {
                stepped.likelihood_there.max(fitted.likelihood_there)
            })
        };
        *self.promised.get_or_init(promised)
    }

    /// A step by these products of the model's own columns and of as many more, which have priors of this precision.
    fn stepped(&self, products: &[Products], more: &[f64]) -> Option<Estimated> {
        let mut own = prior(&self.fitted.model);
        if let Some(i) = held_at_end(self.fitted) {
            (own.precision[i], own.away[i]) = (HELD, 0.0);
        }
        let count = own.precision.len() + more.len();
        let mut prior = Prior {
            precision: DVector::from_iterator(count, own.precision.iter().chain(more).copied()),
            away: own.away.resize_vertically(count, 0.0),
        };
        let components = &self.fitted.estimated.components;
        loop {
            let stepped = mixed::estimate_within(products, &prior, components, EM_STEPS)?;
            if !hold_at_bounds(&self.fitted.model, &stepped, &mut prior) {
                return Some(stepped);
            }
        }
    }

    /// Columns as multiples of a strike's nuisances: `factors(strike)` has a row for each nuisance, a column for each column.
    pub(crate) fn launches(
        &self,
        factors: &(dyn Fn(usize) -> DMatrix<f64> + Sync),
    ) -> StrikeColumns {
        let strikes = self.strikes.par_iter().enumerate();
        strikes
            .map(|(i, at)| Some(&at.whitened.nuisances * factors(i)))
            .collect()
    }

    /// Scores of `count` columns with the model's own projected off, by measured and flipped residuals, not by drawn ones.
    pub(crate) fn scores(&self, count: usize, moved: &StrikeColumns) -> ColumnScores {
        let products =
            StrikeProducts::sums(&self.strikes, &[(count, moved)], self.scores.nrows() + 1);
        self.scores_by(moved, &products[0])
    }

    /// Scores of many sets of columns, each with its number of columns, by measured, flipped and drawn residuals. The drawn ones, which fill the
    /// processor's caches, are passed over once for all sets.
    pub(crate) fn scores_of_each(&self, sets: &[(usize, &StrikeColumns)]) -> Vec<ColumnScores> {
        let width = self.scores.nrows() + self.scores.ncols();
        let products = StrikeProducts::sums(&self.strikes, sets, width);
        sets.par_iter()
            .zip(products)
            .map(|((_, moved), products)| self.scores_by(moved, &products))
            .collect()
    }

    fn scores_by(
        &self,
        moved: &StrikeColumns,
        StrikeProducts { own, cross }: &StrikeProducts,
    ) -> ColumnScores {
        let p = self.inverse.nrows();
        let (seen, flipped) = (cross.nrows() - p, self.signs.ncols());
        let beside = cross.rows(0, p).transpose() * &self.inverse;
        let projected = cross.rows(p, seen).transpose() - &beside * self.scores.columns(0, seen);
        let mut scores = projected.resize_horizontally(seen + flipped, 0.0);
        for k in 1..seen {
            scores.column_mut(k).scale_mut(self.studentised[k - 1]);
        }
        let by_strike = self.by_strike(moved, &beside);
        if flipped > 0 {
            scores
                .columns_mut(seen, flipped)
                .copy_from(&(&by_strike * &self.signs));
        }
        ColumnScores {
            by_strike,
            alone: own.diagonal().iter().copied().collect(),
            information: own - &beside * cross.rows(0, p),
            scores,
        }
    }

    /// Each strike's own score (a column each): what it says of the columns, the model's own projected off.
    fn by_strike(&self, moved: &StrikeColumns, beside: &DMatrix<f64>) -> DMatrix<f64> {
        let mut all = -(beside * &self.own_left);
        let each = all.column_iter_mut().zip(&self.strikes).zip(moved);
        for ((mut score, at), columns) in each {
            if let Some(columns) = columns {
                score.gemv_tr(1.0, columns, &at.left, 1.0);
            }
        }
        all
    }
}
