//! Score tests: how much a small change would explain of what a fitted model leaves.
//!
//! At a fitted model a column c (the derivative of every track by some strength) gains S/2 of log-likelihood, S = u²/V, with
//! u = cᵀΣ⁻¹r and V what is left of cᵀΣ⁻¹c beside the model's own columns. The same columns seen through residuals drawn from
//! the fitted model tell what is gained by chance.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use values::Point;
use world::planar::Planar;

use crate::{
    fit::{Columns, Field, Fitted, prior, stack},
    mixed::{self, Estimated, NUISANCES, posterior},
    model::CLOCK,
};

/// A column of which less than this share is left beside the model's own differs from them by rounding.
const APART: f64 = 1e-6;

/// One strike at a fitted model.
struct At<'f> {
    columns: &'f Columns,
    frames: DVector<f64>,
    /// Σ⁻¹·[X, r, replicates].
    weighed: DMatrix<f64>,
    /// C/σ² and 1/σ².
    posterior: DMatrix<f64>,
    precision: f64,
}

/// Columns of each strike; none where it is not touched.
pub(crate) type Moved = Vec<Option<DMatrix<f64>>>;

/// A fitted model, ready to be asked.
pub(crate) struct Asked<'f, 'a> {
    field: &'f Field<'a>,
    fitted: &'f Fitted,
    strikes: Vec<At<'f>>,
    /// (XᵀΣ⁻¹X)⁻¹.
    inverse: DMatrix<f64>,
    /// XᵀΣ⁻¹·[r, replicates].
    scores: DMatrix<f64>,
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
    /// The gain in each replicate.
    pub(crate) by_chance: Vec<f64>,
}

/// Score u and information V of columns, the model's own projected off.
pub(crate) struct Told {
    pub(crate) information: DMatrix<f64>,
    /// What each column's information would be alone.
    pub(crate) alone: Vec<f64>,
    /// One column for the residual, then one for each replicate.
    pub(crate) scores: DMatrix<f64>,
    /// How far each of the model's own values (columns) makes up for each of these (rows).
    pub(crate) made_up: DMatrix<f64>,
}

impl<'f, 'a> Asked<'f, 'a> {
    /// Prepares a fitted model, with this many replicates drawn from it.
    pub(crate) fn new(
        field: &'f Field<'a>,
        fitted: &'f Fitted,
        replicates: usize,
        seed: u64,
    ) -> Option<Self> {
        let spread = &fitted.estimated.spread;
        let p = fitted.model.free.len();
        let strikes: Vec<At<'_>> = fitted
            .taken
            .columns
            .par_iter()
            .enumerate()
            .map(|(i, columns)| {
                let g = &columns.nuisances;
                let rows = g.nrows();
                let mut random = ChaCha8Rng::seed_from_u64(seed);
                random.set_stream(i as u64);
                let mut all = DMatrix::zeros(rows, p + 1 + replicates);
                all.columns_mut(0, p).copy_from(&columns.values);
                all.set_column(p, &columns.residual);
                let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
                for replicate in 0..replicates {
                    let b = DVector::from_fn(NUISANCES, |k, _| spread.nuisance[k] * normal());
                    let noise = DVector::from_fn(rows, |_, _| spread.camera * normal());
                    all.set_column(p + 1 + replicate, &(g * b + noise));
                }
                let precision = spread.camera.powi(-2);
                let posterior = posterior(g, spread) * precision;
                let weighed = &all * precision - g * (&posterior * g.tr_mul(&all));
                At {
                    frames: field.simulated(i, columns, &fitted.kicks[i]),
                    columns,
                    weighed,
                    posterior,
                    precision,
                }
            })
            .collect();
        let mut information = DMatrix::zeros(p, p + 1 + replicates);
        for at in &strikes {
            information += at.columns.values.tr_mul(&at.weighed);
        }
        // What the strikes say nothing of, such as a cap above all speeds, is left to its prior.
        let mut known = information.columns(0, p).into_owned();
        for (i, free) in fitted.model.free.iter().enumerate() {
            known[(i, i)] += free.width.powi(-2);
        }
        Some(Self {
            field,
            fitted,
            strikes,
            inverse: known.try_inverse()?,
            scores: information.columns(p, 1 + replicates).into_owned(),
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
                for (k, (planar, step)) in worlds.iter().enumerate() {
                    if !touches(k, i) {
                        continue;
                    }
                    let frames = self.field.frames(planar, i, clock, &self.fitted.kicks[i])?;
                    let column = (stack(&frames.at) - &at.frames) / *step;
                    columns
                        .get_or_insert_with(|| DMatrix::zeros(column.len(), worlds.len()))
                        .set_column(k, &column);
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
        let p = self.inverse.nrows();
        let free: Vec<usize> = (0..is_kept.len()).filter(|k| !is_kept[*k]).collect();
        let products: Vec<_> = self
            .strikes
            .par_iter()
            .zip(moved)
            .map(|(at, columns)| {
                let mut x = DMatrix::zeros(at.frames.len(), p + free.len() + 1);
                x.columns_mut(0, p).copy_from(&at.columns.values);
                let mut residual = at.columns.residual.clone();
                if let Some(columns) = columns {
                    for (place, k) in free.iter().enumerate() {
                        x.set_column(p + place, &columns.column(*k));
                    }
                    for k in (0..is_kept.len()).filter(|k| is_kept[*k]) {
                        residual -= columns.column(k);
                    }
                }
                x.set_column(p + free.len(), &residual);
                mixed::Products::new(&at.columns.nuisances, &x)
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
        mixed::estimate(&products, &prior, &self.fitted.estimated.spread)
    }

    /// Columns as multiples of a strike's nuisances: `factors(strike)` has a row for each nuisance, a column for each column.
    pub(crate) fn launches(&self, factors: &(dyn Fn(usize) -> DMatrix<f64> + Sync)) -> Moved {
        let strikes = self.strikes.par_iter().enumerate();
        strikes
            .map(|(i, at)| Some(&at.columns.nuisances * factors(i)))
            .collect()
    }

    /// What a change of the model's values does to each strike, as far as it looks like another launch: relative speed and
    /// angle (rad).
    pub(crate) fn as_launches(&self, change: &DVector<f64>) -> Vec<Point> {
        self.strikes
            .iter()
            .map(|at| {
                let seen = at.columns.nuisances.tr_mul(&(&at.columns.values * change));
                let launch = &at.posterior * seen / at.precision;
                Point::new(launch[0], launch[1])
            })
            .collect()
    }

    /// What `count` columns say, the model's own projected off.
    pub(crate) fn tell(&self, count: usize, moved: &Moved) -> Told {
        let p = self.inverse.nrows();
        let mut own = DMatrix::zeros(count, count);
        let mut cross = DMatrix::zeros(count, self.strikes[0].weighed.ncols());
        let parts: Vec<_> = self
            .strikes
            .par_iter()
            .zip(moved)
            .map(|(at, columns)| {
                columns.as_ref().map(|c| {
                    let projected = at.columns.nuisances.tr_mul(c);
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
        Told {
            alone: own.diagonal().iter().copied().collect(),
            information: own - &beside * cross.columns(0, p).transpose(),
            scores: cross.columns(p, cross.ncols() - p) - &beside * &self.scores,
            made_up: beside,
        }
    }
}

impl Told {
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
