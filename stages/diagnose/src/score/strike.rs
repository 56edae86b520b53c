//! One strike at a fitted model, with the residuals that are drawn for it.

use nalgebra::{DMatrix, DMatrixView, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::{columns::RandomColumns, replicates::Replicates};
use crate::{
    fit::Fitted,
    linearisation::Whitened,
    mixed::{NUISANCES, posterior},
    strikes::PreparedStrikes,
};

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
