//! Score tests: how much a small change would explain of what a fitted model leaves.
//!
//! At a fitted model a column c (the derivative of every track by some strength) gains S/2 of log-likelihood, S = u²/V, with
//! u = cᵀΣ⁻¹r and V what is left of cᵀΣ⁻¹c beside the model's own columns. What chance gains is known from the same columns in
//! two ways: residuals drawn from the fitted model and its noise (parametric bootstrap), and the measured residuals with the
//! signs of whole strikes flipped, which takes no model of noise on trust.

use std::sync::OnceLock;

use nalgebra::{Cholesky, DMatrix, DMatrixView, DVector, Dyn};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{ChiSquared, Distribution, StandardNormal};
use rayon::prelude::*;
use world::planar::Response;

use crate::fit::{Fitted, HELD, hold_at_bounds, prior};
use crate::linearisation::Whitened;
use crate::mixed::{self, Estimated, NUISANCES, Prior, Products, posterior};
use crate::model::CLOCK;
use crate::strikes::PreparedStrikes;

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

/// Share of a column left beside the model's own below which it differs from them by rounding alone.
const APART: f64 = 1e-6;

/// Whitened columns of each strike; none where it is not touched.
pub(crate) type StrikeColumns = Vec<Option<DMatrix<f64>>>;

/// Columns that stand beside the model's own, with coefficients of mean zero and this variance.
#[derive(Clone, Debug)]
pub(crate) struct RandomColumns {
    pub(crate) moved: StrikeColumns,
    pub(crate) variance: f64,
}

impl RandomColumns {
    pub(super) fn count(&self) -> usize {
        let first = self.moved.iter().flatten().next();
        first.map_or(0, DMatrix::ncols)
    }
}

/// Joint score of a few columns.
#[derive(Clone, Debug)]
pub(crate) struct Score {
    /// Gain in log-likelihood, S/2.
    pub(crate) gain: f64,
    /// Best coefficient of each column.
    pub(crate) coefficients: Vec<f64>,
    /// Standard error of the first column's coefficient.
    pub(crate) error: f64,
    /// The gain in each replicate: those drawn, then those flipped.
    pub(crate) by_chance: Vec<f64>,
    form: QuadraticForm,
    /// Each strike's own score, a column each.
    pub(crate) by_strike: DMatrix<f64>,
}

impl Score {
    /// The gain in log-likelihood of other scores of the same columns, one set a column.
    pub(crate) fn gains(&self, scores: DMatrixView<'_, f64>) -> Vec<f64> {
        self.form.gains(scores)
    }
}

/// What scores u gain: uᵀ·1 − ½·1ᵀV·1 of the columns that are kept at a coefficient of 1, and ½·uᵀV⁻¹u of what that leaves of the others.
#[derive(Clone, Debug)]
struct QuadraticForm {
    kept: Vec<usize>,
    free: Vec<usize>,
    all_or_nothing: f64,
    moved: DVector<f64>,
    factor: Cholesky<f64, Dyn>,
}

impl QuadraticForm {
    fn new(information: &DMatrix<f64>, is_kept: &[bool]) -> Option<Self> {
        let at = |kept: bool| -> Vec<usize> {
            let all = 0..is_kept.len();
            all.filter(|i| is_kept[*i] == kept).collect()
        };
        let (kept, free) = (at(true), at(false));
        let between = |a: &[usize], b: &[usize]| information.select_rows(a).select_columns(b);
        let ones = DVector::repeat(kept.len(), 1.0);
        Some(Self {
            all_or_nothing: -0.5 * ones.dot(&(between(&kept, &kept) * &ones)),
            moved: between(&free, &kept) * ones,
            factor: between(&free, &free).cholesky()?,
            kept,
            free,
        })
    }

    /// Scores of the columns that are free, less what those that are kept take.
    fn left(&self, scores: DMatrixView<'_, f64>) -> DMatrix<f64> {
        let mut left = scores.select_rows(&self.free);
        for mut column in left.column_iter_mut() {
            column -= &self.moved;
        }
        left
    }

    /// Gain of each column of scores: ½·uᵀV⁻¹u is half the square of L⁻¹u.
    fn gains(&self, scores: DMatrixView<'_, f64>) -> Vec<f64> {
        let mut left = self.left(scores);
        self.factor.l_dirty().solve_lower_triangular_mut(&mut left);
        let gain = |k: usize| {
            let by_kept: f64 = self.kept.iter().map(|i| scores[(*i, k)]).sum();
            self.all_or_nothing + by_kept + 0.5 * left.column(k).norm_squared()
        };
        (0..scores.ncols()).map(gain).collect()
    }
}

/// Scores u and information V of columns, the model's own projected off.
pub(crate) struct ColumnScores {
    pub(crate) information: DMatrix<f64>,
    /// Information of each column alone, the model's own columns not projected off.
    pub(crate) alone: Vec<f64>,
    /// One column for the residual, then one for each replicate.
    pub(crate) scores: DMatrix<f64>,
    /// Each strike's own score, a column each.
    pub(super) by_strike: DMatrix<f64>,
}

