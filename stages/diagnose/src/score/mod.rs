//! Score tests: how much a small change would explain of what a fitted model leaves.
//!
//! At a fitted model a column c (the derivative of every track by some strength) gains S/2 of log-likelihood, S = u²/V, with
//! u = cᵀΣ⁻¹r and V what is left of cᵀΣ⁻¹c beside the model's own columns. What chance gains is known from the same columns in
//! two ways: residuals drawn from the fitted model and its noise (parametric bootstrap), and the measured residuals with the
//! signs of whole strikes flipped, which takes no model of noise on trust.

mod columns;
mod deviations;
mod products;
mod replicates;
mod strike;

pub(crate) use columns::{ColumnScores, RandomColumns, Score, StrikeColumns};
pub(crate) use deviations::Deviations;
pub(crate) use replicates::Replicates;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use values::Point;
use world::planar::Planar;

use self::{
    products::StrikeProducts,
    replicates::{common_heights, signs, studentised},
    strike::StrikeAtFit,
};
use crate::{
    fit::{Fitted, HELD, prior},
    mixed::{self, Estimated, Prior},
    model::CLOCK,
    strikes::{PreparedStrikes, stack},
};

/// Wander of friction, relative, that shows in no track.
const STILL: f64 = 1e-3;

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
    /// (XᵀΣ⁻¹X + prior precision)⁻¹.
    inverse: DMatrix<f64>,
    /// XᵀΣ⁻¹·[r, drawn residuals].
    scores: DMatrix<f64>,
    /// A row for each strike, a column for each flip: 1 or −1.
    signs: DMatrix<f64>,
    /// How much more a drawn residual's scatter may be than what is estimated from it.
    studentised: Vec<f64>,
    /// Whether random columns stand beside the model, its wander apart.
    pub(crate) is_beside: bool,
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
        let mut information = DMatrix::zeros(all, all + 1 + replicates.drawn);
        for at in &strikes {
            information += at.own.tr_mul(&at.weighed);
        }
        // What the strikes say nothing of, such as a cap above all speeds, is left to its prior.
        let mut known = information.columns(0, all).into_owned();
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
        let mut scores = information.columns(all, 1 + replicates.drawn).into_owned();
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
        strikes.par_iter_mut().for_each(|at| {
            at.left = at.weighed.column(all) - at.weighed.columns(0, all) * &beta;
        });
        Some(Self {
            signs: signs(strikes.len(), replicates),
            studentised: studentised(strikes.len(), p, replicates),
            prepared,
            fitted,
            strikes,
            inverse,
            scores,
            is_beside,
        })
    }

    /// Columns as the difference that worlds beside the fitted one make, per unit of each step; a world acts on a strike only
    /// where `touches` says so. `None` where a strike does not come to rest.
    pub(crate) fn moved(
        &self,
        worlds: &[(Planar<'_>, f64)],
        touches: &(dyn Fn(usize, usize) -> bool + Sync),
    ) -> Option<StrikeColumns> {
        let clock = self.fitted.model.values[CLOCK];
        self.strikes
            .par_iter()
            .enumerate()
            .map(|(i, at)| {
                let mut columns: Option<DMatrix<f64>> = None;
                let whitening = &self.prepared.whitenings[i];
                for (k, (planar, step)) in worlds.iter().enumerate() {
                    if !touches(k, i) {
                        continue;
                    }
                    let b = &self.fitted.nuisances[i];
                    let frames = self.prepared.simulate(planar, i, clock, b)?;
                    let column = (stack(&frames.at) - at.simulated) / *step;
                    columns
                        .get_or_insert_with(|| DMatrix::zeros(column.len(), worlds.len()))
                        .set_column(k, &whitening.column(&column));
                }
                Some(columns)
            })
            .collect()
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
        let p = self.fitted.model.free.len();
        let free: Vec<usize> = (0..is_kept.len()).filter(|k| !is_kept[*k]).collect();
        let products: Vec<_> = self
            .strikes
            .par_iter()
            .zip(moved)
            .zip(&self.prepared.whitenings)
            .zip(&self.prepared.paths)
            .map(|(((at, columns), whitening), path)| {
                let mut x = DMatrix::zeros(at.simulated.len(), p + free.len() + 1);
                x.columns_mut(0, p).copy_from(&at.whitened.values);
                let mut residual = at.whitened.residual.clone();
                if let Some(columns) = columns {
                    for (place, k) in free.iter().enumerate() {
                        x.set_column(p + place, &columns.column(*k));
                    }
                    for k in (0..is_kept.len()).filter(|k| is_kept[*k]) {
                        residual -= columns.column(k);
                    }
                }
                x.set_column(p + free.len(), &residual);
                mixed::Products::new(&at.whitened.nuisances, &x, whitening, path)
            })
            .collect();
        let mut own = prior(&self.fitted.model);
        if let Some(i) = held_at_end(self.fitted) {
            (own.precision[i], own.away[i]) = (HELD, 0.0);
        }
        let more = free.iter().map(|k| precision[*k]);
        let prior = Prior {
            precision: own
                .precision
                .iter()
                .copied()
                .chain(more)
                .collect::<Vec<_>>()
                .into(),
            away: own.away.resize_vertically(p + free.len(), 0.0),
        };
        mixed::estimate(&products, &prior, &self.fitted.estimated.components)
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

    /// What a change of the model's values does to each strike, as far as it looks like another launch: relative speed and
    /// angle (rad).
    pub(crate) fn as_launches(&self, change: &DVector<f64>) -> Vec<Point> {
        self.strikes
            .iter()
            .map(|at| {
                let seen = at.whitened.nuisances.tr_mul(&(&at.own * change));
                let launch = &at.posterior * seen / at.precision;
                Point::new(launch[0], launch[1])
            })
            .collect()
    }

    /// What `count` columns say, the model's own projected off.
    pub(crate) fn scores(&self, count: usize, moved: &StrikeColumns) -> ColumnScores {
        let products = StrikeProducts::sums(&self.strikes, &[(count, moved)]);
        self.scores_by(count, moved, &products[0])
    }

    /// The same of many sets of columns, each with its count: a strike's drawn residuals, which fill the processor's caches, are then
    /// gone through once for all.
    pub(crate) fn scores_of_each(&self, sets: &[(usize, &StrikeColumns)]) -> Vec<ColumnScores> {
        let products = StrikeProducts::sums(&self.strikes, sets);
        sets.par_iter()
            .zip(products)
            .map(|((count, moved), products)| self.scores_by(*count, moved, &products))
            .collect()
    }

    fn scores_by(
        &self,
        count: usize,
        moved: &StrikeColumns,
        StrikeProducts { own, cross }: &StrikeProducts,
    ) -> ColumnScores {
        let p = self.inverse.nrows();
        let (drawn, flipped) = (self.studentised.len(), self.signs.ncols());
        let beside = cross.columns(0, p) * &self.inverse;
        let projected = cross.columns(p, 1 + drawn) - &beside * &self.scores;
        let mut scores = projected.resize_horizontally(1 + drawn + flipped, 0.0);
        for (k, factor) in self.studentised.iter().enumerate() {
            scores.column_mut(1 + k).scale_mut(*factor);
        }
        if flipped > 0 {
            let by_strike = self.by_strike(count, moved, &beside);
            scores
                .columns_mut(1 + drawn, flipped)
                .copy_from(&(by_strike * &self.signs));
        }
        ColumnScores {
            alone: own.diagonal().iter().copied().collect(),
            information: own - &beside * cross.columns(0, p).transpose(),
            scores,
            made_up: beside,
        }
    }

    /// Each strike's own score (a column each): what it says of the columns, the model's own projected off.
    fn by_strike(
        &self,
        count: usize,
        moved: &StrikeColumns,
        beside: &DMatrix<f64>,
    ) -> DMatrix<f64> {
        let mut all = DMatrix::zeros(count, self.strikes.len());
        for (i, (at, columns)) in self.strikes.iter().zip(moved).enumerate() {
            let mut score = -(beside * at.own.tr_mul(&at.left));
            if let Some(columns) = columns {
                score += columns.tr_mul(&at.left);
            }
            all.set_column(i, &score);
        }
        all
    }
}
