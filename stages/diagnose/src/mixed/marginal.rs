//! Products over all strikes, with the wander of friction integrated out.

use nalgebra::{DMatrix, DVector, SMatrix};

use super::{
    components::{LEAST, Small, VarianceComponents},
    products::Products,
};
use crate::wander::{PATHS, Path};

/// A Gaussian on β, to keep what the data do not determine near its start.
#[derive(Clone, Debug)]
pub(crate) struct Prior {
    /// Precision of each.
    pub(crate) precision: DVector<f64>,
    /// Mean less the value about which the model is linear.
    pub(crate) away: DVector<f64>,
}

/// Products pooled over all strikes that no variance changes.
pub(super) struct PooledProducts {
    /// [X r]ᵀ[X r].
    pub(super) xx: DMatrix<f64>,
    /// Coordinates.
    pub(super) rows: f64,
}

impl PooledProducts {
    /// Of strikes with so many common columns.
    pub(super) fn new(strikes: &[Products], p: usize) -> Self {
        let mut all = Self {
            xx: DMatrix::zeros(p + 1, p + 1),
            rows: 0.0,
        };
        for strike in strikes {
            all.xx += &strike.xx;
            all.rows += strike.rows;
        }
        all
    }
}

/// Products over all strikes, Σ without the wander.
pub(super) struct Sums {
    /// [X r]ᵀΣ⁻¹[X r].
    all: DMatrix<f64>,
    log_determinant: f64,
    /// Each strike's C.
    pub(super) posteriors: Vec<Small>,
    /// WᵀΣ⁻¹W and WᵀΣ⁻¹[X r], with W the wander's columns.
    own: SMatrix<f64, PATHS, PATHS>,
    with: DMatrix<f64>,
}

/// The same with the wander integrated out.
pub(super) struct Marginal {
    /// XᵀΣ⁻¹X, XᵀΣ⁻¹r, rᵀΣ⁻¹r, ln det Σ.
    pub(super) information: DMatrix<f64>,
    score: DVector<f64>,
    square: f64,
    log_determinant: f64,
    /// Covariance of γ at a known β.
    pub(super) spread: SMatrix<f64, PATHS, PATHS>,
    with: DMatrix<f64>,
}

/// Factors of the wander's standard deviation that are tried at each iteration: expectation and maximisation would creep.
const WANDERS: [f64; 5] = [0.5, 0.8, 1.0, 1.25, 2.0];

impl Sums {
    pub(super) fn new(
        strikes: &[Products],
        pooled: &PooledProducts,
        components: &VarianceComponents,
    ) -> Self {
        let mut sums = Self {
            all: &pooled.xx * (components.camera * components.camera).recip(),
            log_determinant: 0.0,
            posteriors: Vec::with_capacity(strikes.len()),
            own: SMatrix::zeros(),
            with: DMatrix::zeros(PATHS, pooled.xx.ncols()),
        };
        for strike in strikes {
            let (posterior, determinant) = strike.posterior(components);
            strike.subtract_explained(&posterior, components, &mut sums.all);
            let (with, own) = strike.friction(&posterior, components);
            sums.own.ger(own, &strike.path, &strike.path, 1.0);
            sums.with.ger(1.0, &strike.path, &with, 1.0);
            sums.log_determinant += determinant;
            sums.posteriors.push(posterior);
        }
        sums.all.fill_lower_triangle_with_upper_triangle();
        sums
    }

    pub(super) fn marginal(&self, wander: f64) -> Option<Marginal> {
        let p = self.all.ncols() - 1;
        let variance = wander * wander;
        let mut precision = self.own;
        for k in 0..PATHS {
            precision[(k, k)] += variance.recip();
        }
        let factor = precision.cholesky()?;
        let root: f64 = factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum();
        let spread = factor.inverse();
        let all = &self.all - self.with.tr_mul(&(spread * &self.with));
        Some(Marginal {
            information: all.view((0, 0), (p, p)).into_owned(),
            score: DVector::from_iterator(p, (0..p).map(|i| all[(i, p)])),
            square: all[(p, p)],
            log_determinant: self.log_determinant + 2.0 * root + PATHS as f64 * variance.ln(),
            spread,
            with: self.with.clone(),
        })
    }

    /// The standard deviation of the wander, near to this one, under which all is likeliest.
    pub(super) fn likeliest_wander(&self, from: &VarianceComponents, prior: &Prior) -> f64 {
        let likelihood = |wander: f64| {
            let marginal = self.marginal(wander)?;
            let beta = marginal.beta(prior)?;
            Some(marginal.likelihood(&beta))
        };
        WANDERS
            .into_iter()
            .map(|factor| (from.wander * factor).clamp(LEAST, from.greatest_wander))
            .filter_map(|wander| Some((wander, likelihood(wander)?)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map_or(from.wander, |(wander, _)| wander)
    }
}

impl Marginal {
    pub(super) fn beta(&self, prior: &Prior) -> Option<DVector<f64>> {
        let mut penalised = self.information.clone();
        let mut pull = self.score.clone();
        for i in 0..pull.len() {
            penalised[(i, i)] += prior.precision[i];
            pull[i] += prior.precision[i] * prior.away[i];
        }
        if pull.is_empty() {
            return Some(pull);
        }
        Some(penalised.cholesky()?.solve(&pull))
    }

    pub(super) fn likelihood(&self, beta: &DVector<f64>) -> f64 {
        let left =
            self.square - 2.0 * beta.dot(&self.score) + beta.dot(&(&self.information * beta));
        -0.5 * (self.log_determinant + left)
    }

    /// γ at a β.
    pub(super) fn path(&self, beta: &DVector<f64>) -> Path {
        let p = beta.len();
        let seen: Path = self.with.fixed_view::<PATHS, 1>(0, p) - self.with.columns(0, p) * beta;
        self.spread * seen
    }
}
