//! Score tests: how much a small change would explain of what a fitted model leaves.
//!
//! At a fitted model a column c (the derivative of every track by some strength) gains S/2 of log-likelihood, S = u²/V, with
//! u = cᵀΣ⁻¹r and V what is left of cᵀΣ⁻¹c beside the model's own columns. What chance gains is known from the same columns in
//! two ways: residuals drawn from the fitted model and its noise (parametric bootstrap), and the measured residuals with the
//! signs of whole strikes flipped, which takes no model of noise on trust.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{ChiSquared, Distribution, StandardNormal};
use rayon::prelude::*;
use values::Point;
use world::planar::Planar;

use crate::{
    fit::{Fitted, prior},
    linearisation::Whitened,
    mixed::{self, Estimated, NUISANCES, posterior},
    model::CLOCK,
    strikes::{PreparedStrikes, stack},
};

/// A column of which less than this share is left beside the model's own differs from them by rounding.
const APART: f64 = 1e-6;

/// How many residuals are drawn, and how many times signs are flipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Replicates {
    pub(crate) drawn: usize,
    pub(crate) flipped: usize,
    pub(crate) seed: u64,
}

impl Replicates {
    /// Scores alone.
    pub(crate) const NONE: Self = Self {
        drawn: 0,
        flipped: 0,
        seed: 0,
    };
}

/// Whitened columns of each strike; none where it is not touched.
pub(crate) type Moved = Vec<Option<DMatrix<f64>>>;

/// Columns that stand beside the model's own, with coefficients of mean zero and this variance.
#[derive(Clone, Debug)]
pub(crate) struct RandomColumns {
    pub(crate) moved: Moved,
    pub(crate) variance: f64,
}

impl RandomColumns {
    fn count(&self) -> usize {
        let first = self.moved.iter().flatten().next();
        first.map_or(0, DMatrix::ncols)
    }
}

/// One strike at a fitted model.
struct At<'f> {
    whitened: &'f Whitened,
    simulated: &'f DVector<f64>,
    /// The model's own columns X, the random ones among them.
    own: DMatrix<f64>,
    /// Σ⁻¹·[X, r, drawn residuals].
    weighed: DMatrix<f64>,
    /// Σ⁻¹·(r − X·β).
    left: DVector<f64>,
    /// C/σ² and 1/σ².
    posterior: DMatrix<f64>,
    precision: f64,
}

/// A fitted model, ready to be tested against columns that it lacks.
pub(crate) struct ScoreTest<'f, 'a> {
    field: &'f PreparedStrikes<'a>,
    fitted: &'f Fitted,
    strikes: Vec<At<'f>>,
    /// (XᵀΣ⁻¹X + prior precision)⁻¹.
    inverse: DMatrix<f64>,
    /// XᵀΣ⁻¹·[r, drawn residuals].
    scores: DMatrix<f64>,
    /// A row for each strike, a column for each flip: 1 or −1.
    signs: DMatrix<f64>,
    /// How much more a drawn residual's scatter may be than what is estimated from it.
    studentised: Vec<f64>,
}

/// What a few columns say together.
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
}

/// Scores u and information V of columns, the model's own projected off.
pub(crate) struct ColumnScores {
    pub(crate) information: DMatrix<f64>,
    /// What each column's information would be alone.
    pub(crate) alone: Vec<f64>,
    /// One column for the residual, then one for each replicate.
    pub(crate) scores: DMatrix<f64>,
    /// How far each of the model's own values (columns) makes up for each of these (rows).
    pub(crate) made_up: DMatrix<f64>,
}

impl<'f, 'a> ScoreTest<'f, 'a> {
    /// Prepares a fitted model with random columns beside it; `None` where its values cannot be told apart.
    pub(crate) fn new(
        field: &'f PreparedStrikes<'a>,
        fitted: &'f Fitted,
        random: &[RandomColumns],
        replicates: Replicates,
    ) -> Option<Self> {
        let p = fitted.model.free.len();
        let all = p + random.iter().map(RandomColumns::count).sum::<usize>();
        let common = common_heights(random, replicates);
        let mut strikes: Vec<At<'f>> = (0..field.strikes.len())
            .into_par_iter()
            .map(|i| At::new(field, fitted, i, random, &common, replicates))
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
        let inverse = known.try_inverse()?;
        let scores = information.columns(all, 1 + replicates.drawn).into_owned();
        let beta = &inverse * scores.column(0);
        strikes.par_iter_mut().for_each(|at| {
            at.left = at.weighed.column(all) - at.weighed.columns(0, all) * &beta;
        });
        Some(Self {
            signs: signs(strikes.len(), replicates),
            studentised: studentised(strikes.len(), p, replicates),
            field,
            fitted,
            strikes,
            inverse,
            scores,
        })
    }

