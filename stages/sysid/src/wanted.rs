//! The value that one more parameter would take if it were fitted beside all that was.

use nalgebra::{DMatrix, DVector};

use crate::{
    fit::Fitted,
    interval::{quantile, variances},
    scatter::{ANGLE, Evidence},
};

/// One Gauss–Newton step of a number that was held. Every strike's path may bend by itself beside it: a force during the slide that the
/// world lacks is then no evidence of how the object left the tip.
pub(crate) struct Wanted {
    pub(crate) change: f64,
    /// Standard error: the larger of the model's and the jackknife's.
    pub(crate) error: f64,
    strikes: usize,
    fitted: usize,
}

impl Wanted {
    /// `residuals`: of each strike, in m; `slopes`: derivatives of each strike's track by the number. None where the strikes do not
    /// distinguish it from what was fitted.
    pub(crate) fn new(
        fitted: &Fitted,
        residuals: &[DVector<f64>],
        slopes: &[DVector<f64>],
    ) -> Option<Self> {
        let (mut scores, mut informations) = (Vec::new(), Vec::new());
        for (i, slope) in slopes.iter().enumerate() {
            let nuisances = &fitted.slopes.by_nuisance[i];
            let evidence =
                Evidence::new(false, residuals[i].clone(), nuisances, &fitted.components);
            let by_fitted = fitted.slopes.by_fitted[i].clone();
            let last = by_fitted.ncols();
            let mut all = by_fitted.insert_column(last, 0.0);
            all.set_column(last, slope);
            let weighed = evidence.weigh(&all) * fitted.weights[i];
            let bend = bend(nuisances);
            let by_bend = evidence.weigh(&bend) * fitted.weights[i];
            let (cross, own) = (all.tr_mul(&by_bend), bend.tr_mul(&by_bend)[(0, 0)]);
            let share = &cross / own.max(f64::MIN_POSITIVE);
            let pull = by_bend.tr_mul(&evidence.residual)[(0, 0)];
            informations.push(all.tr_mul(&weighed) - &share * cross.transpose());
            scores.push(weighed.tr_mul(&evidence.residual) - share.column(0) * pull);
        }
        let information: DMatrix<f64> = informations.iter().sum();
        let score: DVector<f64> = scores.iter().sum();
        let step = information.clone().cholesky()?.solve(&score);
        for (score, own) in scores.iter_mut().zip(&informations) {
            *score -= own * &step;
        }
        let last = step.len() - 1;
        Some(Self {
            change: step[last],
            error: variances(&scores, &informations, &information)?[last].sqrt(),
            strikes: slopes.len(),
            fitted: step.len(),
        })
    }

    /// Distance, in standard errors, from where it was held.
    pub(crate) fn distance(&self) -> f64 {
        (self.change / self.error).abs()
    }

    /// Standard errors beyond which a number that is right is found with this probability, to either side.
    pub(crate) fn limit(&self, probability: f64) -> f64 {
        quantile(self.strikes, self.fitted, 1.0 - probability / 2.0)
    }
}

/// Derivative of a strike's track by a bend of its path: across the path, and as the square of the way.
fn bend(nuisances: &DMatrix<f64>) -> DMatrix<f64> {
    let across = nuisances.column(ANGLE);
    let frames = across.len() / 2;
    DMatrix::from_fn(across.len(), 1, |row, _| {
        let frame = row % frames;
        across[row] * across[frame].hypot(across[frames + frame])
    })
}