impl ColumnScores {
    /// The joint score, columns that are kept at a coefficient of 1; `None` where the model's own columns leave nothing of these.
    pub(crate) fn score(self, is_kept: &[bool]) -> Option<Score> {
        let count = self.information.nrows();
        if (0..count).any(|i| self.information[(i, i)] < APART * self.alone[i]) {
            return None;
        }
        let errors = self.information.clone().cholesky()?.inverse();
        let form = QuadraticForm::new(&self.information, is_kept)?;
        let mut found = form.left(self.scores.columns(0, 1).as_view());
        form.factor.solve_mut(&mut found);
        let mut coefficients = vec![1.0; count];
        for (i, place) in form.free.iter().enumerate() {
            coefficients[*place] = found[i];
        }
        let mut gains = form.gains(self.scores.as_view());
        let by_chance = gains.split_off(1);
        Some(Score {
            gain: gains[0],
            error: errors[(0, 0)].max(0.0).sqrt(),
            coefficients,
            by_chance,
            form,
            by_strike: self.by_strike,
        })
    }
}

/// Residuals drawn, and flips. With 299 drawn, a probability below 1 % is at most one of them beyond.
pub(crate) const DRAWN: usize = 299;
pub(crate) const FLIPPED: usize = 499;

/// How many residuals are drawn, and how many times signs are flipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Replicates {
    pub(crate) drawn: usize,
    pub(crate) flipped: usize,
    pub(crate) seed: u64,
}

impl Replicates {
    /// No replicates: scores alone.
    pub(crate) const NONE: Self = Self {
        drawn: 0,
        flipped: 0,
        seed: 0,
    };
}

/// Coefficients of the random columns in each replicate, the same for all strikes.
pub(super) fn common_heights(random: &[&RandomColumns], replicates: Replicates) -> DMatrix<f64> {
    let scales: Vec<f64> = random
        .iter()
        .flat_map(|columns| vec![columns.variance.sqrt(); columns.count()])
        .collect();
    let mut stream = ChaCha8Rng::seed_from_u64(replicates.seed);
    stream.set_stream(u64::MAX);
    DMatrix::from_fn(scales.len(), replicates.drawn, |k, _| {
        let normal: f64 = StandardNormal.sample(&mut stream);
        scales[k] * normal
    })
}

/// A row for each strike, a column for each flip: 1 or −1.
pub(crate) fn signs(strikes: usize, replicates: Replicates) -> DMatrix<f64> {
    let mut stream = ChaCha8Rng::seed_from_u64(replicates.seed);
    stream.set_stream(u64::MAX - 1);
    DMatrix::from_fn(strikes, replicates.flipped, |_, _| {
        if stream.random::<bool>() { 1.0 } else { -1.0 }
    })
}

/// Factors on drawn scores for the scatter being estimated from as many strikes, less the values fitted to them: scores over it follow Student's t.
pub(super) fn studentised(strikes: usize, fitted: usize, count: usize, seed: u64) -> Vec<f64> {
    let freedom = strikes.saturating_sub(fitted).max(1) as f64;
    let mut stream = ChaCha8Rng::seed_from_u64(seed);
    stream.set_stream(u64::MAX - 2);
    let Ok(distribution) = ChiSquared::new(freedom) else {
        return vec![1.0; count];
    };
    (0..count)
        .map(|_| (freedom / distribution.sample(&mut stream)).sqrt())
        .collect()
}

/// One strike at a fitted model.
pub(super) struct StrikeAtFit<'f> {
    pub(super) whitened: &'f Whitened,
    pub(super) simulated: &'f DVector<f64>,
    /// The model's own columns X, the random ones among them.
    pub(super) own: DMatrix<f64>,
    /// [G, Σ⁻¹·[X, r, drawn residuals]]ᵀ.
    pub(super) seen: DMatrix<f64>,
    /// Σ⁻¹·(r − X·β).
    pub(super) left: DVector<f64>,
    /// C/σ² and 1/σ².
    pub(super) posterior: DMatrix<f64>,
    pub(super) precision: f64,
}