    /// Columns as the difference that worlds beside the fitted one make, per unit of each step; a world acts on a strike only
    /// where `touches` says so. `None` where a strike does not come to rest.
    pub(crate) fn moved(
        &self,
        worlds: &[(Planar<'_>, f64)],
        touches: &(dyn Fn(usize, usize) -> bool + Sync),
    ) -> Option<Moved> {
        let clock = self.fitted.model.values[CLOCK];
        self.strikes
            .par_iter()
            .enumerate()
            .map(|(i, at)| {
                let mut columns: Option<DMatrix<f64>> = None;
                let whitening = &self.field.whitenings[i];
                for (k, (planar, step)) in worlds.iter().enumerate() {
                    if !touches(k, i) {
                        continue;
                    }
                    let b = &self.fitted.nuisances[i];
                    let frames = self.field.simulate(planar, i, clock, b)?;
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
        moved: &Moved,
        is_kept: &[bool],
        precision: &[f64],
    ) -> Option<Estimated> {
        let p = self.fitted.model.free.len();
        let free: Vec<usize> = (0..is_kept.len()).filter(|k| !is_kept[*k]).collect();
        let products: Vec<_> = self
            .strikes
            .par_iter()
            .zip(moved)
            .zip(&self.field.whitenings)
            .map(|((at, columns), whitening)| {
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
                mixed::Products::new(&at.whitened.nuisances, &x, whitening)
            })
            .collect();
        let own = prior(&self.fitted.model);
        let more = free.iter().map(|k| precision[*k]);
        let prior = mixed::Prior {
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
    pub(crate) fn launches(&self, factors: &(dyn Fn(usize) -> DMatrix<f64> + Sync)) -> Moved {
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
    pub(crate) fn scores(&self, count: usize, moved: &Moved) -> ColumnScores {
        let p = self.inverse.nrows();
        let (drawn, flipped) = (self.studentised.len(), self.signs.ncols());
        let mut own = DMatrix::zeros(count, count);
        let mut cross = DMatrix::zeros(count, p + 1 + drawn);
        let parts: Vec<_> = self
            .strikes
            .par_iter()
            .zip(moved)
            .map(|(at, columns)| {
                columns.as_ref().map(|c| {
                    let projected = at.whitened.nuisances.tr_mul(c);
                    let own = c.tr_mul(c) * at.precision
                        - projected.tr_mul(&(&at.posterior * &projected));
                    (own, c.tr_mul(&at.weighed))
                })
            })
            .collect();
        for (mine, with) in parts.into_iter().flatten() {
            own += mine;
            cross += with;
        }
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
    fn by_strike(&self, count: usize, moved: &Moved, beside: &DMatrix<f64>) -> DMatrix<f64> {
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

impl<'f> At<'f> {
    fn new(
        field: &PreparedStrikes<'_>,
        fitted: &'f Fitted,
        i: usize,
        random: &[RandomColumns],
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
        let kept = &field.frames[i].kept;
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
        let weighed = &all * precision - g * (&posterior * g.tr_mul(&all));
        Self {
            simulated: &fitted.linearisation.raw[i].simulated,
            whitened,
            own,
            weighed,
            left: DVector::zeros(0),
            posterior,
            precision,
        }
    }
}

/// Coefficients of the random columns in each replicate, the same for all strikes.
fn common_heights(random: &[RandomColumns], replicates: Replicates) -> DMatrix<f64> {
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

fn signs(strikes: usize, replicates: Replicates) -> DMatrix<f64> {
    let mut stream = ChaCha8Rng::seed_from_u64(replicates.seed);
    stream.set_stream(u64::MAX - 1);
    DMatrix::from_fn(strikes, replicates.flipped, |_, _| {
        if stream.random::<bool>() { 1.0 } else { -1.0 }
    })
}

/// The scatter of strikes is estimated from as many strikes, less the values fitted to them: scores over the estimated
/// scatter follow Student's t.
fn studentised(strikes: usize, fitted: usize, replicates: Replicates) -> Vec<f64> {
    let freedom = strikes.saturating_sub(fitted).max(1) as f64;
    let mut stream = ChaCha8Rng::seed_from_u64(replicates.seed);
    stream.set_stream(u64::MAX - 2);
    let Ok(distribution) = ChiSquared::new(freedom) else {
        return vec![1.0; replicates.drawn];
    };
    (0..replicates.drawn)
        .map(|_| (freedom / distribution.sample(&mut stream)).sqrt())
        .collect()
}

impl ColumnScores {
    /// The joint score, columns that are kept at a coefficient of 1; `None` where the model's own columns leave nothing of these.
    pub(crate) fn score(&self, is_kept: &[bool]) -> Option<Score> {
        let count = self.information.nrows();
        if (0..count).any(|i| self.information[(i, i)] < APART * self.alone[i]) {
            return None;
        }
        let errors = self.information.clone().cholesky()?.inverse();
        let at =
            |kept: bool| -> Vec<usize> { (0..count).filter(|i| is_kept[*i] == kept).collect() };
        let (kept, free) = (at(true), at(false));
        let between = |a: &[usize], b: &[usize]| self.information.select_rows(a).select_columns(b);
        let ones = DVector::repeat(kept.len(), 1.0);
        let all_or_nothing = -0.5 * ones.dot(&(between(&kept, &kept) * &ones));
        let moved = between(&free, &kept) * ones;
        let factor = between(&free, &free).cholesky()?;
        let gained = |k: usize| {
            let u = self.scores.column(k);
            let left = DVector::from_fn(free.len(), |i, _| u[free[i]] - moved[i]);
            let coefficients = factor.solve(&left);
            let by_kept: f64 = kept.iter().map(|i| u[*i]).sum();
            let gain = all_or_nothing + by_kept + 0.5 * left.dot(&coefficients);
            (gain, coefficients)
        };
        let (gain, found) = gained(0);
        let mut coefficients = vec![1.0; count];
        for (i, place) in free.iter().enumerate() {
            coefficients[*place] = found[i];
        }
        Some(Score {
            gain,
            error: errors[(0, 0)].max(0.0).sqrt(),
            coefficients,
            by_chance: (1..self.scores.ncols()).map(|k| gained(k).0).collect(),
        })
    }
}