impl<'f> StrikeAtFit<'f> {
    /// (Σ⁻¹·[X, r, drawn residuals])ᵀ.
    pub(super) fn weighed(&self) -> DMatrixView<'_, f64> {
        self.seen.rows(NUISANCES, self.seen.nrows() - NUISANCES)
    }

    pub(super) fn new(
        prepared: &PreparedStrikes<'_>,
        fitted: &'f Fitted,
        i: usize,
        random: &[&RandomColumns],
        common: &DMatrix<f64>,
        replicates: Replicates,
    ) -> Self {
        let components = &fitted.estimated.components;
        let whitened = &fitted.linearisation.whitened[i];
        let g = &whitened.nuisances;
        let (rows, p) = (g.nrows(), whitened.values.ncols());
        let mut own = whitened
            .values
            .clone()
            .resize_horizontally(p + common.nrows(), 0.0);
        let mut place = p;
        for columns in random {
            if let Some(mine) = &columns.moved[i] {
                own.columns_mut(place, mine.ncols()).copy_from(mine);
            }
            place += columns.count();
        }
        let kept = &prepared.frames[i].kept;
        let is_kept = |row: usize| kept[row % kept.len()];
        let mut stream = ChaCha8Rng::seed_from_u64(replicates.seed);
        stream.set_stream(i as u64);
        let mut all = DMatrix::zeros(rows, place + 1 + replicates.drawn);
        all.columns_mut(0, place).copy_from(&own);
        all.set_column(place, &whitened.residual);
        let mut normal = || -> f64 { StandardNormal.sample(&mut stream) };
        for replicate in 0..replicates.drawn {
            let b = DVector::from_fn(NUISANCES, |k, _| components.nuisance[k] * normal());
            let mut drawn = g * b;
            for row in 0..rows {
                let noise = components.camera * normal();
                if is_kept(row) {
                    drawn[row] += noise;
                }
            }
            drawn += own.columns(p, place - p) * common.column(replicate);
            all.set_column(place + 1 + replicate, &drawn);
        }
        let precision = components.camera.powi(-2);
        let posterior = posterior(g, components) * precision;
        let mut seen = DMatrix::zeros(NUISANCES + all.ncols(), rows);
        seen.rows_mut(0, NUISANCES).tr_copy_from(g);
        let weighed = &all * precision - g * (&posterior * g.tr_mul(&all));
        seen.rows_mut(NUISANCES, all.ncols()).tr_copy_from(&weighed);
        Self {
            simulated: &fitted.linearisation.raw[i].simulated,
            whitened,
            own,
            seen,
            left: DVector::zeros(0),
            posterior,
            precision,
        }
    }
}

/// Products of one set of columns C, weighed by Σ⁻¹.
pub(super) struct StrikeProducts {
    /// CᵀΣ⁻¹C.
    pub(super) own: DMatrix<f64>,
    /// [X, r, drawn residuals]ᵀΣ⁻¹·C.
    pub(super) cross: DMatrix<f64>,
}

/// One strike's products of all sets of columns that change it, side by side.
struct OfStrike {
    /// Places of these sets.
    touching: Vec<usize>,
    /// Set by set, column by column.
    own: Vec<f64>,
    cross: DMatrix<f64>,
}

impl StrikeProducts {
    /// Products of each set (its number of columns beside it), summed over strikes in their order; `cross` with the first `width` columns of what a
    /// strike holds.
    pub(super) fn sums(
        strikes: &[StrikeAtFit<'_>],
        sets: &[(usize, &StrikeColumns)],
        width: usize,
    ) -> Vec<Self> {
        let mut sums: Vec<Self> = sets
            .iter()
            .map(|(count, _)| Self {
                own: DMatrix::zeros(*count, *count),
                cross: DMatrix::zeros(width, *count),
            })
            .collect();
        let by_strike: Vec<OfStrike> = strikes
            .par_iter()
            .enumerate()
            .map(|(i, at)| OfStrike::new(at, i, sets, width))
            .collect();
        for of_strike in by_strike {
            let (mut first, mut own) = (0, of_strike.own.iter());
            for place in of_strike.touching {
                let sum = &mut sums[place];
                let count = sum.own.ncols();
                sum.own
                    .iter_mut()
                    .zip(&mut own)
                    .for_each(|(sum, own)| *sum += own);
                sum.cross += of_strike.cross.view((NUISANCES, first), (width, count));
                first += count;
            }
        }
        sums
    }
}

impl OfStrike {
    fn new(
        at: &StrikeAtFit<'_>,
        strike: usize,
        sets: &[(usize, &StrikeColumns)],
        width: usize,
    ) -> Self {
        let (touching, columns): (Vec<usize>, Vec<&DMatrix<f64>>) = sets
            .iter()
            .enumerate()
            .filter_map(|(place, (_, moved))| Some((place, moved[strike].as_ref()?)))
            .unzip();
        let count = columns.iter().map(|c| c.ncols()).sum();
        let mut all = DMatrix::zeros(at.seen.ncols(), count);
        let mut first = 0;
        for c in &columns {
            all.columns_mut(first, c.ncols()).copy_from(c);
            first += c.ncols();
        }
        // By products of two matrices, which are blocked, where dot products are not.
        let cross = at.seen.rows(0, NUISANCES + width) * all;
        let by_nuisances = cross.rows(0, NUISANCES);
        let explained = &at.posterior * by_nuisances;
        let mut own = Vec::with_capacity(columns.iter().map(|c| c.ncols().pow(2)).sum());
        let mut first = 0;
        for c in columns {
            let gram = gram(c);
            for j in 0..c.ncols() {
                let explained = explained.column(first + j);
                own.extend((0..c.ncols()).map(|i| {
                    gram[(i, j)] * at.precision - by_nuisances.column(first + i).dot(&explained)
                }));
            }
            first += c.ncols();
        }
        Self {
            touching,
            own,
            cross,
        }
    }
}

/// CᵀC: of many columns by a product of two matrices, which is blocked, where one by dot products is not.
fn gram(columns: &DMatrix<f64>) -> DMatrix<f64> {
    const MANY: usize = 8;
    match columns.ncols() > MANY {
        true => columns.transpose() * columns,
        false => columns.tr_mul(columns),
    }
}
